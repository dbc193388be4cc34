//! The colours of one picture's hand and of all else in it, counted.

use std::ops::Range;

/// Bins along each of the two chroma axes.
const CHROMA_BINS: usize = 48;
/// Values that a chroma bin spans: the axes reach from -72 to 71, and what is more colourful shares
/// the last bin.
const CHROMA_STEP: i32 = 3;
/// Bins along the luma axis.
const LUMA_BINS: usize = 12;
const PLANE: usize = CHROMA_BINS * CHROMA_BINS;
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

/// Zeros before and after the bins of a line: what lies beyond either end.
const GAP: usize = 16;
/// From the bins of a line to those of the next.
const STRIDE: usize = GAP + CHROMA_BINS;
/// The bins of one chroma axis, red's, after a gap; the gap of the next line ends them.
type Line = [f32; STRIDE];

/// Steps of a pixel's share of the hand. Sums of integers are the same in any order.
const STEPS: f32 = 65_536.0;
/// Sums of a colour's pixels that are kept side by side: neighbours mostly have one colour, and one
/// sum alone would wait for every addition.
const SUMS: usize = 4;

/// The colours of one picture, ready to be counted.
///
/// A picture has a few hundred of them: its pixels are counted by colour, and only the part of the
/// histogram that these colours reach is looked at.
pub(super) struct Colours {
    /// Which of the picture's colours each pixel has.
    pixels: Vec<u16>,
    /// Of each colour, how many pixels have it.
    counts: Vec<u64>,
    /// Of each colour, how much of that is hand, in steps.
    sums: Vec<[u64; SUMS]>,
    /// Of each colour, ln(p(colour | hand) / p(colour | all else)).
    odds: Vec<f32>,
    /// Of each colour, its bin among the lines that are reached.
    places: Vec<usize>,
    /// The histograms of the hand and of all else.
    hand: Histogram,
    other: Histogram,
}

impl Colours {
    /// Those of a picture whose pixels have these bins.
    pub(super) fn of(bins: &[u16]) -> Self {
        let mut numbers = vec![0u16; BINS];
        bins.iter().for_each(|&bin| numbers[usize::from(bin)] = 1);
        let present: Vec<usize> = (0..BINS).filter(|&bin| numbers[bin] != 0).collect();
        present.iter().zip(0..).for_each(|(&bin, number)| numbers[bin] = number);
        let line_of = |bin: usize| bin % PLANE / CHROMA_BINS;
        let reached = |first: usize, last: usize, by: usize, all: usize| {
            first.saturating_sub(by)..(last + by + 1).min(all)
        };
        let [first, last] = [present.first(), present.last()].map(|bin| bin.map_or(0, |bin| bin / PLANE));
        let planes = reached(first, last, 1, LUMA_BINS);
        let low = present.iter().map(|&bin| line_of(bin)).min().unwrap_or(0);
        let high = present.iter().map(|&bin| line_of(bin)).max().unwrap_or(0);
        let lines = reached(low, high, 2, CHROMA_BINS);
        let places = present.iter().map(|&bin| {
            let line = (bin / PLANE - planes.start) * lines.len() + line_of(bin) - lines.start;
            line * STRIDE + GAP + bin % CHROMA_BINS
        });
        let empty = Histogram::new(planes.len(), lines.len(), first - planes.start..last + 1 - planes.start);
        let pixels: Vec<u16> = bins.iter().map(|&bin| numbers[usize::from(bin)]).collect();
        let mut sums = vec![[0; SUMS]; present.len()];
        add(&mut sums, &pixels, pixels.iter().map(|_| 1));
        Self {
            pixels,
            counts: sums.iter().map(|sums| sums.iter().sum()).collect(),
            sums,
            odds: vec![0.0; present.len()],
            places: places.collect(),
            hand: empty.clone(),
            other: empty,
        }
    }

