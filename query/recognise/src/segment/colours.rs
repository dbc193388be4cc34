//! The colours of one picture's hand and of all else in it, counted.

/// Bins along each of the two chroma axes.
const CHROMA_BINS: usize = 48;
/// Values that a chroma bin spans: the axes reach from -72 to 71, and what is more colourful shares
/// the last bin.
const CHROMA_STEP: i32 = 3;
/// Bins along the luma axis.
const LUMA_BINS: usize = 12;
const PLANE: usize = CHROMA_BINS * CHROMA_BINS;
/// A multiple of 16: see `total`.
const BINS: usize = LUMA_BINS * PLANE;

/// The histogram bin of a colour: luma, and the chroma axes B - Y and R - Y.
pub(super) fn bin([r, g, b]: [u8; 3]) -> u16 {
    let [r, g, b] = [i32::from(r), i32::from(g), i32::from(b)];
    let luma = (77 * r + 150 * g + 29 * b) >> 8;
    let last = CHROMA_BINS as i32 - 1;
    let axis = |difference: i32| (difference.div_euclid(CHROMA_STEP) + last / 2 + 1).clamp(0, last) as usize;
    let luma_bin = luma as usize * LUMA_BINS / 256;
    ((luma_bin * CHROMA_BINS + axis(b - luma)) * CHROMA_BINS + axis(r - luma)) as u16
}

/// ln(p(colour | hand) / p(colour | all else)) of every pixel's colour.
///
/// `bins` are the pixels' colours, `shares` how much each pixel is taken for hand, 0..=1, and
/// `weights` how much it counts as such. `doubt` is the share of all pixels that a bin needs before
/// it is believed.
pub(super) fn log_odds(bins: &[u16], shares: &[f32], weights: &[f32], doubt: f32) -> Vec<f32> {
    let mut other = vec![0f32; BINS];
    let mut hand = vec![0f32; BINS];
    for ((&bin, &share), &weight) in bins.iter().zip(shares).zip(weights) {
        let share = share * weight;
        hand[usize::from(bin)] += share;
        other[usize::from(bin)] += 1.0 - share;
    }
    spread(&mut other);
    spread(&mut hand);
    // Shares of all hand and of all else, so that a small hand is not held against its colour.
    let scale = |bins: &[f32]| 1.0 / total(bins).max(1e-6);
    let (of_hand, of_other) = (scale(&hand), scale(&other));
    let table: Vec<f32> = hand
        .iter()
        .zip(&other)
        .map(|(&hand, &other)| match hand + other {
            // Most bins are empty: no logarithm for them.
            0.0 => 0.0,
            _ => libm::logf((hand * of_hand + doubt) / (other * of_other + doubt)),
        })
        .collect();
    bins.iter().map(|&bin| table[usize::from(bin)]).collect()
}

/// The sum of all bins, in sixteen sums side by side: one alone would wait for every addition.
fn total(bins: &[f32]) -> f32 {
    let mut sums = [0f32; 16];
    for sixteen in bins.chunks_exact(16) {
        sums.iter_mut().zip(sixteen).for_each(|(sum, bin)| *sum += bin);
    }
    sums.iter().sum()
}

/// Spreads each bin over its neighbours with the weights 1, 2, 1, twice along each chroma axis and
/// once along luma: noise moves a pixel by a bin or so.
fn spread(bins: &mut [f32]) {
    for plane in bins.chunks_exact_mut(PLANE) {
        if plane.iter().all(|&count| count == 0.0) {
            continue;
        }
        for _ in 0..2 {
            // Most lines are empty.
            let lines = plane.chunks_exact_mut(CHROMA_BINS);
            lines.filter(|line| line.iter().any(|&count| count != 0.0)).for_each(spread_along);
            spread_across(plane, CHROMA_BINS);
        }
    }
    spread_across(bins, PLANE);
}

/// Spreads the values of one line.
fn spread_along(line: &mut [f32]) {
    let mut padded = [0f32; CHROMA_BINS + 2];
    padded[1..=CHROMA_BINS].copy_from_slice(line);
    for (out, three) in line.iter_mut().zip(padded.windows(3)) {
        *out = 0.25 * three[0] + 0.5 * three[1] + 0.25 * three[2];
    }
}

/// Spreads groups of `stride` values over the groups before and after them.
fn spread_across(bins: &mut [f32], stride: usize) {
    let mut before = vec![0f32; stride];
    let groups = bins.len() / stride;
    for group in 0..groups {
        let (here, rest) = bins[group * stride..].split_at_mut(stride);
        let after = rest.get(..stride);
        for (at, (here, before)) in here.iter_mut().zip(&mut before).enumerate() {
            let was = *here;
            *here = 0.25 * *before + 0.5 * was + 0.25 * after.map_or(0.0, |after| after[at]);
            *before = was;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreading_keeps_the_count_and_reaches_every_neighbour() {
        let mut bins = vec![0f32; BINS];
        let middle = 8 * PLANE + 10 * CHROMA_BINS + 10;
        bins[middle] = 512.0;
        spread(&mut bins);
        assert!((bins.iter().sum::<f32>() - 512.0).abs() < 1e-3);
        assert_eq!(bins[middle], 36.0);
        assert_eq!(bins[middle - PLANE + 2 * CHROMA_BINS - 2], 0.5);
    }

    #[test]
    fn every_colour_has_a_bin_and_neighbours_share_one() {
        let steps = (0..=255u8).step_by(5);
        for r in steps.clone() {
            for g in steps.clone() {
                assert!(steps.clone().all(|b| usize::from(bin([r, g, b])) < BINS));
            }
        }
        assert_eq!(bin([128, 128, 128]), bin([129, 128, 129]));
        assert_ne!(bin([128, 128, 128]), bin([150, 120, 110]));
    }

    #[test]
    fn the_colour_of_the_hand_is_told_from_the_rest() {
        let bins: Vec<u16> =
            [[180, 120, 100], [60, 90, 160]].into_iter().cycle().take(400).map(bin).collect();
        let shares: Vec<f32> = [0.9, 0.1].into_iter().cycle().take(400).collect();
        let odds = log_odds(&bins, &shares, &[1.0; 400], 1e-4);
        assert!(odds[0] > 1.5 && odds[1] < -1.5, "{odds:?}");
    }
}
