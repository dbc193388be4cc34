//! A view becomes a picture.

use rand_chacha::ChaCha8Rng;

use super::background::Background;
use super::dressed::FIRST_OBJECT;
use super::lattice::Lattice;
use super::layers::{Framing, Layers, Texel};
use super::light::Light;
use super::optics::{develop, develop_ideally};
use super::palette::{Rgb, scale};
use super::randomised::Randomised;
use super::surface::{Material, Skin};
use crate::random::{between, normal, unit};

/// Samples a pixel along each side.
const SUPER: usize = 2;
/// How often an arm wears a watch or the like.
const WATCH: f64 = 0.4;
/// How often its strap is nearly black.
const BLACK: f64 = 0.4;
/// Materials that are ready for the parts of a thing.
const MATERIALS: usize = 6;

/// What the masks of a [`Picture`] show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The hand to its wrist.
    Hand,
    /// The bare arm, and what is worn about its wrist.
    Forearm,
    /// What the hand holds.
    Object,
}

impl Part {
    /// All, in the order of [`Picture::masks`].
    pub const ALL: [Part; 3] = [Part::Hand, Part::Forearm, Part::Object];
}

/// A square picture in colour, and where the hand is in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Pixels a side.
    pub side: usize,
    /// Red, green and blue of each pixel, row by row, 0 to 1, as in a picture file (sRGB).
    pub rgb: Vec<f32>,
    /// The share of each pixel that is of a part, 0 to 1.
    pub masks: [Vec<f32>; Part::ALL.len()],
}

/// What covers a view's texels in one picture.
struct Surfaces {
    skin: Skin,
    /// Of the sleeve, if there is one.
    cloth: Option<Material>,
    /// Where a watch or the like is worn, from and to, in metres behind the wrist.
    watch: Option<[f32; 2]>,
    strap: Material,
    things: Vec<Material>,
    light: Light,
    field: Lattice,
}

impl Layers {
    /// A picture of what a framing shows of the view, `side` pixels a side; everything that a view
    /// leaves open is random.
    pub fn paint(&self, framing: &Framing, side: usize, rng: &mut ChaCha8Rng) -> Picture {
        let surfaces = Surfaces::random(self.is_sleeved, self.randomised, rng);
        let background = Background::random(surfaces.skin.colour(), self.randomised, rng);
        let shadow = if self.randomised.light { Shadow::random(framing.side, rng) } else { Shadow::NONE };
        let map = framing.map();
        let mut picture = Picture {
            side,
            rgb: Vec::with_capacity(3 * side * side),
            masks: [0; Part::ALL.len()].map(|_| Vec::with_capacity(side * side)),
        };
        for y in 0..side {
            for x in 0..side {
                let (mut sum, mut parts) = ([0.0; 3], [0.0; Part::ALL.len()]);
                // Neighbouring samples of the same surface have the same colour: one look is
                // enough.
                let mut seen: Option<(u8, Option<Part>, Rgb)> = None;
                for sample in 0..SUPER * SUPER {
                    let place =
                        |at: usize, i: usize| (at as f32 + (i as f32 + 0.5) / SUPER as f32) / side as f32;
                    let [u, v] = framing.border.within(place(x, sample % SUPER), place(y, sample / SUPER));
                    let [tx, ty] = map.place(u, v);
                    let texel = self.at(tx, ty);
                    let part = surfaces.part(texel);
                    let behind = if texel.part == 0 { background.clutter_at(u, v) } else { None };
                    let colour = match (seen, behind) {
                        (_, Some(colour)) => scale(colour, shadow.at(self, tx, ty)),
                        (Some((number, of, colour)), _) if (number, of) == (texel.part, part) => colour,
                        _ if texel.part == 0 => {
                            scale(background.at(u, v, &surfaces.field), shadow.at(self, tx, ty))
                        }
                        _ => surfaces.seen(self, tx, ty),
                    };
                    seen = Some((texel.part, part, colour));
                    (0..3).for_each(|i| sum[i] += colour[i]);
                    if let Some(part) = part {
                        parts[part as usize] += 1.0;
                    }
                }
                let share = 1.0 / (SUPER * SUPER) as f32;
                picture.rgb.extend(sum.map(|v| v * share));
                picture.masks.iter_mut().zip(parts).for_each(|(mask, count)| mask.push(count * share));
            }
        }
        match self.randomised.camera {
            true => develop(&mut picture.rgb, side, side as f32 / framing.side, rng),
            false => develop_ideally(&mut picture.rgb),
        }
        picture
    }
}

