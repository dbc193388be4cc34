//! The published skin model, adapted to the light of the picture at hand.
//!
//! Argyros and Lourakis ("Real-time tracking of multiple skin-colored objects with a possibly moving camera",
//! ECCV 2004) blend the trained P(skin | colour) with one that is counted over what was lately taken for skin:
//! P = gamma P_trained + (1 - gamma) P_counted. A single picture has no past, so here the picture's own likely
//! pixels are counted, a few times over. The blend is taken on log-odds, where a colour that either model is sure
//! about keeps its say.

use super::skin;
use crate::picture::Picture;

/// Bins along each of the two chroma axes.
const CHROMA_BINS: usize = 64;
/// Bins along the luma axis: coarse, because light is what changes.
const LUMA_BINS: usize = 4;

/// The numbers of the adaptation.
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptParams {
    /// How often the picture's own pixels are counted anew; 0 leaves the published model alone.
    pub rounds: usize,
    /// The weight of the published model, 0..=1.
    pub gamma: f32,
    /// Added to the log-odds of the published model: photographs of one hand have more skin than the web has.
    pub prior: f32,
    /// How much of a colour cast is taken out, 0 (none) to 1 (white becomes white).
    pub cast: f32,
    /// How strongly the middle of the picture is preferred when pixels are counted: see `centrality`.
    pub centre: f32,
    /// The share of all pixels that a bin needs before it is believed.
    pub doubt: f32,
}

impl Default for AdaptParams {
    fn default() -> Self {
        Self { rounds: 4, gamma: 0.3, prior: 1.0, cast: 0.5, centre: 3.0, doubt: 1e-4 }
    }
}

/// The log-odds of skin at each pixel of a picture, adapted to it and averaged over a box of `radius`.
pub fn log_odds(picture: &Picture, radius: usize, params: &AdaptParams) -> Vec<f32> {
    let (width, height) = (picture.width(), picture.height());
    let light = Light::of(picture, params.cast);
    let trained: Vec<f32> =
        picture.rgb().iter().map(|&rgb| skin::log_odds(light.correct(rgb)) + params.prior).collect();
    let bins: Vec<u16> = picture.rgb().iter().map(|&rgb| bin(rgb)).collect();
    let trained = box_mean(width, height, &trained, radius);
    let mut odds = trained.clone();
    let centred = centrality(width, height, params.centre);
    for _ in 0..params.rounds {
        let counted = count(&bins, &odds, &centred, params);
        for ((odds, &trained), &bin) in odds.iter_mut().zip(&trained).zip(&bins) {
            *odds = params.gamma * trained + (1.0 - params.gamma) * counted[usize::from(bin)];
        }
        odds = box_mean(width, height, &odds, radius);
    }
    odds
}

/// The brightness that the brightest part of a picture is brought to: that of the web's photographs.
const WHITE: f32 = 230.0;
/// The share of values below "the brightest part".
const BRIGHT_SHARE: f64 = 0.95;
/// A picture is made at most this much brighter.
const MOST_GAIN: f32 = 1.8;

/// What each channel's value becomes under a standard light: a table, because a gain is applied to every pixel.
struct Light {
    tables: [[u8; 256]; 3],
}

impl Light {
    /// Takes the 95th percentile of each channel for white (the white-patch assumption, softened by `cast`).
    fn of(picture: &Picture, cast: f32) -> Self {
        let mut histogram = [[0usize; 256]; 3];
        for pixel in picture.rgb() {
            for (counts, &value) in histogram.iter_mut().zip(pixel) {
                counts[usize::from(value)] += 1;
            }
        }
        let below = (BRIGHT_SHARE * picture.rgb().len() as f64) as usize;
        let bright = histogram.map(|counts| {
            let mut sum = 0;
            let at = counts.iter().position(|&count| {
                sum += count;
                sum > below
            });
            at.unwrap_or(255).max(1) as f32
        });
        let mean = (bright[0] + bright[1] + bright[2]) / 3.0;
        let gain = (WHITE / mean).clamp(1.0, MOST_GAIN);
        let tables = bright.map(|bright| {
            let channel = gain * (mean / bright).powf(cast).clamp(0.8, 1.25);
            std::array::from_fn(|value| (value as f32 * channel).round().min(255.0) as u8)
        });
        Self { tables }
    }

    fn correct(&self, rgb: [u8; 3]) -> [u8; 3] {
        let [red, green, blue] = &self.tables;
        [red[usize::from(rgb[0])], green[usize::from(rgb[1])], blue[usize::from(rgb[2])]]
    }
}

/// The histogram bin of a colour: two chroma axes (B - Y and R - Y, from -128..=127) and a coarse luma.
fn bin([r, g, b]: [u8; 3]) -> u16 {
    let [r, g, b] = [i32::from(r), i32::from(g), i32::from(b)];
    let luma = (77 * r + 150 * g + 29 * b) >> 8;
    let axis = |difference: i32| (difference.clamp(-128, 127) + 128) as usize * CHROMA_BINS / 256;
    let luma_bin = luma as usize * LUMA_BINS / 256;
    ((luma_bin * CHROMA_BINS + axis(b - luma)) * CHROMA_BINS + axis(r - luma)) as u16
}

/// How much each pixel's place says for the hand: 1 in the middle, e^-`strength` at the middle of a side.
fn centrality(width: usize, height: usize, strength: f32) -> Vec<f32> {
    let axis = |length: usize| -> Vec<f32> {
        let half = length as f32 / 2.0;
        (0..length).map(|at| (-strength * ((at as f32 + 0.5 - half) / half).powi(2)).exp()).collect()
    };
    let (columns, rows) = (axis(width), axis(height));
    rows.iter().flat_map(|row| columns.iter().map(move |column| row * column)).collect()
}

