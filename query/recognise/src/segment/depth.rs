//! A mask from a depth picture: what lies between two distances.

use std::fmt;
use std::str::FromStr;

use super::{Mask, component, median};

/// A range of depth values, both ends included, in the depth picture's own unit (commonly
/// millimetres).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DepthRange {
    near: u16,
    far: u16,
}

/// Why a text is no depth range.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[error(
    "a depth range is NEAR..FAR in the depth picture's unit, 1 <= NEAR <= FAR <= 65535, for example 400..900"
)]
pub struct DepthRangeError;

impl fmt::Display for DepthRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..{}", self.near, self.far)
    }
}

impl FromStr for DepthRange {
    type Err = DepthRangeError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (near, far) = text.split_once("..").ok_or(DepthRangeError)?;
        let number = |text: &str| text.trim().parse::<u16>().map_err(|_| DepthRangeError);
        let (near, far) = (number(near)?, number(far)?);
        // 0 is a depth sensor's word for "not seen".
        if near == 0 || near > far {
            return Err(DepthRangeError);
        }
        Ok(Self { near, far })
    }
}

/// The largest connected region within the range, median filtered as a skin mask is; `None` where
/// there is none.
///
/// `depth` holds `width * height` values.
pub fn mask_from_depth(width: usize, height: usize, depth: &[u16], range: DepthRange) -> Option<Mask> {
    let mut mask = Mask::from_values(width, height, depth, |value| (range.near..=range.far).contains(&value));
    for _ in 0..3 {
        mask = median::median3x3(&mask);
    }
    component::largest(&mask, component::MIN_PIXELS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_read_and_a_wrong_one_says_how() {
        assert_eq!("400..900".parse(), Ok(DepthRange { near: 400, far: 900 }));
        for wrong in ["400", "900..400", "0..5", "a..b", "1..70000", ""] {
            assert_eq!(wrong.parse::<DepthRange>(), Err(DepthRangeError), "{wrong}");
        }
    }

    #[test]
    fn what_is_not_seen_or_too_far_is_outside() {
        let mut depth = vec![0u16; 40 * 40];
        for y in 0..40 {
            for x in 0..40 {
                depth[y * 40 + x] = if x < 20 { 500 } else { 1500 };
            }
        }
        let mask = mask_from_depth(40, 40, &depth, DepthRange { near: 400, far: 900 }).unwrap();
        assert_eq!(mask.area(), 20 * 40);
        assert!(mask_from_depth(40, 40, &depth, DepthRange { near: 1, far: 2 }).is_none());
    }
}