impl Surfaces {
    fn random(is_sleeved: bool, randomised: Randomised, rng: &mut ChaCha8Rng) -> Self {
        let cloth = is_sleeved.then(|| Material::cloth(rng));
        let watch = (unit(rng) < WATCH && randomised.arms).then(|| {
            let from = between(rng, [0.012, 0.05]) as f32;
            [from, from + between(rng, [0.012, 0.05]) as f32]
        });
        let material = if randomised.materials { Material::random } else { Material::plain };
        Self {
            skin: if randomised.skin { Skin::random(rng) } else { Skin::even() },
            cloth,
            watch,
            strap: if unit(rng) < BLACK { Material::black(rng) } else { Material::random(rng) },
            things: (0..MATERIALS).map(|_| material(rng)).collect(),
            light: if randomised.light { Light::random(rng) } else { Light::even() },
            field: Lattice::random(rng),
        }
    }

    /// Which of the masks a texel belongs to.
    fn part(&self, texel: &Texel) -> Option<Part> {
        if texel.is_hand() {
            return Some(Part::Hand);
        }
        if texel.is_object() {
            return Some(Part::Object);
        }
        (texel.is_arm() && self.sleeve(texel).is_none()).then_some(Part::Forearm)
    }

    /// The sleeve, where one covers a texel of the arm.
    fn sleeve(&self, texel: &Texel) -> Option<&Material> {
        self.cloth.as_ref().filter(|_| texel.is_far_arm())
    }

    /// What covers a texel of the arm.
    fn cover(&self, texel: &Texel) -> Option<&Material> {
        let back = -texel.place()[0];
        self.sleeve(texel)
            .or_else(|| self.watch.filter(|[from, to]| (from..to).contains(&&back)).map(|_| &self.strap))
    }

    fn seen(&self, layers: &Layers, x: f32, y: f32) -> Rgb {
        let (texel, light, field) = (layers.at(x, y), &self.light, &self.field);
        let shares = light.shares(layers, x, y);
        if texel.is_object() {
            let material = &self.things[usize::from(texel.part - FIRST_OBJECT) % self.things.len()];
            return material.seen(texel, light, shares, field);
        }
        match self.cover(texel).filter(|_| texel.is_arm()) {
            Some(material) => material.seen(texel, light, shares, field),
            None => self.skin.seen(texel, light, shares, field),
        }
    }
}

/// The hand's shadow on what lies behind.
struct Shadow {
    /// By how many texels it is moved.
    by: [f32; 2],
    strength: f32,
}

impl Shadow {
    const NONE: Self = Self { by: [0.0; 2], strength: 0.0 };

    fn random(side: f32, rng: &mut ChaCha8Rng) -> Self {
        let strength = if unit(rng) < 0.4 { (0.7 * unit(rng)) as f32 } else { 0.0 };
        Self { by: [0; 2].map(|_| 0.08 * side * normal(rng) as f32), strength }
    }

    /// The share of the light that is left at a texel.
    fn at(&self, layers: &Layers, x: f32, y: f32) -> f32 {
        if self.strength == 0.0 {
            return 1.0;
        }
        let [dx, dy] = self.by;
        let hit = [[-2.0, 0.0], [2.0, 0.0], [0.0, -2.0], [0.0, 2.0]]
            .iter()
            .filter(|[sx, sy]| layers.at(x + dx + sx, y + dy + sy).part != 0)
            .count();
        1.0 - self.strength * hit as f32 / 4.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::PosedHand;
    use crate::plan::{Preset, RenderPlan};
    use crate::view::View;
    use rand::SeedableRng;

    const SIDE: usize = 48;

    fn view(scene: usize, is_held: bool, view: u64) -> Layers {
        let specs = RenderPlan::preset(Preset::Paper).scenes();
        let scene = PosedHand::build(&specs[scene]).expect("a scene").dressed(is_held, Randomised::ALL, view);
        let mut rng = ChaCha8Rng::seed_from_u64(view);
        scene.layers(&View::random(&mut rng), 3.0)
    }

    fn area(mask: &[f32]) -> f32 {
        mask.iter().sum()
    }

    #[test]
    fn the_same_seed_paints_the_same_picture_and_another_one_another() {
        let layers = view(0, true, 1);
        let paint = |seed| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let framing = Framing::far(&layers, &mut rng);
            layers.paint(&framing, SIDE, &mut rng)
        };
        assert_eq!(paint(3), paint(3));
        assert_ne!(paint(3).rgb, paint(4).rgb);
    }

