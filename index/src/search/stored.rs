//! The descriptors that an index keeps, by which distances are measured.

use super::exact::{self, Nearest};
use super::simd::{self, Simd};
use super::{Neighbour, Rows};
use half::f16;
use half::slice::HalfFloatSliceExt as _;
use std::borrow::Cow;

/// The descriptors of an index, as exactly as it keeps them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stored<'a> {
    pub(crate) dim: usize,
    pub(crate) entries: usize,
    pub(crate) values: Values<'a>,
}

/// Rows of values.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Values<'a> {
    /// As they were made.
    F32(&'a [f32]),
    /// Rounded to half the bits.
    F16(&'a [f16]),
    /// None: an entry's distance is known by its codes alone.
    None,
    /// In several files.
    Several(&'a dyn Several),
}

/// Several files of descriptors, whose entries are numbered on from one to the next.
pub(crate) trait Several: std::fmt::Debug + Sync {
    /// The file of an entry, and its number there.
    fn of(&self, id: u32) -> Option<(Stored<'_>, u32)>;

    /// All files, each with the number of its first entry.
    fn all(&self) -> Vec<(u32, Stored<'_>)>;
}

impl<'a> From<Rows<'a>> for Stored<'a> {
    fn from(rows: Rows<'a>) -> Self {
        Self { dim: rows.dim, entries: rows.len(), values: Values::F32(rows.values) }
    }
}

impl<'a> Stored<'a> {
    pub(crate) fn are_kept(&self) -> bool {
        !matches!(self.values, Values::None)
    }

    /// The descriptor of an entry; `None` where there is no such entry or none is kept.
    pub(crate) fn get(&self, id: u32) -> Option<Cow<'a, [f32]>> {
        match self.values {
            Values::F32(values) => row_of(values, self.dim, id).map(Cow::Borrowed),
            Values::F16(values) => row_of(values, self.dim, id).map(|row| Cow::Owned(row.to_f32_vec())),
            Values::None => None,
            Values::Several(several) => several.of(id).and_then(|(stored, id)| stored.get(id)),
        }
    }

    /// The same, widened to `row` where need be.
    fn row<'r>(&self, id: u32, row: &'r mut Vec<f32>) -> Option<&'r [f32]>
    where
        'a: 'r,
    {
        match self.values {
            Values::F32(values) => row_of(values, self.dim, id),
            Values::F16(values) => {
                row.resize(self.dim, 0.0);
                row_of(values, self.dim, id)?.convert_to_f32_slice(row);
                Some(row)
            }
            Values::None => None,
            Values::Several(several) => several.of(id).and_then(|(stored, id)| stored.row(id, row)),
        }
    }

    /// Measures the squared distances of some entries. An id past the last entry, as a damaged file may hold, has none.
    pub(crate) fn measure(
        &self,
        simd: Simd,
        query: &[f32],
        ids: &[u32],
        row: &mut Vec<f32>,
        nearest: &mut Nearest,
    ) {
        match self.values {
            Values::F32(values) => {
                let rows = Rows { values, dim: self.dim };
                let known = ids.iter().map(|&id| rows.get(id).unwrap_or(&[]));
                simd.distances(query, known, |at, squared| {
                    if let Some(&id) = ids.get(at).filter(|&&id| (id as usize) < self.entries) {
                        nearest.offer(id, squared);
                    }
                });
            }
            Values::F16(_) | Values::Several(_) => {
                for &id in ids {
                    if let Some(row) = self.row(id, row) {
                        simd.distances(query, [row].into_iter(), |_, squared| nearest.offer(id, squared));
                    }
                }
            }
            Values::None => {}
        }
    }

    /// The bytes of a descriptor; none where there is no such entry or none is kept.
    pub(crate) fn part(&self, id: u32) -> &'a [u8] {
        let part: Option<&[u8]> = match self.values {
            Values::F32(values) => row_of(values, self.dim, id).map(bytemuck::cast_slice),
            Values::F16(values) => row_of(values, self.dim, id).map(bytemuck::cast_slice),
            Values::None => None,
            Values::Several(several) => several.of(id).map(|(stored, id)| stored.part(id)),
        };
        part.unwrap_or(&[])
    }

    /// Asks the memory for the descriptors that will be measured.
    pub(crate) fn prefetch(&self, ids: &[u32]) {
        // More than that would drive out each other.
        const MOST: usize = 64;
        for &id in ids.iter().take(MOST) {
            simd::prefetch_all(self.part(id));
        }
    }

    /// The k nearest of all entries; `None` where no descriptors are kept.
    pub(crate) fn nearest(&self, query: &[f32], k: usize) -> Option<Vec<Neighbour>> {
        match self.values {
            Values::F32(values) => Some(exact::nearest(Rows { values, dim: self.dim }, query, k)),
            Values::F16(_) => {
                let mut nearest = Nearest::new(k);
                let ids: Vec<u32> = (0..self.entries as u32).collect();
                self.measure(Simd::best(), query, &ids, &mut Vec::new(), &mut nearest);
                Some(nearest.neighbours().collect())
            }
            Values::None => None,
            Values::Several(several) => {
                let mut found = Vec::new();
                for (start, stored) in several.all() {
                    let numbered = |near: Neighbour| Neighbour { id: near.id.saturating_add(start), ..near };
                    found.extend(stored.nearest(query, k)?.into_iter().map(numbered));
                }
                found.sort_unstable_by(Neighbour::by_distance);
                found.truncate(k);
                Some(found)
            }
        }
    }
}

fn row_of<T>(values: &[T], dim: usize, id: u32) -> Option<&[T]> {
    let start = (id as usize).checked_mul(dim)?;
    values.get(start..start.checked_add(dim)?)
}
