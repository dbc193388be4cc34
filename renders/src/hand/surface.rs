//! The skin: a signed distance built of round cones around the bones.
//!
//! Only parts that are neighbours on a real hand are blended (palm, finger roots, thumb);
//! everything else is a plain union, so that fingers that touch do not grow together.

use nalgebra::Vector3;

use super::{Chain, Digit, HandPose, Skeleton};
use crate::mesh::{Field, RoundCone, RoundTriangle, smooth_union};

/// How wide the creases are filled, in metres.
const PALM_BLEND: f64 = 0.014;
const FINGER_ROOT_BLEND: f64 = 0.010;
const THUMB_BLEND: f64 = 0.012;

/// Where the hand is cut when it has no forearm: this far behind the wrist's centre, in metres.
pub(crate) const WRIST_CUT: f64 = 0.012;

type V = Vector3<f64>;

/// A posed hand's skin.
#[derive(Debug, Clone)]
pub(crate) struct HandSurface {
    palm: Vec<RoundCone>,
    webs: Vec<RoundTriangle>,
    digits: Vec<(Digit, [RoundCone; 3])>,
    cut: f64,
}

impl HandSurface {
    /// The skin of a hand in a pose, cut `forearm` metres behind the wrist.
    pub(crate) fn new(skeleton: &Skeleton, pose: &HandPose, forearm: f64) -> HandSurface {
        let chains = skeleton.chains(pose);
        let bones = |chain: &Chain| {
            std::array::from_fn(|i| {
                RoundCone::new([chain.points[i], chain.points[i + 1]], [chain.radii[i], chain.radii[i + 1]])
            })
        };
        let digits = Digit::ALL.map(|digit| (digit, bones(&chains[digit as usize]))).to_vec();
        let cut = WRIST_CUT + forearm.max(0.0);
        HandSurface { palm: palm(skeleton, &chains, cut), webs: webs(skeleton, &chains), digits, cut }
    }

    /// The x coordinate of the cut, in metres.
    pub(crate) fn cut_x(&self) -> f64 {
        -self.cut
    }

    /// A box around the skin: lowest and highest corner.
    pub(crate) fn bounds(&self) -> (V, V) {
        let mut low = V::repeat(f64::INFINITY);
        let mut high = V::repeat(f64::NEG_INFINITY);
        for cone in self.palm.iter().chain(self.digits.iter().flat_map(|(_, bones)| bones)) {
            for (c, r) in cone.ends() {
                low = low.inf(&(c - V::repeat(r + PALM_BLEND)));
                high = high.sup(&(c + V::repeat(r + PALM_BLEND)));
            }
        }
        low.x = low.x.max(-self.cut - 0.005);
        (low, high)
    }
}

impl Field for HandSurface {
    /// At most the distance in metres near blends.
    fn distance(&self, p: &V) -> f64 {
        let mut palm = f64::INFINITY;
        for cone in &self.palm {
            palm = smooth_union(palm, cone.distance(p), PALM_BLEND);
        }
        for web in &self.webs {
            palm = smooth_union(palm, web.distance(p), FINGER_ROOT_BLEND);
        }
        let mut skin = palm;
        for (digit, bones) in &self.digits {
            let [first, second, third] = bones.map(|bone| bone.distance(p));
            // Bones of a digit share the ball of their joint: nothing to fill there. The thumb's
            // first bone lies wholly in its ball, so the second takes part in the blend.
            let blended = if *digit == Digit::Thumb {
                smooth_union(palm, first.min(second), THUMB_BLEND)
            } else {
                smooth_union(palm, first, FINGER_ROOT_BLEND).min(second)
            };
            skin = skin.min(blended).min(third);
        }
        skin.max(-self.cut - p.x)
    }

    fn near(&self, centre: &V, radius: f64) -> HandSurface {
        // A part takes part in a blend where it lies no farther than the blend is wide beyond the
        // nearest part, and what it adds there may take part in the next.
        let bones = |(_, bones): &(Digit, [RoundCone; 3])| {
            bones.iter().map(|bone| bone.distance(centre)).fold(f64::INFINITY, f64::min)
        };
        let palm: Vec<f64> = self.palm.iter().map(|cone| cone.distance(centre)).collect();
        let webs: Vec<f64> = self.webs.iter().map(|web| web.distance(centre)).collect();
        let digits: Vec<f64> = self.digits.iter().map(bones).collect();
        let least = palm.iter().chain(&webs).chain(&digits).copied().fold(f64::INFINITY, f64::min);
        let limit = least + 2.0 * radius + 1.5 * PALM_BLEND;
        HandSurface {
            palm: within(&self.palm, &palm, limit),
            webs: within(&self.webs, &webs, limit),
            digits: within(&self.digits, &digits, limit),
            cut: self.cut,
        }
    }
}

/// The parts whose distance is within a limit.
fn within<T: Copy>(parts: &[T], distances: &[f64], limit: f64) -> Vec<T> {
    parts.iter().zip(distances).filter(|(_, distance)| **distance <= limit).map(|(part, _)| *part).collect()
}

