//! What lies behind a hand: walls, tables, wood, tiles, grass, and clutter.

use rand_chacha::ChaCha8Rng;

use super::clutter::Clutter;
use super::lattice::Lattice;
use super::palette::{self, Rgb, Surroundings, mix, scale};
use super::randomised::Randomised;
use crate::random::{between, normal, unit};

/// How often a ground is a pale wall or table.
const WALLS: f64 = 0.2;
/// How often much of what lies behind has about the hand's colour.
const LIKE_SKIN: f64 = 0.3;
/// How often a room is full of things.
const CLUTTERED: f64 = 0.5;
/// One more than the most things that lie about, where it is not.
const THINGS: usize = 9;

#[derive(Debug, Clone, Copy)]
enum Ground {
    /// One colour into another along a direction.
    Gradient,
    /// Soft blots, of a few sizes at once.
    Cloudy { size: f32, sharp: f32 },
    /// Grain along a direction.
    Wood { long: f32, wide: f32 },
    /// Tiles, boards, bricks with joints between.
    Tiles { wide: f32, high: f32, joint: f32 },
    /// Leaves, carpet: blots of every colour between two.
    Grass { size: f32 },
}

/// A thing that lies about.
#[derive(Debug, Clone, Copy)]
struct Thing {
    centre: [f32; 2],
    /// Half its length and width.
    half: [f32; 2],
    /// Sine and cosine of how it lies.
    turn: [f32; 2],
    is_round: bool,
    colours: [Rgb; 2],
    size: f32,
}

/// Two grounds with an edge between them, and things before them.
#[derive(Debug, Clone)]
pub(super) struct Background {
    grounds: [(Ground, [Rgb; 2]); 2],
    /// The direction of the edge's normal, and how far it is from the middle.
    edge: [f32; 3],
    turn: [f32; 2],
    things: Vec<Thing>,
    clutter: Option<Clutter>,
    /// How much more light there is than on the hand: rooms are often brighter behind it.
    light: f32,
}

impl Background {
    /// Behind a hand whose skin has such a colour.
    pub(super) fn random(skin: Rgb, randomised: Randomised, rng: &mut ChaCha8Rng) -> Self {
        if !randomised.background {
            return Self::plain(palette::any(rng));
        }
        let colours = Surroundings { like: (unit(rng) < LIKE_SKIN).then_some(skin) };
        let turn = |rng: &mut ChaCha8Rng| {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * unit(rng));
            [sin as f32, cos as f32]
        };
        let ground = |rng: &mut ChaCha8Rng| {
            let first = if unit(rng) < WALLS { palette::wall(rng) } else { colours.muted(rng) };
            // Most surfaces are of one colour, lighter here and darker there.
            let second = match unit(rng) < 0.6 {
                true => scale(first, between(rng, [0.45, 1.5]) as f32),
                false => colours.muted(rng),
            };
            (Ground::random(rng), [first, second])
        };
        let grounds = [ground(rng), ground(rng)];
        // Often there is but one.
        let far = if unit(rng) < 0.45 { 9.0 } else { 0.35 * normal(rng) };
        let [sin, cos] = turn(rng);
        let count = match unit(rng) < 0.45 {
            true => 0,
            false => (unit(rng) * THINGS as f64) as usize,
        };
        let thing = |rng: &mut ChaCha8Rng| Thing {
            centre: [0; 2].map(|_| between(rng, [-0.1, 1.1]) as f32),
            half: [0; 2].map(|_| (0.02 + 0.35 * unit(rng) * unit(rng)) as f32),
            turn: turn(rng),
            is_round: unit(rng) < 0.4,
            colours: [colours.any(rng), colours.any(rng)],
            size: between(rng, [2.0, 40.0]) as f32,
        };
        let things = (0..count).map(|_| thing(rng)).collect();
        let light = libm::exp(0.25 + 0.6 * normal(rng)) as f32;
        let turn = turn(rng);
        let mut out = Self { grounds, edge: [cos, sin, far as f32], turn, things, clutter: None, light };
        if unit(rng) < CLUTTERED && randomised.clutter {
            out.things.clear();
            out.clutter = Some(Clutter::random(|u, v, field| out.colour(u, v, field), colours, rng));
        }
        out
    }

    /// One colour.
    fn plain(colour: Rgb) -> Self {
        Self {
            grounds: [(Ground::Gradient, [colour; 2]); 2],
            edge: [1.0, 0.0, 9.0],
            turn: [0.0, 1.0],
            things: Vec::new(),
            clutter: None,
            light: 1.0,
        }
    }

    /// What is seen at a place of the picture, 0 to 1 right and down, where the room is full of
    /// things: linear RGB. `None` where [`Self::at`] says what is seen.
    pub(super) fn clutter_at(&self, u: f32, v: f32) -> Option<Rgb> {
        Some(scale(self.clutter.as_ref()?.at(u, v)?, self.light))
    }

    /// What is seen at a place of the picture, 0 to 1 right and down: linear RGB.
    pub(super) fn at(&self, u: f32, v: f32, field: &Lattice) -> Rgb {
        scale(self.colour(u, v, field), self.light)
    }

    fn colour(&self, u: f32, v: f32, field: &Lattice) -> Rgb {
        for thing in &self.things {
            let [sin, cos] = thing.turn;
            let (x, y) = (u - thing.centre[0], v - thing.centre[1]);
            let [along, across] = [(cos * x + sin * y) / thing.half[0], (cos * y - sin * x) / thing.half[1]];
            let inside = match thing.is_round {
                true => along * along + across * across < 1.0,
                false => along.abs().max(across.abs()) < 1.0,
            };
            if inside {
                let share = field.at(u * thing.size + 11.0, v * thing.size + 5.0);
                let share = if share > 0.6 { 1.0 } else { 0.3 * share };
                // Rounded things are darker toward their border.
                let dim = if thing.is_round { 1.0 - 0.5 * across * across } else { 1.0 };
                return scale(mix(thing.colours[0], thing.colours[1], share), dim);
            }
        }
        let [cos, sin, far] = self.edge;
        let is_second = cos * (u - 0.5) + sin * (v - 0.5) > far;
        let (ground, colours) = &self.grounds[usize::from(is_second)];
        let [sin, cos] = self.turn;
        let share = ground.share(cos * u + sin * v, cos * v - sin * u, field);
        mix(colours[0], colours[1], share)
    }
}

