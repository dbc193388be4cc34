//! Connected regions of a mask, and which of them is the hand.

use super::{Mask, distance};

/// The fewest pixels that can show a hand: about 12 x 12.
pub const MIN_PIXELS: usize = 144;

/// Log-odds above which a pixel is no surer: one bright spot does not make a hand.
const MOST_SURE: f32 = 4.0;

/// One 8-connected region.
pub(super) struct Region {
    pub(super) label: u32,
    pub(super) area: usize,
    /// Sum of the values of its pixels.
    sum: f64,
    /// How many pixels lie on the picture's border.
    pub(super) on_border: usize,
}

/// The largest 8-connected region, its holes as they are; `None` where it has fewer than `smallest`
/// pixels.
pub fn largest(mask: &Mask, smallest: usize) -> Option<Mask> {
    best(mask, |_| 1.0, |region| region.area as f64, smallest)
}

/// The region that is most like a hand: large, surely skin, and not a background that follows the
/// picture's border.
///
/// `odds` are the log-odds of skin, one a pixel. `None` where every region has fewer than
/// `smallest` pixels.
pub fn most_hand_like(mask: &Mask, odds: &[f32], smallest: usize) -> Option<Mask> {
    let perimeter = (2 * (mask.width() + mask.height())) as f64;
    let confidence = |index: usize| f64::from(odds.get(index).copied().unwrap_or(0.0).clamp(0.0, MOST_SURE));
    best(
        mask,
        confidence,
        |region| {
            // An arm crosses the border once; a wooden floor runs along it.
            let along = region.on_border as f64 / perimeter;
            region.sum * (1.0 - along).max(0.0).powi(4)
        },
        smallest,
    )
}

/// The mask without the regions that have less than a hundredth of its area.
pub fn without_specks(mask: &Mask) -> Mask {
    let (labels, regions) = label(mask, |_| 0.0);
    let least = mask.area() / 100;
    Mask::from_values(mask.width(), mask.height(), &labels, |label| {
        label > 0 && regions.get(label as usize - 1).is_some_and(|region| region.area >= least)
    })
}

/// What makes another region part of the hand that was found: a finger cut off by what the hand
/// holds, or the arm beyond a bracelet.
#[derive(Clone, Debug, PartialEq)]
pub struct CompanionParams {
    /// Log-odds of skin, by colour, that its pixels have.
    pub likely: f32,
    /// The least area, as a share of the hand's.
    pub least: f32,
    /// The largest distance from the hand, in radii of a disc of the hand's area.
    pub distance: f32,
    /// The least mean of its log-odds, as a share of the hand's.
    pub alike: f32,
    /// The longest way along the picture's border, in the same radii: an arm crosses it, a table
    /// follows it.
    pub border: f32,
}

impl Default for CompanionParams {
    fn default() -> Self {
        Self { likely: 0.5, least: 0.01, distance: 3.0, alike: 0.5, border: 2.5 }
    }
}

/// The hand with the regions of the same colour that belong to it.
///
/// `odds` are the log-odds of skin by colour, one a pixel.
pub fn with_companions(hand: &Mask, odds: &[f32], params: &CompanionParams) -> Mask {
    let (width, height, area) = (hand.width(), hand.height(), hand.area());
    let radius = (area as f32 / std::f32::consts::PI).sqrt();
    let value = |index: usize| f64::from(odds.get(index).copied().unwrap_or(0.0).min(MOST_SURE));
    let likely: Vec<u8> = hand
        .pixels()
        .iter()
        .zip(odds)
        .map(|(&inside, &odds)| u8::from(inside == 0 && odds > params.likely))
        .collect();
    let (labels, regions) = label(&Mask::from_values(width, height, &likely, |v| v == 1), value);
    let mean = hand.pixels().iter().enumerate().filter(|(_, inside)| **inside != 0);
    let mean = mean.map(|(index, _)| value(index)).sum::<f64>() / area.max(1) as f64;
    let mut belongs: Vec<bool> = regions
        .iter()
        .map(|region| {
            (params.least * area as f32..=area as f32).contains(&(region.area as f32))
                && region.sum / region.area as f64 >= f64::from(params.alike) * mean
                && region.on_border as f32 <= params.border * radius
        })
        .collect();
    // Mostly there is none, and no distance has to be known.
    if !belongs.contains(&true) {
        return hand.clone();
    }
    let thirds = distance::thirds(width, height, |at| hand.pixels()[at] != 0, false);
    let mut nearest = vec![u32::MAX; regions.len()];
    for (&label, &thirds) in labels.iter().zip(&thirds) {
        if let Some(nearest) = (label as usize).checked_sub(1).and_then(|region| nearest.get_mut(region)) {
            *nearest = thirds.min(*nearest);
        }
    }
    for (belongs, nearest) in belongs.iter_mut().zip(nearest) {
        *belongs &= nearest as f32 <= 3.0 * params.distance * radius;
    }
    let kept = labels
        .iter()
        .zip(hand.pixels())
        .map(|(&label, &inside)| {
            let joined = (label as usize).checked_sub(1).and_then(|region| belongs.get(region));
            inside | u8::from(joined == Some(&true))
        })
        .collect();
    Mask::from_inside(width, height, kept)
}

fn best(
    mask: &Mask,
    value: impl Fn(usize) -> f64,
    score: impl Fn(&Region) -> f64,
    smallest: usize,
) -> Option<Mask> {
    let (labels, regions) = label(mask, value);
    let chosen = regions
        .iter()
        .filter(|region| region.area >= smallest)
        // The first of equals: `max_by` alone would take the last.
        .rev()
        .max_by(|a, b| score(a).total_cmp(&score(b)))?;
    Some(Mask::from_values(mask.width(), mask.height(), &labels, |label| label == chosen.label))
}