/// The log-odds of skin in each bin: each pixel counts for skin by its present probability and its place.
fn count(bins: &[u16], odds: &[f32], centred: &[f32], params: &AdaptParams) -> Vec<f32> {
    let mut other = vec![0f32; LUMA_BINS * CHROMA_BINS * CHROMA_BINS];
    let mut skin = other.clone();
    for ((&bin, &odds), &centred) in bins.iter().zip(odds).zip(centred) {
        let share = probability(odds) * centred;
        skin[usize::from(bin)] += share;
        other[usize::from(bin)] += 1.0 - share;
    }
    spread(&mut other);
    spread(&mut skin);
    // Shares of all skin and of all else, so that a small hand is not held against its colour.
    let scale = |bins: &[f32]| 1.0 / bins.iter().sum::<f32>().max(1e-6);
    let (of_skin, of_other) = (scale(&skin), scale(&other));
    skin.iter()
        .zip(&other)
        .map(|(&skin, &other)| ((skin * of_skin + params.doubt) / (other * of_other + params.doubt)).ln())
        .collect()
}

/// 1 / (1 + e^-odds).
fn probability(odds: f32) -> f32 {
    1.0 / (1.0 + (-odds).exp())
}

/// Spreads each bin over its chroma neighbours with the weights 1, 2, 1: noise moves a pixel by a bin or so.
fn spread(bins: &mut [f32]) {
    for plane in bins.chunks_exact_mut(CHROMA_BINS * CHROMA_BINS) {
        for line in 0..CHROMA_BINS {
            spread_line(plane, line * CHROMA_BINS, 1);
        }
        for line in 0..CHROMA_BINS {
            spread_line(plane, line, CHROMA_BINS);
        }
    }
}

/// Spreads one row or column of a plane: `CHROMA_BINS` values from `start`, `stride` apart.
fn spread_line(plane: &mut [f32], start: usize, stride: usize) {
    let mut before = 0.0;
    for step in 0..CHROMA_BINS {
        let at = start + step * stride;
        let after = if step + 1 < CHROMA_BINS { plane[at + stride] } else { 0.0 };
        let here = plane[at];
        plane[at] = 0.25 * before + 0.5 * here + 0.25 * after;
        before = here;
    }
}

/// The mean over the box of `radius` pixels around each pixel; at the border, over the part inside the picture.
fn box_mean(width: usize, height: usize, values: &[f32], radius: usize) -> Vec<f32> {
    if radius == 0 {
        return values.to_vec();
    }
    let span = |at: usize, length: usize| (at.saturating_sub(radius), (at + radius + 1).min(length));
    let mut rows = vec![0f32; values.len()];
    for (out, row) in rows.chunks_exact_mut(width).zip(values.chunks_exact(width)) {
        for (x, out) in out.iter_mut().enumerate() {
            let (from, to) = span(x, width);
            *out = row[from..to].iter().sum::<f32>() / (to - from) as f32;
        }
    }
    let mut means = vec![0f32; values.len()];
    for (y, out) in means.chunks_exact_mut(width).enumerate() {
        let (from, to) = span(y, height);
        for row in rows[from * width..to * width].chunks_exact(width) {
            for (out, value) in out.iter_mut().zip(row) {
                *out += value;
            }
        }
        let share = 1.0 / (to - from) as f32;
        out.iter_mut().for_each(|value| *value *= share);
    }
    means
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A patch of one colour on a ground of another.
    fn patch(skin: [u8; 3], ground: [u8; 3]) -> Picture {
        let inside = |at: usize| (20..44).contains(&(at % 64)) && (20..44).contains(&(at / 64));
        let rgb = (0..64 * 64).map(|at| if inside(at) { skin } else { ground }).collect();
        Picture::new(64, 64, rgb).unwrap()
    }

    #[test]
    fn skin_in_dim_light_is_found_by_its_difference_from_the_ground() {
        // Indoors, by the window: the published model alone calls this brown no skin.
        let picture = patch([74, 51, 50], [178, 182, 186]);
        assert!(skin::log_odds([74, 51, 50]) < 0.5);
        let odds = log_odds(&picture, 1, &AdaptParams::default());
        assert!(odds[32 * 64 + 32] > 1.0, "hand {}", odds[32 * 64 + 32]);
        assert!(odds[5 * 64 + 5] < -1.0, "ground {}", odds[5 * 64 + 5]);
    }

    #[test]
    fn a_picture_of_one_blue_has_no_skin() {
        let odds = log_odds(&patch([40, 70, 160], [40, 70, 160]), 1, &AdaptParams::default());
        assert!(odds.iter().all(|&odds| odds < 0.0));
    }

    #[test]
    fn the_box_mean_keeps_a_flat_picture_flat_up_to_its_border() {
        let means = box_mean(5, 4, &[2.0; 20], 2);
        assert!(means.iter().all(|mean| (mean - 2.0).abs() < 1e-6));
    }

    #[test]
    fn spreading_keeps_the_count_and_reaches_the_eight_neighbours() {
        let mut bins = vec![0f32; CHROMA_BINS * CHROMA_BINS];
        bins[10 * CHROMA_BINS + 10] = 16.0;
        spread(&mut bins);
        assert!((bins.iter().sum::<f32>() - 16.0).abs() < 1e-4);
        assert_eq!((bins[10 * CHROMA_BINS + 10], bins[9 * CHROMA_BINS + 11]), (4.0, 1.0));
    }
}
