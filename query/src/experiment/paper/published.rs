//! What the paper reports of its own pictures.

use serde::Serialize;

use crate::evaluate::confusion::Share;

/// The paper's figures for one of its sets: six grasps, two videos each, three pictures a video.
///
/// It prints whole percents; the counts are the only ones that round to them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Published {
    /// Classed by the paper's program (Figure 7, a to c).
    pub top1: Share,
    /// Classed by a person who knew the taxonomy (Figure 7 d); known for X alone.
    pub human_top1: Option<Share>,
    /// The mean error of each angle in degrees (Figure 8); known for X alone. The paper does not
    /// say what its axes are.
    pub euler_error_deg: Option<[f64; 3]>,
}

impl Published {
    /// The figures of X, all the paper's pictures.
    pub fn all() -> Self {
        Self::of("X")
    }

    /// The figures of the set of this name; those of X'' where there is none of it.
    pub(super) fn of(set: &str) -> Self {
        let share = |n, right| Share { n, right };
        match set {
            "X" => Self {
                top1: share(36, 22),
                human_top1: Some(share(36, 22)),
                euler_error_deg: Some([0.0, 16.8, 10.5]),
            },
            "X'" => Self { top1: share(24, 17), human_top1: None, euler_error_deg: None },
            _ => Self { top1: share(12, 9), human_top1: None, euler_error_deg: None },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_round_to_what_the_paper_prints() {
        let percent = |set| (100.0 * Published::of(set).top1.top1()).round();
        assert_eq!(["X", "X'", "X''"].map(percent), [61.0, 71.0, 75.0]);
        assert_eq!(Published::of("X").human_top1.map(|share| (100.0 * share.top1()).round()), Some(61.0));
    }
}