/// Numbers the regions from 1, in the order of their first pixel, by flooding.
pub(super) fn label(mask: &Mask, value: impl Fn(usize) -> f64) -> (Vec<u32>, Vec<Region>) {
    let (width, height) = (mask.width(), mask.height());
    let pixels = mask.pixels();
    let mut labels = vec![0u32; pixels.len()];
    let mut regions: Vec<Region> = Vec::new();
    let mut open = Vec::new();
    for start in 0..pixels.len() {
        if pixels[start] == 0 || labels[start] != 0 {
            continue;
        }
        let mut region = Region { label: regions.len() as u32 + 1, area: 0, sum: 0.0, on_border: 0 };
        labels[start] = region.label;
        open.push(start);
        while let Some(index) = open.pop() {
            let (x, y) = (index % width, index / width);
            region.area += 1;
            region.sum += value(index);
            region.on_border += usize::from(x == 0 || y == 0 || x + 1 == width || y + 1 == height);
            for ny in y.saturating_sub(1)..=(y + 1).min(height - 1) {
                for nx in x.saturating_sub(1)..=(x + 1).min(width - 1) {
                    let next = ny * width + nx;
                    if pixels[next] != 0 && labels[next] == 0 {
                        labels[next] = region.label;
                        open.push(next);
                    }
                }
            }
        }
        regions.push(region);
    }
    (labels, regions)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Gives every pixel its own number and takes minima over neighbours until nothing changes.
    fn naive_largest(mask: &Mask) -> usize {
        let (width, height) = (mask.width(), mask.height());
        let mut number: Vec<usize> = (0..width * height).collect();
        loop {
            let before = number.clone();
            for y in 0..height {
                for x in 0..width {
                    for (ny, nx) in (0..height).flat_map(|ny| (0..width).map(move |nx| (ny, nx))) {
                        let touch = nx.abs_diff(x) <= 1 && ny.abs_diff(y) <= 1;
                        if touch && mask.get(x, y) && mask.get(nx, ny) {
                            number[y * width + x] = number[y * width + x].min(number[ny * width + nx]);
                        }
                    }
                }
            }
            if number == before {
                break;
            }
        }
        (0..width * height)
            .map(|root| {
                (0..width * height).filter(|&i| mask.get(i % width, i / width) && number[i] == root).count()
            })
            .max()
            .unwrap_or(0)
    }

    proptest! {
        #[test]
        fn the_largest_region_is_a_region_and_none_is_larger(
            (width, height, pixels) in crate::segment::tests_support::grids(0..2u8, 9),
        ) {
            let mask = Mask::from_values(width, height, &pixels, |v| v == 1);
            let expected = naive_largest(&mask);
            match largest(&mask, 1) {
                Some(found) => {
                    prop_assert_eq!(found.area(), expected);
                    prop_assert_eq!(naive_largest(&found), expected, "it is one region");
                    prop_assert!(found.pixels().iter().zip(mask.pixels()).all(|(f, m)| f <= m));
                }
                None => prop_assert_eq!(expected, 0),
            }
        }
    }

    #[test]
    fn a_hand_wins_over_a_larger_background_along_the_border() {
        let (width, height) = (60, 60);
        let mut pixels = vec![0u8; width * height];
        for y in 0..height {
            for x in 0..width {
                let frame = y < 8 || x < 8 || y >= height - 8;
                let hand = (20..48).contains(&x) && (18..42).contains(&y);
                pixels[y * width + x] = u8::from(frame || hand);
            }
        }
        let mask = Mask::from_values(width, height, &pixels, |v| v == 1);
        let hand = most_hand_like(&mask, &vec![2.0; width * height], MIN_PIXELS).unwrap();
        assert_eq!(hand.area(), 28 * 24);
        assert!(hand.get(30, 30));
    }

    /// A hand of 20 x 20, a finger beyond what it holds, and a table along the border.
    fn hand_finger_and_table(odds_of_finger: f32) -> (Mask, Vec<f32>) {
        let (width, height) = (80, 60);
        let mut pixels = vec![0u8; width * height];
        let mut odds = vec![-2.0; width * height];
        for y in 0..height {
            for x in 0..width {
                let hand = (20..40).contains(&x) && (20..40).contains(&y);
                let finger = (50..54).contains(&x) && (24..36).contains(&y);
                pixels[y * width + x] = u8::from(hand);
                if hand || y > 55 {
                    odds[y * width + x] = 3.0;
                }
                if finger {
                    odds[y * width + x] = odds_of_finger;
                }
            }
        }
        (Mask::from_values(width, height, &pixels, |v| v == 1), odds)
    }

    #[test]
    fn a_finger_beyond_the_object_joins_its_hand_and_a_table_does_not() {
        let (hand, odds) = hand_finger_and_table(2.5);
        let whole = with_companions(&hand, &odds, &CompanionParams::default());
        assert_eq!(whole.area(), 20 * 20 + 4 * 12);
        assert!(whole.get(52, 30) && !whole.get(40, 58));
    }

    #[test]
    fn a_thing_of_another_colour_does_not_join() {
        let (hand, odds) = hand_finger_and_table(0.7);
        assert_eq!(with_companions(&hand, &odds, &CompanionParams::default()), hand);
    }

    #[test]
    fn specks_are_no_hand() {
        let mask = Mask::from_values(20, 20, &[1u8; 100], |v| v == 1);
        assert!(largest(&mask, MIN_PIXELS).is_none());
    }
}
