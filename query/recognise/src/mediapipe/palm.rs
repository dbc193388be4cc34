//! What the palm network says: where palms are, and which way they point.

use super::anchors::{self, COUNT};

/// Pixels a side of what it looks at.
pub(crate) const PALM_SIDE: usize = 192;
/// Values of an answer: the box's middle and size, then seven points, in pixels.
pub(super) const VALUES: usize = 4 + 2 * POINTS;
const POINTS: usize = 7;
/// Of the points, the wrist and the middle finger's knuckle.
const WRIST: usize = 0;
const KNUCKLE: usize = 2;
/// The least probability of a palm, and the least overlap of two answers about the same one.
const LEAST: f64 = 0.3;
const SAME: f64 = 0.3;
/// Logits beyond this say no more.
const MOST: f64 = 100.0;

/// A palm in the square that was looked at; places are shares of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Palm {
    /// How probably it is one.
    pub(crate) score: f64,
    /// The middle of the upright box around it.
    pub(crate) middle: [f64; 2],
    /// The box's width and height.
    pub(crate) size: [f64; 2],
    points: [[f64; 2]; POINTS],
}

impl Palm {
    pub(crate) fn wrist(&self) -> [f64; 2] {
        self.points[WRIST]
    }

    /// The middle finger's knuckle.
    pub(crate) fn knuckle(&self) -> [f64; 2] {
        self.points[KNUCKLE]
    }

    /// The share of what either box covers that both do.
    fn overlap(&self, other: &Self) -> f64 {
        let both: f64 = [0, 1]
            .map(|i| {
                let end = |palm: &Self, sign: f64| palm.middle[i] + sign * 0.5 * palm.size[i];
                (end(self, 1.0).min(end(other, 1.0)) - end(self, -1.0).max(end(other, -1.0))).max(0.0)
            })
            .iter()
            .product();
        let area = |palm: &Self| palm.size[0] * palm.size[1];
        both / (area(self) + area(other) - both).max(f64::MIN_POSITIVE)
    }

    /// The weighted mean of several answers about one palm, as likely as the likeliest of them.
    fn mean(palms: &[Self]) -> Option<Self> {
        let first = palms.first()?;
        let total: f64 = palms.iter().map(|palm| palm.score).sum();
        let mean = |place: &dyn Fn(&Self) -> [f64; 2]| {
            [0, 1].map(|i| palms.iter().map(|palm| palm.score * place(palm)[i]).sum::<f64>() / total)
        };
        Some(Self {
            score: first.score,
            middle: mean(&|palm| palm.middle),
            size: mean(&|palm| palm.size),
            points: std::array::from_fn(|at| mean(&|palm| palm.points[at])),
        })
    }
}

/// The palms of an answer, likeliest first: of each place [`VALUES`] of a box and one logit.
pub(super) fn palms(boxes: &[f32], logits: &[f32]) -> Vec<Palm> {
    let answers = boxes.chunks_exact(VALUES).zip(logits).zip(anchors::middles());
    let mut palms: Vec<Palm> = answers.filter_map(|((shape, logit), at)| palm(shape, *logit, at)).collect();
    palms.sort_by(|a, b| b.score.total_cmp(&a.score));
    merged(palms)
}

/// How many values and logits an answer has.
pub(super) const SIZES: [usize; 2] = [COUNT * VALUES, COUNT];

/// One palm about a cell, where it is likely and somewhere.
fn palm(shape: &[f32], logit: f32, cell: [f64; 2]) -> Option<Palm> {
    let score = 1.0 / (1.0 + libm::exp(-f64::from(logit).clamp(-MOST, MOST)));
    let pair = |at: usize| [0, 1].map(|i| f64::from(shape[at + i]) / PALM_SIDE as f64);
    let place = |at: usize| [0, 1].map(|i| cell[i] + pair(at)[i]);
    let (middle, size) = (place(0), pair(2));
    let is_sound = shape.iter().all(|v| v.is_finite()) && size.iter().all(|v| *v > 0.0);
    // A logit that is no number makes a score that is none.
    (score >= LEAST && is_sound).then(|| Palm {
        score,
        middle,
        size,
        points: std::array::from_fn(|point| place(4 + 2 * point)),
    })
}

