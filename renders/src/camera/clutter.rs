//! Rooms full of things: shapes that lie one on another until little of the ground is seen.
//!
//! The dead-leaves model (Lee, Mumford and Huang, "Occlusion models for natural images", IJCV
//! 2001). There the density of sizes falls with their cube; here every octave of sizes is as
//! frequent, for behind a hand shelves, tables and arms are what misleads.

use rand_chacha::ChaCha8Rng;

use super::lattice::Lattice;
use super::optics::blur;
use super::palette::{Rgb, Surroundings, mix, scale};
use crate::random::{between, normal, unit};

/// Cells a side.
const SIDE: usize = 128;
/// How many things there are.
const COUNT: [f64; 2] = [5.0, 60.0];
/// Half the length of the smallest and the largest, in sides of the picture.
const SIZES: [f64; 2] = [0.03, 0.6];
/// How often the room is out of focus, and how far, in cells.
const BLURRED: f64 = 0.35;
const BLUR: [f64; 2] = [0.5, 3.0];

/// What is seen at each cell of the picture; `None` where that is the ground and nothing shades or
/// blurs it.
#[derive(Debug, Clone)]
pub(super) struct Clutter(Vec<Option<Rgb>>);

#[derive(Debug, Clone, Copy)]
enum Outline {
    Box,
    Ellipse,
    /// A box without two of its corners.
    Cut([f32; 2]),
    /// So many alike beside each other: books, pens, bars.
    Row(f32),
    /// A frame or a ring: what lies within this share of it is open.
    Frame(f32, bool),
}

#[derive(Debug, Clone, Copy)]
enum Pattern {
    Plain,
    Gradient,
    Stripes(f32),
    Blots(f32),
}

#[derive(Debug, Clone)]
struct Leaf {
    centre: [f32; 2],
    half: [f32; 2],
    /// Sine and cosine of how it lies.
    turn: [f32; 2],
    outline: Outline,
    pattern: Pattern,
    colours: [Rgb; 2],
    /// Where its shadow falls, and how dark it is.
    shadow: [f32; 2],
    dark: f32,
}

impl Clutter {
    /// Things of one room: they share a light, and so the side that shadows fall to. `ground` is
    /// what is seen behind them.
    pub(super) fn random(
        ground: impl Fn(f32, f32, &Lattice) -> Rgb,
        colours: Surroundings,
        rng: &mut ChaCha8Rng,
    ) -> Self {
        let field = Lattice::random(rng);
        let count = COUNT[0] * libm::pow(COUNT[1] / COUNT[0], unit(rng));
        let light = [0; 2].map(|_| 0.02 * normal(rng) as f32);
        // Things of one room often lie along the same lines.
        let grid = (unit(rng) < 0.5).then(|| std::f64::consts::TAU * unit(rng));
        let leaves: Vec<Leaf> =
            (0..count as usize).map(|_| Leaf::random(light, grid, colours, rng)).collect();
        let is_blurred = unit(rng) < BLURRED;
        let place = |at: usize| (at as f32 + 0.5) / SIDE as f32;
        let mut cells = vec![None; SIDE * SIDE];
        if is_blurred || leaves.iter().any(|leaf| leaf.dark > 0.0) {
            for (at, cell) in cells.iter_mut().enumerate() {
                *cell = Some(ground(place(at % SIDE), place(at / SIDE), &field));
            }
        }
        leaves.iter().for_each(|leaf| leaf.paint(&mut cells, &field));
        if is_blurred {
            let mut rgb: Vec<f32> = cells.iter().flat_map(|cell| cell.unwrap_or_default()).collect();
            blur(&mut rgb, SIDE, between(rng, BLUR) as f32, [1.0, 1.0]);
            cells.iter_mut().zip(rgb.as_chunks::<3>().0).for_each(|(cell, rgb)| *cell = Some(*rgb));
        }
        Self(cells)
    }

    /// What is seen at a place of the picture, 0 to 1 right and down; `None` as in a cell.
    pub(super) fn at(&self, u: f32, v: f32) -> Option<Rgb> {
        let cell = |at: f32| ((at * SIDE as f32).max(0.0) as usize).min(SIDE - 1);
        self.0[cell(v) * SIDE + cell(u)]
    }
}

impl Leaf {
    fn random(light: [f32; 2], grid: Option<f64>, colours: Surroundings, rng: &mut ChaCha8Rng) -> Self {
        let size = SIZES[0] * libm::pow(SIZES[1] / SIZES[0], unit(rng));
        let long = libm::exp(normal(rng)).clamp(0.05, 20.0).sqrt();
        let turn = match grid {
            Some(turn) if unit(rng) < 0.8 => turn + std::f64::consts::FRAC_PI_2 * (2.0 * unit(rng)).floor(),
            _ => std::f64::consts::TAU * unit(rng),
        };
        let (sin, cos) = libm::sincos(turn);
        let outline = match unit(rng) {
            x if x < 0.32 => Outline::Box,
            x if x < 0.58 => Outline::Ellipse,
            x if x < 0.78 => Outline::Cut([0; 2].map(|_| between(rng, [-0.3, 1.3]) as f32)),
            x if x < 0.9 => Outline::Row(between(rng, [1.5, 7.0]) as f32),
            _ => Outline::Frame(between(rng, [0.6, 0.93]) as f32, unit(rng) < 0.5),
        };
        let pattern = match unit(rng) {
            x if x < 0.3 => Pattern::Plain,
            x if x < 0.7 => Pattern::Gradient,
            x if x < 0.82 => Pattern::Stripes(between(rng, [1.0, 6.0]) as f32),
            _ => Pattern::Blots(between(rng, [5.0, 60.0]) as f32),
        };
        let first = if unit(rng) < 0.5 { colours.any(rng) } else { colours.muted(rng) };
        let second = match unit(rng) < 0.7 {
            true => scale(first, between(rng, [0.3, 1.6]) as f32),
            false => colours.any(rng),
        };
        let dark = if unit(rng) < 0.5 { (0.7 * unit(rng)) as f32 } else { 0.0 };
        Self {
            centre: [0; 2].map(|_| between(rng, [-0.15, 1.15]) as f32),
            half: [size * long, size / long].map(|half| half as f32),
            turn: [sin as f32, cos as f32],
            outline,
            pattern,
            colours: [first, second],
            shadow: light.map(|v| v + (0.2 * size * normal(rng)) as f32 * 0.3),
            dark,
        }
    }

