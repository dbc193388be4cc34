//! How much likelier a colour is on skin than elsewhere: a Bayes classifier as a lookup table.
//!
//! The densities are the two mixtures of 16 Gaussian kernels that Jones and Rehg fitted to nearly a
//! billion labelled pixels (IJCV 46(1), 2002; `data/skin-mixture.csv`). `build.rs` makes the table
//! from them.

/// Cells along each colour axis.
const SIDE: usize = 64;
/// Bits of a channel that a cell spans.
const SHIFT: u32 = 2;
/// Steps of the stored log-odds per natural unit.
const STEPS: f32 = 8.0;

/// `SIDE^3` log-odds as `i8`, red slowest.
static LOG_ODDS: &[u8; SIDE * SIDE * SIDE] = include_bytes!(concat!(env!("OUT_DIR"), "/skin-log-odds.bin"));

/// ln(p(rgb | skin) / p(rgb | other)), in -15.9..=15.9.
pub fn log_odds([r, g, b]: [u8; 3]) -> f32 {
    let cell = |channel: u8| usize::from(channel >> SHIFT);
    let stored = LOG_ODDS[(cell(r) * SIDE + cell(g)) * SIDE + cell(b)];
    f32::from(stored as i8) / STEPS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skin_tones_of_light_and_dark_people_are_skin() {
        for rgb in [[214, 160, 128], [150, 98, 75], [100, 56, 40], [235, 178, 142]] {
            assert!(log_odds(rgb) > 1.0, "{rgb:?}: {}", log_odds(rgb));
        }
    }

    #[test]
    fn white_black_grey_green_and_blue_are_not() {
        for rgb in [[255, 255, 255], [0, 0, 0], [128, 128, 128], [40, 160, 60], [40, 60, 200]] {
            assert!(log_odds(rgb) < -1.0, "{rgb:?}: {}", log_odds(rgb));
        }
    }
}