/// Bodies of the palm: the four metacarpals, the pad under the knuckles, the two balls of the hand,
/// the wrist.
fn palm(skeleton: &Skeleton, chains: &[Chain; 5], cut: f64) -> Vec<RoundCone> {
    let shape = skeleton.shape();
    let thick = shape.palm_thickness;
    let wrist = shape.wrist_thickness * 0.5;
    // The carpal row: as wide as the wrist once the flesh is added.
    let spread = (shape.wrist_breadth * 0.5 - wrist * 0.86).max(0.004);
    let carpal = |side: f64| V::new(0.10 * shape.palm_length, spread * side, -0.10 * thick);
    let mut cones = Vec::new();
    for (finger, side) in Digit::FINGERS.into_iter().zip([1.0, 0.35, -0.35, -1.0]) {
        let knuckle = chains[finger as usize].points[0];
        cones.push(RoundCone::new([carpal(side), knuckle], [wrist * 0.80, 0.31 * thick]));
        // The pad on the palm's side.
        let pad = V::new(-0.06 * shape.palm_length, 0.0, -0.22 * thick);
        cones.push(RoundCone::new(
            [carpal(side) + V::new(0.25 * shape.palm_length, 0.0, -0.10 * thick), knuckle + pad],
            [0.40 * thick, 0.34 * thick],
        ));
    }
    // The ball of the little finger.
    cones.push(RoundCone::new(
        [skeleton.palm_point([0.18, -0.24, -0.36]), skeleton.palm_point([0.62, -0.38, -0.34])],
        [0.46 * thick, 0.38 * thick],
    ));
    // The ball of the thumb follows its metacarpal.
    let thumb = &chains[0];
    let belly = thumb.points[0] + (thumb.points[1] - thumb.points[0]) * 0.72;
    cones.push(RoundCone::new(
        [skeleton.palm_point([0.20, 0.10, -0.34]), belly - thumb_side(thumb) * 0.12 * thick],
        [0.46 * thick, 0.44 * thick],
    ));
    // The wrist and, behind it, the forearm.
    for side in [-1.0, 1.0] {
        cones.push(RoundCone::new(
            [carpal(side * 0.9), V::new(-cut - wrist, spread * side, -0.06 * thick)],
            [wrist * 0.84, wrist * 0.86 * (1.0 + cut * 1.2)],
        ));
    }
    cones
}

/// Out of the thumb's back at its metacarpal.
fn thumb_side(thumb: &Chain) -> V {
    let along = (thumb.points[1] - thumb.points[0]).normalize();
    (thumb.nail - along * along.dot(&thumb.nail)).try_normalize(1e-9).unwrap_or_else(V::zeros)
}

/// Skin between neighbouring fingers, over the metacarpals, and between thumb and index finger.
fn webs(skeleton: &Skeleton, chains: &[Chain; 5]) -> Vec<RoundTriangle> {
    let thick = skeleton.shape().palm_thickness;
    let along = |chain: &Chain, bone: usize, t: f64| {
        chain.points[bone] + (chain.points[bone + 1] - chain.points[bone]) * t
    };
    let mut webs = Vec::new();
    for pair in chains[1..].windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        let low = V::new(0.0, 0.0, -0.10 * thick);
        webs.push(RoundTriangle::new(
            [along(a, 0, 0.24) + low, along(b, 0, 0.30) + low, (a.points[0] + b.points[0]) * 0.5 + low],
            0.20 * thick,
        ));
    }
    // Tendons and skin fill the valleys between the metacarpals: the back of the hand is even.
    for pair in chains[1..].windows(2) {
        let (a, b) = (pair[0].points[0], pair[1].points[0]);
        let middle = V::new(0.25 * skeleton.shape().palm_length, 0.275 * (a.y + b.y), 0.0);
        let rise = V::new(0.0, 0.0, 0.02 * thick);
        webs.push(RoundTriangle::new([a + rise, b + rise, middle + rise], 0.26 * thick));
    }
    let thumb = &chains[0];
    let index = chains[1].points[0];
    let heel = skeleton.palm_point([0.35, 0.16, -0.15]);
    webs.push(RoundTriangle::new([along(thumb, 0, 0.88), heel + (index - heel) * 0.80, heel], 0.24 * thick));
    webs.push(RoundTriangle::new([thumb.points[0], along(thumb, 0, 0.88), heel], 0.28 * thick));
    webs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hand::HandShape;

    #[test]
    fn bones_lie_inside_and_the_air_outside() {
        let skeleton = Skeleton::new(&HandShape::mean());
        let pose = HandPose {
            digits: [[0.7, 0.5, 1.2, 0.2, 0.2], [0.1, 0.3, 0.4, 0.2, 0.0], [0.0; 5], [0.0; 5], [0.0; 5]],
        };
        let skin = HandSurface::new(&skeleton, &pose, 0.0);
        for chain in skeleton.chains(&pose) {
            for p in &chain.points {
                assert!(skin.distance(p) < -0.004);
            }
        }
        assert!(skin.distance(&V::new(0.05, 0.0, 0.05)) > 0.02);
        assert!(skin.distance(&V::new(-0.02, 0.0, 0.0)) > 0.0, "cut at the wrist");
        let long = HandSurface::new(&skeleton, &pose, 0.1);
        assert!(long.distance(&V::new(-0.08, 0.0, 0.0)) < 0.0, "a forearm where one is asked for");
    }

    #[test]
    fn touching_fingers_do_not_grow_together() {
        let skeleton = Skeleton::new(&HandShape::mean());
        let straight = |spread: f64| [spread, 0.0, 0.0, 0.0, 0.0];
        let pose = HandPose {
            digits: [[0.7, 0.5, 1.2, 0.2, 0.2], straight(-0.02), straight(0.0), straight(0.0), straight(0.0)],
        };
        let chains = skeleton.chains(&pose);
        let skin = HandSurface::new(&skeleton, &pose, 0.0);
        // Half way between the end joints of the index and middle finger, and above: no fillet
        // there.
        let between = (chains[1].points[2] + chains[2].points[2]) * 0.5 + V::new(0.0, 0.0, 0.006);
        let naive = chains.iter().map(|c| c.distance(&between, 0)).fold(f64::INFINITY, f64::min);
        assert!((skin.distance(&between) - naive).abs() < 5e-4);
    }
}