impl Ground {
    fn random(rng: &mut ChaCha8Rng) -> Self {
        match unit(rng) {
            x if x < 0.28 => Self::Gradient,
            x if x < 0.5 => {
                Self::Cloudy { size: between(rng, [1.5, 9.0]) as f32, sharp: between(rng, [1.0, 5.0]) as f32 }
            }
            x if x < 0.68 => {
                Self::Wood { long: between(rng, [0.5, 2.0]) as f32, wide: between(rng, [8.0, 40.0]) as f32 }
            }
            x if x < 0.84 => Self::Tiles {
                wide: between(rng, [0.08, 0.7]) as f32,
                high: between(rng, [0.05, 0.5]) as f32,
                joint: between(rng, [0.03, 0.15]) as f32,
            },
            _ => Self::Grass { size: between(rng, [12.0, 50.0]) as f32 },
        }
    }

    /// The share of the second colour at a place.
    fn share(&self, x: f32, y: f32, field: &Lattice) -> f32 {
        let octaves = |size: f32| {
            let (x, y) = (x * size, y * size);
            let more = 0.2 * field.at(4.3 * x + 9.0, 4.3 * y);
            0.5 * field.at(x, y) + 0.3 * field.at(2.1 * x + 3.0, 2.1 * y) + more
        };
        match *self {
            Self::Gradient => (0.5 + 0.6 * x).clamp(0.0, 1.0),
            Self::Cloudy { size, sharp } => (0.5 + sharp * (octaves(size) - 0.5)).clamp(0.0, 1.0),
            Self::Wood { long, wide } => {
                let grain = field.at(x * long, y * wide) + 0.5 * field.at(x * long * 3.0, y * wide * 2.3);
                (grain / 1.5).clamp(0.0, 1.0)
            }
            Self::Tiles { wide, high, joint } => {
                let row = (y / high).floor();
                let (u, v) = (x / wide + 0.5 * row, y / high);
                let (u, v) = (u - u.floor(), v - v.floor());
                if u < joint || v < joint { 1.0 } else { 0.25 * field.at(x / wide + 0.5 * row, row) }
            }
            Self::Grass { size } => {
                let blade = field.at(x * size, y * size * 0.4) * field.at(x * size * 0.37, y * size);
                (2.2 * blade).clamp(0.0, 1.0)
            }
        }
    }
}