    /// ln(p(colour | hand) / p(colour | all else)) of every pixel's colour.
    ///
    /// `shares` are how much each pixel is taken for hand, 0..=1. `doubt` is the share of all
    /// pixels that a bin needs before it is believed.
    pub(super) fn log_odds(&mut self, shares: &[f32], doubt: f32) -> impl Iterator<Item = f32> {
        self.sums.fill([0; SUMS]);
        add(&mut self.sums, &self.pixels, shares.iter().map(|share| (share * STEPS) as u64));
        let hands = self.sums.iter().map(|sums| sums.iter().sum::<u64>() as f32 / STEPS);
        let counted = hands.zip(&self.counts).map(|(hand, &all)| [hand, all as f32 - hand]);
        let [hand, other] = [&mut self.hand, &mut self.other].map(Histogram::cleared);
        for (&place, [is_hand, is_other]) in self.places.iter().zip(counted) {
            (hand[place], other[place]) = (is_hand, is_other);
        }
        // Shares of all hand and of all else, so that a small hand is not held against its colour.
        let [hand, other] = [&mut self.hand, &mut self.other].map(Histogram::spread);
        let (of_hand, of_other) = (1.0 / total(hand).max(1e-6), 1.0 / total(other).max(1e-6));
        for (odds, &place) in self.odds.iter_mut().zip(&self.places) {
            *odds = libm::logf((hand[place] * of_hand + doubt) / (other[place] * of_other + doubt));
        }
        self.pixels.iter().map(|&colour| self.odds[usize::from(colour)])
    }
}

/// Adds what each pixel counts to the sums of its colour.
fn add(sums: &mut [[u64; SUMS]], pixels: &[u16], counts: impl Iterator<Item = u64>) {
    for ((&colour, count), sum) in pixels.iter().zip(counts).zip((0..SUMS).cycle()) {
        sums[usize::from(colour)][sum] += count;
    }
}

/// The sum of all bins, in sixteen sums side by side: one alone would wait for every addition.
fn total(bins: &[f32]) -> f32 {
    let mut sums = [0f32; 16];
    for sixteen in bins.as_chunks::<16>().0 {
        sums.iter_mut().zip(sixteen).for_each(|(sum, bin)| *sum += bin);
    }
    sums.iter().sum()
}

/// Counts of colours, plane by plane, of the lines that are reached.
#[derive(Clone)]
struct Histogram {
    /// With a line more, whose gap ends the last one.
    lines: Vec<Line>,
    /// What spreading writes to, of the same size: what has just been written is slow to read a bin
    /// aside.
    spare: Vec<Line>,
    /// Lines of a plane.
    of_plane: usize,
    /// The planes that have counts.
    filled: Range<usize>,
}

impl Histogram {
    fn new(planes: usize, of_plane: usize, filled: Range<usize>) -> Self {
        let lines = vec![[0.0; STRIDE]; planes * of_plane + 1];
        Self { spare: lines.clone(), lines, of_plane, filled }
    }

    /// All bins, gaps among them, as 0.
    fn cleared(&mut self) -> &mut [f32] {
        self.lines.fill([0.0; STRIDE]);
        self.lines.as_flattened_mut()
    }

    /// Spreads each bin over its neighbours with the weights 1, 2, 1, twice along each chroma axis
    /// and once along luma: noise moves a pixel by a bin or so.
    fn spread(&mut self) -> &[f32] {
        for plane in self.filled.clone() {
            let first = plane * self.of_plane;
            for _ in 0..2 {
                // A line more: the gap that ends the last one.
                let from = self.lines[first..=first + self.of_plane].as_flattened();
                let plane = first..first + self.of_plane;
                spread_along(from, &mut self.spare[plane.clone()]);
                spread_across(&self.spare[plane.clone()], &mut self.lines[plane], 1);
            }
        }
        let all = self.lines.len() - 1;
        spread_across(&self.lines[..all], &mut self.spare[..all], self.of_plane);
        std::mem::swap(&mut self.lines, &mut self.spare);
        self.lines.as_flattened()
    }
}

