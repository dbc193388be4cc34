//! What surfaces look like: skin, cloth, and the materials of things.

use rand_chacha::ChaCha8Rng;

use super::lattice::Lattice;
use super::layers::Texel;
use super::light::{Light, Shares};
use super::palette::{self, Rgb, mix, scale, times};
use crate::random::{between, normal, unit};

/// What a material's colour follows.
#[derive(Debug, Clone, Copy)]
enum Pattern {
    Plain,
    /// Blots of the second colour.
    Blots {
        size: f32,
        level: f32,
    },
    /// Bands across a direction.
    Bands {
        across: [f32; 3],
        width: f32,
        share: f32,
    },
    /// Squares.
    Checks {
        size: f32,
    },
    /// A printed patch: blots in the second and third colour within bands.
    Print {
        across: [f32; 3],
        width: f32,
        size: f32,
    },
}

/// How a thing, a sleeve or a piece of skin looks.
#[derive(Debug, Clone)]
pub(super) struct Material {
    colours: [Rgb; 3],
    pattern: Pattern,
    gloss: f32,
    /// The shine's exponent.
    polish: f32,
    metal: f32,
}

impl Material {
    /// Of a thing.
    pub(super) fn random(rng: &mut ChaCha8Rng) -> Self {
        let direction = |rng: &mut ChaCha8Rng| [0; 3].map(|_| normal(rng) as f32 * 0.7);
        let pattern = match unit(rng) {
            x if x < 0.55 => Pattern::Plain,
            x if x < 0.62 => Pattern::Blots {
                size: between(rng, [60.0, 300.0]) as f32,
                level: between(rng, [0.35, 0.65]) as f32,
            },
            x if x < 0.76 => Pattern::Bands {
                across: direction(rng),
                width: between(rng, [0.006, 0.05]) as f32,
                share: between(rng, [0.2, 0.7]) as f32,
            },
            x if x < 0.81 => Pattern::Checks { size: between(rng, [0.005, 0.025]) as f32 },
            _ => Pattern::Print {
                across: direction(rng),
                width: between(rng, [0.03, 0.09]) as f32,
                size: between(rng, [80.0, 400.0]) as f32,
            },
        };
        let gloss = if unit(rng) < 0.5 { between(rng, [0.05, 0.9]) } else { 0.0 };
        Self {
            colours: [0; 3].map(|_| palette::any(rng)),
            pattern,
            gloss: gloss as f32,
            polish: between(rng, [4.0, 60.0]) as f32,
            metal: if unit(rng) < 0.12 { between(rng, [0.3, 0.9]) as f32 } else { 0.0 },
        }
    }

    /// Of a thing, in one colour, matt.
    pub(super) fn plain(rng: &mut ChaCha8Rng) -> Self {
        Self { pattern: Pattern::Plain, gloss: 0.0, metal: 0.0, ..Self::random(rng) }
    }

    /// Nearly black, as straps of watches are.
    pub(super) fn black(rng: &mut ChaCha8Rng) -> Self {
        let grey = between(rng, [0.005, 0.05]) as f32;
        let colours = [0; 3].map(|_| [0; 3].map(|_| grey * between(rng, [0.8, 1.25]) as f32));
        Self { colours, metal: 0.0, ..Self::random(rng) }
    }

    /// Of a sleeve.
    pub(super) fn cloth(rng: &mut ChaCha8Rng) -> Self {
        Self { gloss: 0.0, metal: 0.0, ..Self::random(rng) }
    }

    fn colour(&self, place: [f32; 3], field: &Lattice) -> Rgb {
        let [first, second, third] = self.colours;
        let along = |across: [f32; 3]| across.iter().zip(&place).map(|(a, p)| a * p).sum::<f32>();
        let blot = |size: f32, level: f32| field.at_place(place.map(|v| v * size)) > level;
        match self.pattern {
            Pattern::Plain => first,
            Pattern::Blots { size, level } => {
                if blot(size, level) {
                    second
                } else {
                    first
                }
            }
            Pattern::Bands { across, width, share } => {
                let at = along(across) / width;
                if at - at.floor() < share { second } else { first }
            }
            Pattern::Checks { size } => {
                let sum: f32 = place.iter().map(|v| (v / size).floor()).sum();
                if (sum as i32).rem_euclid(2) == 0 { first } else { second }
            }
            Pattern::Print { across, width, size } => {
                let at = along(across) / width;
                match at - at.floor() {
                    share if share < 0.45 => first,
                    _ if blot(size, 0.5) => third,
                    _ => second,
                }
            }
        }
    }

