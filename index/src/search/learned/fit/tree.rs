//! The tree of hyperplanes.
//!
//! Each plane is perpendicular to the direction in which the entries that reach it vary most, and
//! cuts them at the widest gap between their 35th and 65th percentiles.

use rayon::prelude::*;

/// Entries that a direction is fitted to.
const SAMPLE: usize = 256;
const ITERATIONS: usize = 6;
/// The cut lies between these shares of the entries.
const MIDDLE: [f64; 2] = [0.35, 0.65];
/// Below that, two threads are no faster than one.
const SMALL: usize = 4096;

/// The entries by leaf: `2^planes` leaves, of which some may be empty.
#[derive(Debug)]
pub(super) struct Leaves {
    /// All ids; within a leaf they ascend.
    pub(super) ids: Vec<u32>,
    /// Where each leaf ends.
    pub(super) ends: Vec<usize>,
}

impl Leaves {
    pub(super) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| &self.ids[start..end])
    }
}

/// Grows the tree over rows of `axes` codes.
pub(super) fn grow(codes: &[i8], axes: usize, planes: u32) -> Leaves {
    let mut ids: Vec<u32> = (0..(codes.len() / axes) as u32).collect();
    let mut sizes = vec![0; 1 << planes];
    split(codes, axes, &mut ids, &mut sizes);
    let mut end = 0;
    let ends = sizes.iter().map(|size| {
        end += size;
        end
    });
    let ends = ends.collect();
    Leaves { ids, ends }
}

fn split(codes: &[i8], axes: usize, ids: &mut [u32], sizes: &mut [usize]) {
    let (below_sizes, above_sizes) = match sizes {
        [size] => {
            *size = ids.len();
            return;
        }
        sizes => sizes.split_at_mut(sizes.len() / 2),
    };
    let below = cut(codes, axes, ids);
    let (below, above) = ids.split_at_mut(below);
    if below.len() + above.len() > SMALL {
        rayon::join(|| split(codes, axes, below, below_sizes), || split(codes, axes, above, above_sizes));
    } else {
        split(codes, axes, below, below_sizes);
        split(codes, axes, above, above_sizes);
    }
}

/// Puts those below the plane first, in their order, and returns how many they are.
fn cut(codes: &[i8], axes: usize, ids: &mut [u32]) -> usize {
    if ids.len() < 2 {
        return ids.len();
    }
    let row = |id: u32| &codes[id as usize * axes..][..axes];
    let direction = direction(axes, ids, row);
    let margin = |&id: &u32| -> f32 { dot(row(id), &direction) };
    let margins: Vec<f32> = if ids.len() > SMALL {
        ids.par_iter().with_min_len(SMALL).map(margin).collect()
    } else {
        ids.iter().map(margin).collect()
    };
    let mut sorted = margins.clone();
    let at = |share: f64| ((share * ids.len() as f64) as usize).min(ids.len() - 1);
    let (first, last) = (at(MIDDLE[0]), at(MIDDLE[1]));
    sorted.select_nth_unstable_by(first, f32::total_cmp);
    let middle = &mut sorted[first..];
    middle.select_nth_unstable_by(last - first, f32::total_cmp);
    let middle = &mut middle[..=last - first];
    middle.sort_unstable_by(f32::total_cmp);
    let widest = middle.windows(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
    let limit = widest.map_or(middle[0], |pair| pair[0]);
    let is_below = |margin: f32| margin <= limit;
    let count = margins.iter().filter(|&&margin| is_below(margin)).count();
    if count == ids.len() {
        // All alike: any cut will do, and the middle keeps the tree even.
        return ids.len() / 2;
    }
    let mut above = Vec::with_capacity(ids.len() - count);
    let mut next = 0;
    for (at, &margin) in margins.iter().enumerate() {
        let id = ids[at];
        if is_below(margin) {
            ids[next] = id;
            next += 1;
        } else {
            above.push(id);
        }
    }
    ids[next..].copy_from_slice(&above);
    count
}

/// The first principal direction of some of the entries, by the power method.
fn direction<'a>(axes: usize, ids: &[u32], row: impl Fn(u32) -> &'a [i8]) -> Vec<f32> {
    let step = ids.len().div_ceil(SAMPLE);
    let mut sample: Vec<f32> = Vec::with_capacity(SAMPLE * axes);
    for &id in ids.iter().step_by(step) {
        sample.extend(row(id).iter().map(|&code| f32::from(code)));
    }
    let count = (sample.len() / axes) as f32;
    let mut mean = vec![0.0f32; axes];
    for row in sample.chunks_exact(axes) {
        mean.iter_mut().zip(row).for_each(|(mean, value)| *mean += value / count);
    }
    let mut variance = vec![0.0f32; axes];
    for row in sample.chunks_exact_mut(axes) {
        for ((value, mean), variance) in row.iter_mut().zip(&mean).zip(&mut variance) {
            *value -= mean;
            *variance += *value * *value;
        }
    }
    // The axis of the largest variance, to begin with.
    let most = (0..axes).max_by(|&a, &b| variance[a].total_cmp(&variance[b])).unwrap_or(0);
    let mut direction = vec![0.0; axes];
    direction[most] = 1.0;
    for _ in 0..ITERATIONS {
        let mut next = vec![0.0f32; axes];
        for row in sample.chunks_exact(axes) {
            let along = crate::search::distance::dot(row, &direction);
            next.iter_mut().zip(row).for_each(|(next, value)| *next += along * value);
        }
        let length = crate::search::distance::dot(&next, &next).sqrt();
        if length == 0.0 {
            break;
        }
        next.iter_mut().for_each(|value| *value /= length);
        direction = next;
    }
    direction
}

/// Four sums side by side: the compiler makes vector instructions of them.
fn dot(codes: &[i8], direction: &[f32]) -> f32 {
    let mut sums = [0.0f32; 4];
    for (codes, values) in codes.as_chunks::<4>().0.iter().zip(direction.as_chunks::<4>().0) {
        for lane in 0..4 {
            sums[lane] += f32::from(codes[lane]) * values[lane];
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}
