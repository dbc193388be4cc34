//! What drawings of answers share: the hand's axes in a picture, keys, and how names and shares are
//! written.

use grasp_recognise::Recognition;
use grasp_recognise::segment::Mask;
use nalgebra::{UnitQuaternion, Vector3};

use crate::canvas::{Canvas, colour};
use crate::lettering::Font;

/// The middle of what is inside a mask, in pixels; `None` where nothing is.
fn middle(mask: &Mask) -> Option<[f64; 2]> {
    let (mut sum, mut count) = ([0.0; 2], 0.0_f64);
    for (y, row) in mask.pixels().chunks_exact(mask.width().max(1)).enumerate() {
        for (x, _) in row.iter().enumerate().filter(|(_, inside)| **inside != 0) {
            sum = [sum[0] + x as f64 + 0.5, sum[1] + y as f64 + 0.5];
            count += 1.0;
        }
    }
    (count > 0.0).then(|| sum.map(|sum| sum / count))
}

/// Where the fingers point and where the back of the hand looks, from the hand's middle in its
/// picture, which was drawn at a place and scaled by so much. Returns that middle.
pub(crate) fn axes(
    canvas: &mut Canvas,
    ([left, top], scale): ([f64; 2], f64),
    length: f64,
    found: &Recognition,
) -> Option<[f64; 2]> {
    let [x, y] = middle(&found.prepared.mask)?;
    let middle = [left + scale * x, top + scale * y];
    let rotation: UnitQuaternion<f64> = found.best.vote.orientation.rotation;
    for (axis, ink) in [(Vector3::z(), colour::BACK), (Vector3::x(), colour::FINGERS)] {
        let along = rotation * axis;
        let end = [middle[0] + length * along.x, middle[1] + length * along.y];
        canvas.arrow(middle, end, ink);
    }
    Some(middle)
}

/// Colours and what they mean, in a row; returns where it ends.
pub(crate) fn legend(canvas: &mut Canvas, (mut x, y): (u32, u32), entries: &[([u8; 3], &str)]) -> u32 {
    for (ink, text) in entries {
        canvas.fill((x, y + 2), (12, 12), *ink);
        canvas.text((x + 18, y), Font::BODY.width_of(text), Font::BODY, text, colour::FAINT);
        x += 18 + Font::BODY.width_of(text) + 16;
    }
    x
}

/// A class's name as words.
pub(crate) fn in_words(name: &str) -> String {
    name.replace('-', " ")
}

/// A share in integer percent, as drawings have room for it; what is neither nothing nor all does
/// not look so.
pub(crate) fn whole_percent(share: f64) -> String {
    match share {
        share if share > 0.0 && share < 0.005 => "< 1 %".into(),
        share if (0.995..1.0).contains(&share) => "> 99 %".into(),
        share => format!("{:.0} %", 100.0 * share),
    }
}
