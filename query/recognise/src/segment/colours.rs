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

/// The bins of one chroma axis, red's.
type Line = [f32; CHROMA_BINS];

/// The colours of one picture, ready to be counted.
///
/// A picture has a few hundred of them: its pixels are counted by colour, and only the part of the
/// histogram that these colours reach is looked at.
pub(super) struct Colours {
    /// Which of the picture's colours each pixel has.
    pixels: Vec<u16>,
    /// Of each colour, how much is hand and how much all else.
    counts: Vec<[f32; 2]>,
    /// Of each colour, ln(p(colour | hand) / p(colour | all else)).
    odds: Vec<f32>,
    /// Of each colour, its bin among the lines that are reached.
    places: Vec<usize>,
    /// The planes that have a colour among those that are reached, and the lines of each.
    planes: Range<usize>,
    lines: usize,
    /// The histograms of the hand and of all else: lines that are reached, plane by plane.
    hand: Vec<Line>,
    other: Vec<Line>,
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
            line * CHROMA_BINS + bin % CHROMA_BINS
        });
        let reached = planes.len() * lines.len();
        Self {
            pixels: bins.iter().map(|&bin| numbers[usize::from(bin)]).collect(),
            counts: vec![[0.0; 2]; present.len()],
            odds: vec![0.0; present.len()],
            places: places.collect(),
            planes: first - planes.start..last + 1 - planes.start,
            lines: lines.len(),
            hand: vec![[0.0; CHROMA_BINS]; reached],
            other: vec![[0.0; CHROMA_BINS]; reached],
        }
    }

    /// ln(p(colour | hand) / p(colour | all else)) of every pixel's colour.
    ///
    /// `shares` are how much each pixel is taken for hand, 0..=1. `doubt` is the share of all
    /// pixels that a bin needs before it is believed.
    pub(super) fn log_odds(&mut self, shares: &[f32], doubt: f32) -> impl Iterator<Item = f32> {
        self.counts.fill([0.0; 2]);
        for (&colour, &share) in self.pixels.iter().zip(shares) {
            let [hand, other] = &mut self.counts[usize::from(colour)];
            *hand += share;
            *other += 1.0 - share;
        }
        for (histogram, side) in [(&mut self.hand, 0), (&mut self.other, 1)] {
            histogram.fill([0.0; CHROMA_BINS]);
            let bins = histogram.as_flattened_mut();
            self.places.iter().zip(&self.counts).for_each(|(&place, counts)| bins[place] = counts[side]);
            spread(histogram, self.lines, self.planes.clone());
        }
        // Shares of all hand and of all else, so that a small hand is not held against its colour.
        let scale = |lines: &[Line]| 1.0 / total(lines).max(1e-6);
        let (of_hand, of_other) = (scale(&self.hand), scale(&self.other));
        let (hand, other) = (self.hand.as_flattened(), self.other.as_flattened());
        for (odds, &place) in self.odds.iter_mut().zip(&self.places) {
            *odds = libm::logf((hand[place] * of_hand + doubt) / (other[place] * of_other + doubt));
        }
        self.pixels.iter().map(|&colour| self.odds[usize::from(colour)])
    }
}

/// The sum of all bins, in sixteen sums side by side: one alone would wait for every addition.
fn total(lines: &[Line]) -> f32 {
    let mut sums = [0f32; 16];
    for sixteen in lines.as_flattened().as_chunks::<16>().0 {
        sums.iter_mut().zip(sixteen).for_each(|(sum, bin)| *sum += bin);
    }
    sums.iter().sum()
}

/// Spreads each bin over its neighbours with the weights 1, 2, 1, twice along each chroma axis and
/// once along luma: noise moves a pixel by a bin or so.
///
/// `histogram` has planes of so many `lines`, of which the `filled` ones have counts.
fn spread(histogram: &mut [Line], lines: usize, filled: Range<usize>) {
    for plane in filled {
        let plane = &mut histogram[plane * lines..][..lines];
        for _ in 0..2 {
            plane.iter_mut().for_each(spread_along);
            spread_across(plane, 0, 1);
        }
    }
    (0..lines).for_each(|line| spread_across(histogram, line, lines));
}

/// Spreads the values of one line.
fn spread_along(line: &mut Line) {
    let mut padded = [0f32; CHROMA_BINS + 2];
    padded[1..=CHROMA_BINS].copy_from_slice(line);
    let [before, here, after] = [0, 1, 2].map(|first| &padded[first..first + CHROMA_BINS]);
    for (out, ((before, here), after)) in line.iter_mut().zip(before.iter().zip(here).zip(after)) {
        *out = 0.25 * before + 0.5 * here + 0.25 * after;
    }
}

/// Spreads lines over those before and after them: each `stride`-th from the line `first` on.
fn spread_across(lines: &mut [Line], first: usize, stride: usize) {
    let mut before = [0f32; CHROMA_BINS];
    for at in (first..lines.len()).step_by(stride) {
        let after = lines.get(at + stride).copied().unwrap_or([0.0; CHROMA_BINS]);
        let here = lines[at];
        for (out, ((before, here), after)) in lines[at].iter_mut().zip(before.iter().zip(&here).zip(&after)) {
            *out = 0.25 * before + 0.5 * here + 0.25 * after;
        }
        before = here;
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
            histograms[0][usize::from(bin)] += share;
            histograms[1][usize::from(bin)] += 1.0 - share;
        }
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