    /// As the camera sees it: linear RGB. `shares` of each lamp's light come in.
    pub(super) fn seen(&self, texel: &Texel, light: &Light, shares: Shares, field: &Lattice) -> Rgb {
        let (place, normal) = (texel.place(), texel.normal());
        let (lit, shine) = light.on(texel, shares, 0.0);
        let colour = times(self.colour(place, field), lit);
        let glint = glint(self.gloss, shine, self.polish);
        // Metal mirrors a room of light and dark.
        let mirrored = field.at(3.0 * normal[0] + 5.0, 3.0 * normal[1]) * 1.2;
        mix(colour.map(|v| v + glint), [mirrored; 3], self.metal)
    }
}

/// What shines; far from the mirrored light there is nothing to compute.
fn glint(gloss: f32, shine: f32, polish: f32) -> f32 {
    if gloss == 0.0 || shine < 0.5 { 0.0 } else { gloss * libm::powf(shine, polish) }
}

/// How often nails are painted.
const PAINTED: f64 = 0.1;

/// A person's skin.
#[derive(Debug, Clone)]
pub(super) struct Skin {
    colour: Rgb,
    red: Rgb,
    uneven: f32,
    size: f32,
    /// How much brighter or darker furrows and spots are, and how many of them a metre has.
    rough: f32,
    grain: f32,
    gloss: f32,
    hairy: f32,
    /// The colour of the palm's side, of knuckles and of nails.
    palm: Rgb,
    knuckle: Rgb,
    nail: Rgb,
    nail_gloss: f32,
}

impl Skin {
    pub(super) fn random(rng: &mut ChaCha8Rng) -> Self {
        let colour = palette::skin(rng);
        let red = [1.1, 0.72, 0.7].map(|v: f64| v + 0.05 * normal(rng));
        let red = std::array::from_fn(|i| (f64::from(colour[i]) * red[i]) as f32);
        let bare = mix(palette::palm(rng), colour, unit(rng) as f32);
        let nail = mix(bare, palette::palm(rng), unit(rng) as f32);
        Self {
            colour,
            red,
            palm: bare,
            knuckle: mix(colour, scale(red, between(rng, [0.6, 1.0]) as f32), unit(rng) as f32),
            nail: if unit(rng) < PAINTED { palette::any(rng) } else { nail },
            nail_gloss: (0.5 * unit(rng)) as f32,
            uneven: (0.9 * unit(rng)) as f32,
            size: between(rng, [25.0, 90.0]) as f32,
            rough: (0.3 * unit(rng) * unit(rng)) as f32,
            grain: between(rng, [60.0, 250.0]) as f32,
            gloss: (0.25 * unit(rng) * unit(rng)) as f32,
            hairy: if unit(rng) < 0.3 { (0.5 * unit(rng)) as f32 } else { 0.0 },
        }
    }

    /// Of a medium tone everywhere.
    pub(super) fn even() -> Self {
        let colour = palette::MEDIUM_SKIN;
        Self {
            colour,
            red: colour,
            uneven: 0.0,
            size: 50.0,
            rough: 0.0,
            grain: 100.0,
            gloss: 0.05,
            hairy: 0.0,
            palm: colour,
            knuckle: colour,
            nail: colour,
            nail_gloss: 0.0,
        }
    }

    /// The back of the hand's: linear RGB.
    pub(super) fn colour(&self) -> Rgb {
        self.colour
    }

    /// As the camera sees it: linear RGB. `shares` of each lamp's light come in.
    pub(super) fn seen(&self, texel: &Texel, light: &Light, shares: Shares, field: &Lattice) -> Rgb {
        let (place, mark) = (texel.place(), texel.mark());
        // Light comes through a little: the shadow's edge is soft and red.
        let (lit, shine) = light.on(texel, shares, 0.25);
        let red = (field.at_place(place.map(|v| v * self.size)) - 0.3).max(0.0) * self.uneven;
        let palmar = (0.5 + mark.palmar).clamp(0.0, 1.0);
        let mut colour = mix(self.colour, self.palm, palmar);
        colour = mix(mix(colour, self.knuckle, mark.knuckle), self.red, red);
        if self.hairy > 0.0 && place[0] < 0.0 {
            colour = scale(colour, 1.0 - self.hairy * field.at_place(place.map(|v| v * 330.0)));
        }
        let rough = 2.0 * field.at_place(place.map(|v| v * self.grain + 0.5)) - 1.0;
        colour = scale(colour, 1.0 + self.rough * rough);
        colour = mix(colour, self.nail, mark.nail);
        let glint = glint(self.gloss + mark.nail * self.nail_gloss, shine, 9.0);
        times(colour, lit).map(|v| v + glint)
    }
}
