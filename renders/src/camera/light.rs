//! Lamps, the light that comes from all around, and the shadows that a hand casts on itself.

use rand_chacha::ChaCha8Rng;

use super::layers::{Layers, SIDE, Texel};
use super::palette::{Rgb, scale};
use crate::random::{between, normal, unit};

/// Lamps at most.
const LAMPS: usize = 2;
/// How often there is a second one.
const SECOND: f64 = 0.35;
/// The share of the light that comes from all around: from a lamp in a dark room to an overcast
/// sky.
const EVEN: [f64; 2] = [0.15, 0.75];
/// Where a ray towards a lamp is looked at, in texels, and how far off the surface it starts.
const STEPS: [f32; 13] = [1.0, 2.0, 3.0, 4.2, 5.6, 7.2, 9.2, 11.6, 14.6, 18.4, 23.2, 29.2, 36.6];
const LIFT: f32 = 1.3;
/// How thick a hand and a thing are, in texels: a ray that passes farther behind them than that is
/// not stopped.
const HAND: f32 = 11.0;
const THING: f32 = 33.0;
/// The share of a hollow's darkness that a lamp's light has there, too.
const LAMP_IN_HOLLOW: f32 = 0.4;

/// The share of each lamp's light that comes in somewhere, 0 to 1.
pub(super) type Shares = [f32; LAMPS];

/// A far lamp.
#[derive(Debug, Clone)]
struct Lamp {
    /// The direction that it is in, in the camera's frame.
    toward: [f32; 3],
    colour: Rgb,
    /// How wide it is seen: how soft shadows are.
    width: f32,
}

/// What a scene is lit by.
#[derive(Debug, Clone)]
pub(super) struct Light {
    lamps: Vec<Lamp>,
    even: Rgb,
    /// Where most of the even light comes from, and how much more than from the other side.
    sky: [f32; 3],
    slope: f32,
    /// How dark hollows are, and the shadows of lamps, 0 to 1.
    hollows: f32,
    shadows: f32,
}

impl Light {
    pub(super) fn random(rng: &mut ChaCha8Rng) -> Self {
        let even = (EVEN[0] * libm::pow(EVEN[1] / EVEN[0], unit(rng))) as f32;
        let warm = 0.12 * normal(rng) as f32;
        let tint = |warm: f32| [1.0 + warm, 1.0, 1.0 - warm];
        let mut lamp = |strength: f32| Lamp {
            // Mostly from above and from the camera's side, now and then from behind the hand.
            toward: unit_of([normal(rng), normal(rng) - 0.8, 0.7 * normal(rng) - 0.5]),
            colour: scale(tint(warm), strength),
            width: between(rng, [0.05, 0.8]) as f32,
        };
        let strength = 1.25 * (1.0 - even);
        let first = lamp(strength);
        let second = lamp(0.5 * strength);
        let count = if unit(rng) < SECOND { LAMPS } else { 1 };
        Self {
            lamps: [first, second].into_iter().take(count).collect(),
            even: scale(tint(-0.5 * warm), even),
            sky: unit_of([0.5 * normal(rng), 0.5 * normal(rng) - 1.0, 0.7 * normal(rng) - 0.3]),
            slope: (0.7 * unit(rng)) as f32,
            hollows: between(rng, [0.2, 1.0]) as f32,
            shadows: if unit(rng) < 0.8 { between(rng, [0.4, 1.0]) as f32 } else { 0.0 },
        }
    }

    /// One lamp above the camera, half of the light from everywhere, and no shadows but in hollows.
    pub(super) fn even() -> Self {
        let lamp = Lamp { toward: unit_of([0.0, -0.8, -0.5]), colour: [0.6; 3], width: 0.4 };
        Self {
            lamps: vec![lamp],
            even: [0.5; 3],
            sky: [0.0, -1.0, 0.0],
            slope: 0.0,
            hollows: 0.6,
            shadows: 0.0,
        }
    }

    /// How much of each lamp's light comes in at a texel of the view.
    pub(super) fn shares(&self, layers: &Layers, x: f32, y: f32) -> Shares {
        let mut shares = [1.0; LAMPS];
        if self.shadows > 0.0 {
            for (share, lamp) in shares.iter_mut().zip(&self.lamps) {
                *share = 1.0 - self.shadows * lamp.hidden(layers, x, y);
            }
        }
        shares
    }