/// Spreads the bins of each line; `from` are the lines with a gap after them.
fn spread_along(from: &[f32], to: &mut [Line]) {
    for (at, to) in (GAP..).step_by(STRIDE).zip(to) {
        let [before, here, after] = [at - 1, at, at + 1].map(|first| &from[first..first + CHROMA_BINS]);
        for (out, ((before, here), after)) in to[GAP..].iter_mut().zip(before.iter().zip(here).zip(after)) {
            *out = 0.25 * before + 0.5 * here + 0.25 * after;
        }
    }
}

/// Spreads each line over those that lie `stride` before and after it.
fn spread_across(from: &[Line], to: &mut [Line], stride: usize) {
    const NONE: Line = [0.0; STRIDE];
    for (at, (here, to)) in from.iter().zip(to).enumerate() {
        let before = at.checked_sub(stride).map_or(&NONE, |before| &from[before]);
        let after = from.get(at + stride).unwrap_or(&NONE);
        for (out, ((before, here), after)) in to.iter_mut().zip(before.iter().zip(here).zip(after)) {
            *out = 0.25 * before + 0.5 * here + 0.25 * after;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The same by the whole histogram, a bin at a time.
    fn naive(bins: &[u16], shares: &[f32], doubt: f32) -> Vec<f32> {
        let mut histograms = [vec![0f32; BINS], vec![0f32; BINS]];
        for (&bin, &share) in bins.iter().zip(shares) {
            histograms[0][usize::from(bin)] += (share * STEPS).floor() / STEPS;
            histograms[1][usize::from(bin)] += 1.0;
        }
        let [hand, other] = &mut histograms;
        other.iter_mut().zip(hand).for_each(|(other, hand)| *other -= *hand);
        let axes = [(1, CHROMA_BINS), (CHROMA_BINS, CHROMA_BINS), (PLANE, LUMA_BINS)];
        for histogram in &mut histograms {
            for (stride, length) in [axes[0], axes[1], axes[0], axes[1], axes[2]] {
                let was = histogram.clone();
                for (at, bin) in histogram.iter_mut().enumerate() {
                    let place = at / stride % length;
                    let before = if place > 0 { was[at - stride] } else { 0.0 };
                    let after = if place + 1 < length { was[at + stride] } else { 0.0 };
                    *bin = 0.25 * before + 0.5 * was[at] + 0.25 * after;
                }
            }
        }
        let [hand, other] = &histograms;
        let total = |bins: &[f32]| {
            let sums: [f32; 16] = std::array::from_fn(|lane| bins.iter().skip(lane).step_by(16).sum());
            sums.iter().sum::<f32>().max(1e-6)
        };
        let (of_hand, of_other) = (1.0 / total(hand), 1.0 / total(other));
        let odds = bins.iter().map(|&bin| {
            let bin = usize::from(bin);
            libm::logf((hand[bin] * of_hand + doubt) / (other[bin] * of_other + doubt))
        });
        odds.collect()
    }

    proptest! {
        #[test]
        fn it_is_what_the_whole_histogram_gives_to_the_last_bit(
            pixels in proptest::collection::vec((any::<[u8; 3]>(), 0.0f32..=1.0), 1..60),
        ) {
            let bins: Vec<u16> = pixels.iter().map(|(rgb, _)| bin(*rgb)).collect();
            let shares: Vec<f32> = pixels.iter().map(|(_, share)| *share).collect();
            let mut colours = Colours::of(&bins);
            // Twice: what was counted before is gone.
            let _ = colours.log_odds(&shares, 1e-3).count();
            let found: Vec<f32> = colours.log_odds(&shares, 1e-3).collect();
            prop_assert_eq!(found, naive(&bins, &shares, 1e-3));
        }
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
        let odds: Vec<f32> = Colours::of(&bins).log_odds(&shares, 1e-4).collect();
        assert!(odds[0] > 1.5 && odds[1] < -1.5, "{odds:?}");
    }
}