/// One palm in place of all answers about it; the likeliest come first, before and after.
fn merged(mut palms: Vec<Palm>) -> Vec<Palm> {
    let mut found = Vec::new();
    while let Some(first) = palms.first().cloned() {
        let (same, others): (Vec<_>, Vec<_>) =
            palms.drain(..).partition(|palm| *palm == first || palm.overlap(&first) > SAME);
        found.extend(Palm::mean(&same));
        palms = others;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn answer(at: &[(usize, f32, [f32; VALUES])]) -> Vec<Palm> {
        let (mut boxes, mut logits) = (vec![0.0; COUNT * VALUES], vec![-20.0; COUNT]);
        for (at, logit, shape) in at {
            boxes[at * VALUES..(at + 1) * VALUES].copy_from_slice(shape);
            logits[*at] = *logit;
        }
        palms(&boxes, &logits)
    }

    /// A box of 48 pixels around its cell, the wrist 20 pixels below it.
    fn shape() -> [f32; VALUES] {
        let mut shape = [0.0; VALUES];
        (shape[2], shape[3], shape[5]) = (48.0, 48.0, 20.0);
        shape
    }

    #[test]
    fn a_palm_is_where_its_cell_and_its_box_say() {
        // The cell at 6 across and 3 down of the fine grid.
        let found = answer(&[(2 * (3 * 24 + 6), 3.0, shape())]);
        assert_eq!(found.len(), 1);
        let [x, y] = [6.5 / 24.0, 3.5 / 24.0];
        assert_eq!((found[0].middle, found[0].size), ([x, y], [0.25, 0.25]));
        assert_eq!(found[0].wrist(), [x, y + 20.0 / 192.0]);
        assert!((found[0].score - 0.9526).abs() < 1e-4);
    }

    #[test]
    fn answers_about_one_palm_are_its_mean_and_others_stay() {
        let cell = |x: usize, y: usize| 2 * (y * 24 + x);
        let found = answer(&[
            (cell(6, 3), 2.0, shape()),
            (cell(7, 3), 2.0, shape()),
            (cell(18, 18), 4.0, shape()),
            (cell(0, 0), -1.0, shape()),
        ]);
        assert_eq!(found.len(), 2);
        assert!((found[0].middle[0] - 18.5 / 24.0).abs() < 1e-12, "the likeliest first");
        assert!((found[1].middle[0] - 7.0 / 24.0).abs() < 1e-12, "between both");
    }

    #[test]
    fn what_is_no_number_is_no_palm() {
        let mut shape = shape();
        assert_eq!(answer(&[(0, f32::NAN, shape)]), []);
        shape[9] = f32::INFINITY;
        assert_eq!(answer(&[(0, 5.0, shape)]), []);
        shape[9] = 0.0;
        shape[2] = -4.0;
        assert_eq!(answer(&[(0, 5.0, shape)]), []);
    }

    proptest! {
        #[test]
        fn palms_lie_apart_and_come_in_order(
            answers in prop::collection::vec((0..COUNT, -2.0f32..8.0, 8.0f32..90.0, -30.0f32..30.0), 0..40),
        ) {
            let at: Vec<_> = answers.iter().map(|(at, logit, size, shift)| {
                let mut shape = shape();
                (shape[0], shape[2], shape[3]) = (*shift, *size, *size);
                (*at, *logit, shape)
            }).collect();
            let found = answer(&at);
            let likely = at.iter().map(|(at, ..)| at).collect::<std::collections::BTreeSet<_>>().len();
            prop_assert!(found.len() <= likely);
            prop_assert!(found.windows(2).all(|two| two[0].score >= two[1].score));
            for palm in &found {
                prop_assert!((LEAST..=1.0).contains(&palm.score));
                prop_assert!((palm.overlap(palm) - 1.0).abs() < 1e-9);
                // Every mean lies within its answers.
                prop_assert!((8.0 / 192.0 - 1e-9..=90.0 / 192.0 + 1e-9).contains(&palm.size[0]));
            }
        }
    }
}
