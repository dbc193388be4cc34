//! What can be measured of a mask by the picture's colours, for and against its being a hand.

use std::f64::consts::PI;

use super::Mask;
use super::distance::{self, Deepest};

/// How far the surroundings of a mask reach, in radii of a disc of its area.
const AROUND: f64 = 0.4;
/// The surroundings are at least this wide, in pixels.
const LEAST_AROUND: f64 = 4.0;

/// Measures of a mask, hand and forearm, at the small size at which the hand is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// The share of the picture's border that lies in the mask, 0..=1.
    pub on_border: f64,
    /// The share of the mask's surroundings that is of the colour of skin, 0..=1.
    pub skin_around: f64,
    /// The squared length of the mask's outline over that of a disc of its area: 1 for a disc, more
    /// the more ragged.
    pub raggedness: f64,
    /// The radius of the largest circle in the mask over that of a disc of its area, 0..=1.
    pub thickness: f64,
}

impl Quality {
    /// Of a mask and its deepest place, whose picture's pixels have these log-odds of skin by
    /// colour.
    pub(super) fn of(mask: &Mask, deepest: Option<Deepest>, odds: &[f32]) -> Self {
        let (width, height, pixels) = (mask.width(), mask.height(), mask.pixels());
        let radius = (mask.area().max(1) as f64 / PI).sqrt();
        let reach = 3.0 * (AROUND * radius).max(LEAST_AROUND);
        let away = distance::thirds(width, height, |at| pixels[at] != 0, false);
        let (mut around, mut skin) = (0usize, 0usize);
        for (&away, &odds) in away.iter().zip(odds) {
            if away > 0 && f64::from(away) <= reach {
                around += 1;
                skin += usize::from(odds > 0.0);
            }
        }
        let deepest = f64::from(deepest.map_or(0, |deepest| deepest.thirds)) / 3.0;
        let on_border: usize = mask.on_sides().iter().sum();
        Self {
            on_border: on_border as f64 / (2 * (width + height)).max(1) as f64,
            skin_around: skin as f64 / around.max(1) as f64,
            raggedness: (outline(mask) / (2.0 * PI * radius)).powi(2),
            thickness: deepest / radius,
        }
    }
}

/// The length of the mask's outline in pixels: sides of pixels between inside and outside, taken to
/// run at any angle, of which the mean length is pi / 4 of the steps that draw it.
fn outline(mask: &Mask) -> f64 {
    let differences =
        |a: &[u8], b: &[u8]| -> usize { a.iter().zip(b).map(|(a, b)| usize::from(a ^ b)).sum() };
    let width = mask.width().max(1);
    let rows = || mask.pixels().chunks_exact(width);
    let across: usize = rows().map(|row| differences(row, &row[1..])).sum();
    let down: usize = rows().zip(rows().skip(1)).map(|(above, below)| differences(above, below)).sum();
    let on_border: usize = mask.on_sides().iter().sum();
    (across + down + on_border) as f64 * std::f64::consts::FRAC_PI_4
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 100;

    /// Of a mask that is inside where `is_hand` says so, with skin where `is_skin` does.
    fn measured(is_hand: impl Fn(f32, f32) -> bool, is_skin: impl Fn(f32, f32) -> bool) -> Quality {
        let place = |at: usize| ((at % SIDE) as f32, (at / SIDE) as f32);
        let inside: Vec<bool> = (0..SIDE * SIDE).map(place).map(|(x, y)| is_hand(x, y)).collect();
        let odds: Vec<f32> =
            (0..SIDE * SIDE).map(place).map(|(x, y)| if is_skin(x, y) { 2.0 } else { -2.0 }).collect();
        let mask = Mask::from_values(SIDE, SIDE, &inside, |v| v);
        Quality::of(&mask, Deepest::of(&mask), &odds)
    }

    fn disc(x: f32, y: f32) -> bool {
        (x - 50.0).hypot(y - 50.0) <= 25.0
    }

    #[test]
    fn a_disc_by_hand() {
        let disc = measured(disc, disc);
        assert!((disc.raggedness - 1.0).abs() < 0.1 && (disc.thickness - 1.0).abs() < 0.1, "{disc:?}");
        assert_eq!((disc.on_border, disc.skin_around), (0.0, 0.0));
    }

    #[test]
    fn a_board_that_fills_the_frame_runs_along_its_whole_border() {
        let board = measured(|_, _| true, |_, _| true);
        assert_eq!((board.on_border, board.skin_around), (1.0, 0.0));
    }

    #[test]
    fn a_comb_is_more_ragged_than_a_disc_and_skin_on_one_side_is_half_the_surroundings() {
        let comb = measured(|x, y| disc(x, y) && x % 6.0 < 3.0, disc);
        assert!(comb.raggedness > 4.0 * measured(disc, disc).raggedness, "{comb:?}");
        let half = measured(disc, |x, y| disc(x, y) || x < 50.0);
        assert!((half.skin_around - 0.5).abs() < 0.03, "{half:?}");
    }
}
