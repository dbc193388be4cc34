//! Colours: linear RGB, 0 to 1.

use rand_chacha::ChaCha8Rng;

use crate::random::{between, normal, unit};

/// Linear red, green and blue.
pub(super) type Rgb = [f32; 3];

pub(super) fn scale(colour: Rgb, by: f32) -> Rgb {
    colour.map(|v| v * by)
}

pub(super) fn mix(a: Rgb, b: Rgb, share: f32) -> Rgb {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * share)
}

pub(super) fn times(a: Rgb, b: Rgb) -> Rgb {
    std::array::from_fn(|i| a[i] * b[i])
}

/// From the values of a picture file to linear ones, by a gamma of 2.2, which is nearly sRGB's.
fn linear(srgb: [f64; 3]) -> Rgb {
    srgb.map(|v| libm::pow(v.clamp(0.0, 1.0), 2.2) as f32)
}

/// A person's skin: from very light to very dark, as sRGB, and what lies between.
pub(super) fn skin(rng: &mut ChaCha8Rng) -> Rgb {
    const TONES: [[f64; 3]; 6] = [
        [0.97, 0.84, 0.77],
        [0.92, 0.74, 0.63],
        [0.84, 0.62, 0.49],
        [0.70, 0.48, 0.36],
        [0.48, 0.31, 0.23],
        [0.28, 0.18, 0.14],
    ];
    // Light to brown skins are the most frequent.
    let at = between(rng, [0.0, 4.999]) * if unit(rng) < 0.7 { 0.72 } else { 1.0 };
    let (tone, share) = (at as usize, at - libm::floor(at));
    let (red, bright) = (0.035 * normal(rng), 0.04 * normal(rng));
    linear(std::array::from_fn(|i| {
        let tone = TONES[tone][i] + (TONES[tone + 1][i] - TONES[tone][i]) * share;
        tone + bright + [red, -0.3 * red, -0.6 * red][i] + 0.012 * normal(rng)
    }))
}

/// The third of the tones of [`skin`].
pub(super) const MEDIUM_SKIN: Rgb = [0.68, 0.35, 0.21];

/// A palm's: from pale to red, whatever the back of the hand is.
pub(super) fn palm(rng: &mut ChaCha8Rng) -> Rgb {
    let (red, bright) = (between(rng, [0.0, 0.12]), between(rng, [-0.14, 0.06]));
    linear([0.90 + bright, 0.71 + bright - red, 0.62 + bright - red])
}

/// How often a thing behind a hand has about the hand's colour, where any has.
const LIKE_SKIN: f64 = 0.6;

/// The colours of what lies behind a hand.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surroundings {
    /// The skin whose colour many things have: before a table of that wood a hand is known by its
    /// outline and its shading alone.
    pub(super) like: Option<Rgb>,
}

impl Surroundings {
    /// Any colour.
    pub(super) fn any(&self, rng: &mut ChaCha8Rng) -> Rgb {
        self.like_skin(rng).unwrap_or_else(|| any(rng))
    }

    /// A colour of walls, tables and the like.
    pub(super) fn muted(&self, rng: &mut ChaCha8Rng) -> Rgb {
        self.like_skin(rng).unwrap_or_else(|| muted(rng))
    }

    fn like_skin(&self, rng: &mut ChaCha8Rng) -> Option<Rgb> {
        let skin = self.like.filter(|_| unit(rng) < LIKE_SKIN)?;
        let bright = libm::exp(0.4 * normal(rng));
        Some(skin.map(|v| v * (bright * libm::exp(0.08 * normal(rng))) as f32))
    }
}

/// Any colour; greys, white and black, and colours of wood and skin, have shares of their own.
pub(super) fn any(rng: &mut ChaCha8Rng) -> Rgb {
    match unit(rng) {
        x if x < 0.22 => {
            let grey = unit(rng);
            linear(std::array::from_fn(|_| grey + 0.02 * normal(rng)))
        }
        x if x < 0.34 => linear(std::array::from_fn(|_| 0.88 + 0.1 * unit(rng))),
        x if x < 0.44 => linear(std::array::from_fn(|_| 0.12 * unit(rng))),
        x if x < 0.60 => {
            // Wood, cardboard, sand, brick.
            let bright = between(rng, [0.25, 0.9]);
            let (green, blue) = (between(rng, [0.6, 0.88]), between(rng, [0.3, 0.75]));
            linear([bright, bright * green, bright * blue])
        }
        x if x < 0.66 => skin(rng),
        _ => hue(unit(rng), between(rng, [0.2, 1.0]), between(rng, [0.2, 1.0])),
    }
}

/// A colour of walls, tables and the like: pale or earthen more often than not.
fn muted(rng: &mut ChaCha8Rng) -> Rgb {
    let colour = any(rng);
    let grey = colour.iter().sum::<f32>() / 3.0;
    mix(colour, [grey; 3], (0.75 * unit(rng)) as f32)
}

/// A wall's or a table's: pale and nearly grey.
pub(super) fn wall(rng: &mut ChaCha8Rng) -> Rgb {
    let (grey, warm) = (between(rng, [0.6, 0.95]), 0.04 * normal(rng));
    linear([grey + warm, grey, grey - warm])
}

/// Hue, saturation and value, each 0 to 1, to linear RGB.
fn hue(hue: f64, saturation: f64, value: f64) -> Rgb {
    linear(std::array::from_fn(|i| {
        let at = (hue * 6.0 + [5.0, 3.0, 1.0][i]) % 6.0;
        value - value * saturation * at.min(4.0 - at).clamp(0.0, 1.0)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn much_of_what_lies_behind_has_the_hands_colour_where_it_is_asked_for() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let skin = [0.4, 0.2, 0.12];
        let shades = |[r, g, b]: Rgb| [g / r, b / g];
        let alike = |colour: &Rgb| {
            shades(*colour).iter().zip(shades(skin)).all(|(a, b)| libm::logf(a / b).abs() < 0.25)
        };
        let mut count = |like| {
            let around = Surroundings { like };
            (0..400)
                .filter(|at| alike(&if at % 2 == 0 { around.any(&mut rng) } else { around.muted(&mut rng) }))
                .count()
        };
        let (with, without) = (count(Some(skin)), count(None));
        assert!((200..300).contains(&with) && without < 80, "{with} and {without} of 400");
    }
}