    /// The light that a surface sends back, and the mirrored light. `wrap` is how far behind the
    /// lamps' horizon it is still lit.
    pub(super) fn on(&self, texel: &Texel, shares: Shares, wrap: f32) -> (Rgb, f32) {
        let (normal, shut) = (texel.normal(), self.hollows * texel.shut());
        let from_above = 1.0 + self.slope * dot(normal, self.sky);
        let mut sum = scale(self.even, from_above * (1.0 - shut));
        let mut brightest = 0.0f32;
        for (lamp, share) in self.lamps.iter().zip(shares) {
            let lit = ((dot(normal, lamp.toward) + wrap) / (1.0 + wrap)).max(0.0);
            let left = share * (1.0 - LAMP_IN_HOLLOW * shut);
            (0..3).for_each(|i| sum[i] += lamp.colour[i] * lit * left);
            // Half way between the lamp and the camera, which looks along z.
            let [x, y, z] = lamp.toward;
            let half = unit_of([x, y, z - 1.0].map(f64::from));
            brightest = brightest.max(share * dot(normal, half));
        }
        (sum, brightest)
    }
}

impl Lamp {
    /// How much of it is hidden from a texel by what is nearer to it, 0 to 1.
    ///
    /// The view's depths are looked at along the ray towards it, as if the camera were far away:
    /// what the camera does not see casts no shadow.
    fn hidden(&self, layers: &Layers, x: f32, y: f32) -> f32 {
        let texel = layers.at(x, y);
        let normal = texel.normal();
        if dot(normal, self.toward) <= 0.0 {
            // Turned away: dark as it is.
            return 0.0;
        }
        let [dx, dy, dz] = self.toward;
        let start = [x + LIFT * normal[0], y + LIFT * normal[1], texel.depth() + LIFT * normal[2]];
        let within = 0.0..SIDE as f32;
        let mut hidden = 0.0f32;
        for step in STEPS {
            let (px, py) = (start[0] + dx * step, start[1] + dy * step);
            if !within.contains(&px) || !within.contains(&py) {
                break;
            }
            let before = layers.at(px, py);
            if before.part == 0 {
                continue;
            }
            let behind = start[2] + dz * step - before.depth();
            let thickness = if before.is_object() { THING } else { HAND };
            if behind > 0.0 && behind < thickness {
                hidden = hidden.max((behind / (0.4 + self.width * step)).min(1.0));
            }
        }
        hidden
    }
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn unit_of(v: [f64; 3]) -> [f32; 3] {
    let length = v.iter().map(|v| v * v).sum::<f64>().sqrt().max(1e-6);
    v.map(|v| (v / length) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{PosedHand, Randomised};
    use crate::plan::{Preset, RenderPlan};
    use crate::view::View;
    use rand::SeedableRng;

    fn view(seed: u64) -> Layers {
        let specs = RenderPlan::preset(Preset::Paper).scenes();
        let hand = PosedHand::build(&specs[seed as usize % specs.len()]).expect("a scene");
        let scene = hand.dressed(true, Randomised::ALL, seed);
        scene.layers(&View::random(&mut ChaCha8Rng::seed_from_u64(seed)), 3.0)
    }

    /// How much of a lamp is hidden from each texel that is anything.
    fn hidden(layers: &Layers, toward: [f64; 3]) -> Vec<f32> {
        let lamp = Lamp { toward: unit_of(toward), colour: [1.0; 3], width: 0.1 };
        let places = (0..SIDE * SIDE).map(|at| [at % SIDE, at / SIDE].map(|v| v as f32 + 0.5));
        let seen = places.filter(|[x, y]| layers.at(*x, *y).part != 0);
        seen.map(|[x, y]| lamp.hidden(layers, x, y)).collect()
    }

    #[test]
    fn a_lamp_beside_the_hand_leaves_shadows_and_one_at_the_camera_none() {
        let (mut dark, mut all) = (0, 0);
        for seed in 0..6 {
            let layers = view(seed);
            let at_camera = hidden(&layers, [0.0, 0.0, -1.0]);
            let dark_there = at_camera.iter().filter(|hidden| **hidden > 0.5).count();
            assert!(dark_there * 20 < at_camera.len(), "{dark_there} of {}", at_camera.len());
            let beside = hidden(&layers, [1.0, -0.5, -0.3]);
            assert!(beside.iter().all(|hidden| (0.0..=1.0).contains(hidden)));
            dark += beside.iter().filter(|hidden| **hidden > 0.5).count();
            all += beside.len();
        }
        assert!((all / 50..all / 2).contains(&dark), "{dark} of {all}");
    }

    #[test]
    fn what_faces_the_lamp_is_brighter_and_a_shadow_is_not_black() {
        let layers = view(1);
        let places = (0..SIDE * SIDE).map(|at| [at % SIDE, at / SIDE].map(|v| v as f32 + 0.5));
        let texels: Vec<_> = places.map(|[x, y]| layers.at(x, y)).filter(|texel| texel.part != 0).collect();
        for seed in 0..20 {
            let light = Light::random(&mut ChaCha8Rng::seed_from_u64(seed));
            for texel in &texels {
                let [lit, dark] = [1.0, 0.0].map(|share| light.on(texel, [share; LAMPS], 0.0).0);
                assert!(
                    lit.iter().zip(dark).all(|(lit, dark)| *lit >= dark && dark >= 0.0),
                    "{lit:?} {dark:?}"
                );
            }
        }
    }
}