    fn paint(&self, cells: &mut [Option<Rgb>], field: &Lattice) {
        let [sin, cos] = self.turn;
        let reach = |i: usize| {
            let [a, b] = if i == 0 { [cos, sin] } else { [sin, cos] };
            (a * self.half[0]).abs() + (b * self.half[1]).abs() + self.shadow[i].abs()
        };
        let range = |i: usize| {
            let side = SIDE as f32;
            let from = ((self.centre[i] - reach(i)) * side).floor().clamp(0.0, side) as usize;
            let to = ((self.centre[i] + reach(i)) * side).ceil().clamp(0.0, side) as usize;
            from..to
        };
        let inside = |u: f32, v: f32| {
            let (x, y) = (u - self.centre[0], v - self.centre[1]);
            let place = [(cos * x + sin * y) / self.half[0], (cos * y - sin * x) / self.half[1]];
            self.outline.holds(place).then_some(place)
        };
        for row in range(1) {
            for column in range(0) {
                let [u, v] = [column, row].map(|at| (at as f32 + 0.5) / SIDE as f32);
                let cell = &mut cells[row * SIDE + column];
                if let Some(place) = inside(u, v) {
                    *cell = Some(self.colour(place, [u, v], field));
                } else if self.dark > 0.0 && inside(u - self.shadow[0], v - self.shadow[1]).is_some() {
                    *cell = cell.map(|colour| scale(colour, 1.0 - self.dark));
                }
            }
        }
    }

    fn colour(&self, [along, across]: [f32; 2], [u, v]: [f32; 2], field: &Lattice) -> Rgb {
        let [first, second] = self.colours;
        match self.pattern {
            Pattern::Plain => first,
            Pattern::Gradient => mix(first, second, 0.5 + 0.5 * across),
            Pattern::Stripes(count) => {
                let at = along * count;
                if at - at.floor() < 0.5 { first } else { second }
            }
            Pattern::Blots(size) => {
                let share = field.at(u * size, v * size);
                mix(first, second, (3.0 * share - 1.0).clamp(0.0, 1.0))
            }
        }
    }
}

impl Outline {
    /// Whether a place is inside; the outline's box is from -1 to 1.
    fn holds(self, [x, y]: [f32; 2]) -> bool {
        let far = x.abs().max(y.abs());
        if far > 1.0 {
            return false;
        }
        match self {
            Self::Box => true,
            Self::Ellipse => x * x + y * y < 1.0,
            Self::Cut([a, b]) => x + y < 1.0 + a && y - x < 1.0 + b,
            Self::Row(count) => {
                let at = (x + 1.0) * count;
                at - at.floor() < 0.7
            }
            Self::Frame(open, is_round) => {
                let far = if is_round { (x * x + y * y).sqrt() } else { far };
                (open..1.0).contains(&far)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    const GROUND: Rgb = [0.5, 0.25, 0.125];

    fn clutter(seed: u64) -> Clutter {
        Clutter::random(|_, _, _| GROUND, Surroundings { like: None }, &mut ChaCha8Rng::seed_from_u64(seed))
    }

    #[test]
    fn the_same_seed_fills_the_same_room() {
        assert_eq!(clutter(1).0, clutter(1).0);
        assert_ne!(clutter(1).0, clutter(2).0);
    }

    #[test]
    fn rooms_are_filled_with_colours_and_the_ground_is_seen_between_them() {
        let mut shares = Vec::new();
        for seed in 0..40 {
            let clutter = clutter(seed);
            let is_ground = |cell: &&Option<Rgb>| cell.is_none_or(|colour| colour == GROUND);
            shares.push(clutter.0.iter().filter(is_ground).count() as f64 / (SIDE * SIDE) as f64);
            let values = clutter.0.iter().flatten().flatten();
            assert!(values.copied().all(|value| value.is_finite() && value >= 0.0));
        }
        let mean = shares.iter().sum::<f64>() / shares.len() as f64;
        assert!((0.05..0.6).contains(&mean), "{mean}");
    }

    #[test]
    fn places_at_and_beyond_the_edge_are_those_at_the_edge() {
        let clutter = clutter(3);
        assert_eq!(clutter.at(1.0, 1.0), clutter.0[SIDE * SIDE - 1]);
        assert_eq!(clutter.at(-0.2, 7.0), clutter.0[SIDE * (SIDE - 1)]);
    }
}