    #[test]
    fn without_all_that_is_random_a_hand_looks_the_same_each_time() {
        let specs = RenderPlan::preset(Preset::Paper).scenes();
        let nothing = Randomised {
            light: false,
            background: false,
            clutter: false,
            skin: false,
            materials: false,
            things: false,
            arms: false,
            camera: false,
            borders: false,
        };
        let hand = |randomised, seed| {
            let scene = PosedHand::build(&specs[0]).expect("a scene").dressed(true, randomised, 1);
            let layers = scene.layers(&View::random(&mut ChaCha8Rng::seed_from_u64(1)), 3.0);
            let framing = Framing::near(&layers, &mut ChaCha8Rng::seed_from_u64(1));
            let picture = layers.paint(&framing, SIDE, &mut ChaCha8Rng::seed_from_u64(seed));
            let pixels = picture.rgb.as_chunks::<3>().0.iter().zip(&picture.masks[Part::Hand as usize]);
            pixels.filter(|(_, share)| **share == 1.0).map(|(rgb, _)| *rgb).collect::<Vec<_>>()
        };
        // Up to the camera's gain, which brings the picture's mean to a sixth, and white.
        let differ = |a: Vec<[f32; 3]>, b: Vec<[f32; 3]>| {
            assert_eq!(a.len(), b.len());
            let pairs = a.iter().flatten().zip(b.iter().flatten());
            let seen = pairs.filter(|(a, b)| a.max(**b) < 0.99 && a.min(**b) > 0.05);
            let ratios: Vec<f32> = seen.map(|(a, b)| libm::logf(a / b)).collect();
            let gain = ratios.iter().sum::<f32>() / ratios.len() as f32;
            ratios.iter().map(|ratio| (ratio - gain).abs()).reduce(f32::max).expect("pixels to compare")
        };
        assert!(differ(hand(nothing, 1), hand(nothing, 2)) < 0.02);
        for some in [
            Randomised { skin: true, ..nothing },
            Randomised { light: true, ..nothing },
            Randomised { camera: true, ..nothing },
        ] {
            assert!(differ(hand(some, 1), hand(some, 2)) > 0.05, "{some:?}");
        }
    }

    #[test]
    fn a_pixel_is_shared_by_the_parts_and_what_lies_behind() {
        for seed in 0..12 {
            let layers = view(seed as usize % 6, true, seed);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let framing = Framing::near(&layers, &mut rng);
            let picture = layers.paint(&framing, SIDE, &mut rng);
            assert_eq!(picture.rgb.len(), 3 * SIDE * SIDE);
            assert!(picture.rgb.iter().all(|value| (0.0..=1.0).contains(value)));
            for at in 0..SIDE * SIDE {
                let shares: f32 = picture.masks.iter().map(|mask| mask[at]).sum();
                assert!((0.0..=1.0).contains(&shares), "{shares}");
            }
            let hand = area(&picture.masks[Part::Hand as usize]) / (SIDE * SIDE) as f32;
            assert!((0.02..0.5).contains(&hand), "a near picture shows the hand large: {hand}");
        }
    }

    #[test]
    fn what_a_bare_arm_wears_is_of_the_arm() {
        let bare: Vec<Layers> = (0..12).map(|seed| view(0, true, seed)).filter(|v| !v.is_sleeved).collect();
        let layers = bare.first().expect("an arm without a sleeve");
        let framing = Framing::near(layers, &mut ChaCha8Rng::seed_from_u64(1));
        let masks = |seed| layers.paint(&framing, SIDE, &mut ChaCha8Rng::seed_from_u64(seed)).masks;
        // Two in five pictures have a watch.
        assert!(area(&masks(0)[Part::Forearm as usize]) > 20.0);
        assert!((1..12).all(|seed| masks(seed) == masks(0)));
    }

    #[test]
    fn a_thing_is_larger_in_a_square_around_it_and_a_hand_without_one_is_looked_at_itself() {
        let share = |framing: fn(&Layers, &mut ChaCha8Rng) -> Framing| {
            let shares = (0..12).map(|seed| {
                let layers = view(0, true, seed);
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                let framing = framing(&layers, &mut rng);
                area(&layers.paint(&framing, SIDE, &mut rng).masks[Part::Object as usize])
            });
            shares.sum::<f32>() / (12 * SIDE * SIDE) as f32
        };
        let (thing, found) = (share(Framing::thing), share(Framing::found));
        assert!(thing > 1.2 * found, "{thing} in place of {found}");
        let empty = view(0, false, 1);
        let framing =
            |of: fn(&Layers, &mut ChaCha8Rng) -> Framing| of(&empty, &mut ChaCha8Rng::seed_from_u64(1));
        assert_eq!(framing(Framing::thing), framing(Framing::found));
    }

    #[test]
    fn a_near_picture_has_the_arm_below_the_hand_and_empty_hands_hold_nothing() {
        let (mut below, mut seen) = (0, 0);
        for seed in 0..24 {
            let layers = view(seed as usize % 6, false, seed);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let framing = Framing::near(&layers, &mut rng);
            let picture = layers.paint(&framing, SIDE, &mut rng);
            assert_eq!(area(&picture.masks[Part::Object as usize]), 0.0);
            let [hand, forearm] = [Part::Hand, Part::Forearm].map(|part| {
                let mask = &picture.masks[part as usize];
                let rows = mask.iter().enumerate().map(|(at, share)| share * (at / SIDE) as f32);
                (area(mask), rows.sum::<f32>() / area(mask).max(1e-3))
            });
            if forearm.0 > 20.0 {
                seen += 1;
                below += usize::from(forearm.1 > hand.1);
            }
        }
        assert!(seen > 5 && below * 10 >= seen * 8, "{below} of {seen}");
    }
}
