//! Values as canonical bytes: what persistent keys and seeds are hashes of.
//!
//! A key must not change because a field was renamed or because a library prints numbers in another
//! way, so that nothing here goes through text. The encoding:
//!
//! - it begins with the byte [`ENCODING_VERSION`];
//! - a struct is its fields in the order in which `encode` lists them, without names or padding;
//! - an integer is little-endian in the width of its method, a length or a count is a `u64`;
//! - a floating-point number is its IEEE 754 bits, little-endian; -0.0 is normalised to 0.0 and any
//!   NaN to one quiet NaN, so that values that compare equal have the same bytes;
//! - a string is its length in bytes, then UTF-8; a sequence is its length, then its elements; an
//!   array of fixed length is its elements alone;
//! - an enum is one byte, a number that a variant keeps for ever, then the variant's fields;
//! - an option is the byte 0, or the byte 1 and the value.
//!
//! Every `encode` takes its struct apart without `..`, so that a new field does not compile until
//! somebody has decided where it stands. A change of the encoding raises [`ENCODING_VERSION`].

use nalgebra::{UnitQuaternion, Vector3};
use xxhash_rust::xxh3::xxh3_64;

use crate::grasp::{
    Example, Grasp, Object, ObjectKind, ObjectRange, PlacedObject, Placement, Stage, StagePose,
};
use crate::hand::{Digit, FingerMeasures, HandPose, HandShape};
use crate::scene::{Look, SceneSpec};
use crate::view::{View, ViewGrid, Views};

/// The first byte of every encoding; rises when the same value gives other bytes than before.
pub const ENCODING_VERSION: u8 = 1;

/// A value that has a canonical encoding.
pub trait Canonical {
    /// Appends the value's bytes.
    fn encode(&self, to: &mut Encoder);
}

/// Collects the bytes of values, one after the other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Encoder {
    bytes: Vec<u8>,
}

impl Default for Encoder {
    fn default() -> Encoder {
        Encoder { bytes: vec![ENCODING_VERSION] }
    }
}

impl Encoder {
    /// An encoding of nothing but its version.
    pub fn new() -> Encoder {
        Encoder::default()
    }

    /// The bytes so far.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The XXH3 hash of the bytes so far.
    pub fn hash(&self) -> u64 {
        xxh3_64(&self.bytes)
    }

    /// Appends a byte; also an enum's number.
    pub fn u8(&mut self, value: u8) -> &mut Encoder {
        self.bytes.push(value);
        self
    }

    /// Appends an integer of 32 bits.
    pub fn u32(&mut self, value: u32) -> &mut Encoder {
        self.bytes.extend(value.to_le_bytes());
        self
    }

    /// Appends an integer of 64 bits.
    pub fn u64(&mut self, value: u64) -> &mut Encoder {
        self.bytes.extend(value.to_le_bytes());
        self
    }

    /// Appends a length or a count.
    pub fn count(&mut self, value: usize) -> &mut Encoder {
        self.u64(value as u64)
    }

    /// Appends a number.
    pub fn f64(&mut self, value: f64) -> &mut Encoder {
        // The sum turns -0.0 into 0.0.
        let value = if value.is_nan() { f64::NAN.copysign(1.0) } else { value + 0.0 };
        self.u64(value.to_bits())
    }

    /// Appends numbers of which there are always as many.
    pub fn f64s(&mut self, values: &[f64]) -> &mut Encoder {
        values.iter().for_each(|&value| {
            self.f64(value);
        });
        self
    }

    /// Appends a string.
    pub fn text(&mut self, value: &str) -> &mut Encoder {
        self.count(value.len());
        self.bytes.extend(value.as_bytes());
        self
    }

    /// Appends a value.
    pub fn value(&mut self, value: &impl Canonical) -> &mut Encoder {
        value.encode(self);
        self
    }

    /// Appends values of which there may be any number.
    pub fn values(&mut self, values: &[impl Canonical]) -> &mut Encoder {
        self.count(values.len());
        values.iter().for_each(|value| value.encode(self));
        self
    }

    /// Appends a value that may be missing.
    pub fn option(&mut self, value: Option<&impl Canonical>) -> &mut Encoder {
        match value {
            None => self.u8(0),
            Some(value) => self.u8(1).value(value),
        }
    }
}

impl Canonical for SceneSpec {
    fn encode(&self, to: &mut Encoder) {
        let SceneSpec { hand_shape, hand_model, grasp, stage, object, example, held, look, seed } = self;
        to.value(&**hand_shape).option(hand_model.as_deref()).value(&**grasp).value(stage).value(object);
        to.option(example.as_ref()).option(held.as_ref()).value(look).u64(*seed);
    }
}

impl Canonical for Look {
    fn encode(&self, to: &mut Encoder) {
        let Look { side, forearm, arm, sleeve, distance, distance_variation, light_variation, cell } = *self;
        to.count(side);
        to.f64s(&[forearm, arm, sleeve, distance, distance_variation, light_variation, cell]);
    }
}

impl Canonical for HandShape {
    fn encode(&self, to: &mut Encoder) {
        let HandShape {
            name,
            palm_length,
            palm_breadth,
            palm_thickness,
            wrist_breadth,
            wrist_thickness,
            digits,
        } = self;
        to.text(name);
        to.f64s(&[*palm_length, *palm_breadth, *palm_thickness, *wrist_breadth, *wrist_thickness]);
        digits.iter().for_each(|digit| digit.encode(to));
    }
}

impl Canonical for FingerMeasures {
    fn encode(&self, to: &mut Encoder) {
        let FingerMeasures { bones, breadth, tip_breadth } = *self;
        to.f64s(&bones).f64(breadth).f64(tip_breadth);
    }
}

impl Canonical for HandPose {
    fn encode(&self, to: &mut Encoder) {
        let HandPose { digits } = self;
        to.f64s(digits.as_flattened());
    }
}

impl Canonical for Digit {
    fn encode(&self, to: &mut Encoder) {
        to.u8(match self {
            Digit::Thumb => 0,
            Digit::Index => 1,
            Digit::Middle => 2,
            Digit::Ring => 3,
            Digit::Little => 4,
        });
    }
}

impl Canonical for Stage {
    fn encode(&self, to: &mut Encoder) {
        to.u8(match self {
            Stage::Reach => 0,
            Stage::Close => 1,
            Stage::Grasp => 2,
        });
    }
}

impl Canonical for Grasp {
    fn encode(&self, to: &mut Encoder) {
        // `about` is left out: words about a grasp decide no pixel.
        let Grasp {
            name,
            cutkosky,
            about: _,
            up,
            touch,
            follow,
            object,
            relaxed,
            open,
            closed,
            stages,
            examples,
        } = self;
        to.text(name).u8(*cutkosky).value(up).values(touch).values(follow).value(object);
        to.value(relaxed).value(open).value(closed);
        stages.iter().for_each(|stage| stage.encode(to));
        to.values(examples);
    }
}

impl Canonical for StagePose {
    fn encode(&self, to: &mut Encoder) {
        let StagePose { closure, away } = *self;
        to.f64(closure).f64(away);
    }
}

impl Canonical for Example {
    fn encode(&self, to: &mut Encoder) {
        let Example { stage, pose, object } = self;
        to.value(stage).value(pose).value(object);
    }
}

impl Canonical for ObjectRange {
    fn encode(&self, to: &mut Encoder) {
        let ObjectRange { kind, radius, length, axis, placement } = self;
        to.value(kind).f64s(radius).f64s(length).value(axis).value(placement);
    }
}

impl Canonical for ObjectKind {
    fn encode(&self, to: &mut Encoder) {
        to.u8(match self {
            ObjectKind::Cylinder => 0,
            ObjectKind::Disc => 1,
            ObjectKind::Sphere => 2,
        });
    }
}

impl Canonical for Placement {
    fn encode(&self, to: &mut Encoder) {
        match self {
            Placement::Palm { anchor, push } => to.u8(0).f64s(anchor).value(push),
            Placement::Tips { between } => to.u8(1).values(between),
        };
    }
}

impl Canonical for Object {
    fn encode(&self, to: &mut Encoder) {
        match *self {
            Object::Cylinder { radius, length } => to.u8(0).f64(radius).f64(length),
            Object::Sphere { radius } => to.u8(1).f64(radius),
        };
    }
}

impl Canonical for PlacedObject {
    fn encode(&self, to: &mut Encoder) {
        let PlacedObject { object, centre, turn } = self;
        to.value(object).value(centre).value(turn);
    }
}

impl Canonical for Views {
    fn encode(&self, to: &mut Encoder) {
        match self {
            Views::Grid(grid) => to.u8(0).value(grid),
            Views::Random(count) => to.u8(1).count(*count),
        };
    }
}

impl Canonical for ViewGrid {
    fn encode(&self, to: &mut Encoder) {
        let ViewGrid { step_deg, elevation_deg, rolls_deg } = self;
        to.f64(*step_deg).f64s(elevation_deg).count(rolls_deg.len()).f64s(rolls_deg);
    }
}

impl Canonical for View {
    fn encode(&self, to: &mut Encoder) {
        let View { azimuth_deg, elevation_deg, roll_deg } = *self;
        to.f64s(&[azimuth_deg, elevation_deg, roll_deg]);
    }
}

impl Canonical for f64 {
    fn encode(&self, to: &mut Encoder) {
        to.f64(*self);
    }
}

impl Canonical for Vector3<f64> {
    /// x, y, z.
    fn encode(&self, to: &mut Encoder) {
        to.f64s(&[self.x, self.y, self.z]);
    }
}

impl Canonical for UnitQuaternion<f64> {
    /// x, y, z, w.
    fn encode(&self, to: &mut Encoder) {
        to.f64s(&[self.i, self.j, self.k, self.w]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Preset, RenderPlan};

    #[test]
    fn bytes_are_those_of_the_description() {
        let mut to = Encoder::new();
        to.u8(7).u32(1).count(2).f64(-0.0).f64(1.0).text("é").values(&[Digit::Ring]).option(None::<&Stage>);
        to.option(Some(&Stage::Grasp));
        let expected = [
            &[ENCODING_VERSION, 7, 1, 0, 0, 0][..],
            &[2, 0, 0, 0, 0, 0, 0, 0],
            &[0; 8],
            &[0, 0, 0, 0, 0, 0, 0xf0, 0x3f],
            &[2, 0, 0, 0, 0, 0, 0, 0, 0xc3, 0xa9],
            &[1, 0, 0, 0, 0, 0, 0, 0, 3],
            &[0, 1, 2],
        ]
        .concat();
        assert_eq!(to.bytes(), expected);
        let nan = |value: f64| Encoder::new().f64(value).hash();
        assert_eq!(nan(f64::NAN), nan(-f64::NAN));
    }

    #[test]
    fn words_about_a_grasp_redraw_nothing() {
        let scene = &RenderPlan::preset(Preset::Paper).scenes()[0];
        let mut other = scene.clone();
        std::sync::Arc::make_mut(&mut other.grasp).about.push('!');
        assert_eq!(other.params_hash(), scene.params_hash());
        std::sync::Arc::make_mut(&mut other.grasp).name.push('!');
        assert_ne!(other.params_hash(), scene.params_hash());
    }

    /// The first and the last scene of each preset.
    #[test]
    fn keys_of_scenes_are_pinned() {
        let keys = Preset::ALL.map(|preset| {
            let scenes = RenderPlan::preset(preset).scenes();
            [&scenes[0], &scenes[scenes.len() - 1]].map(|scene| format!("{:016x}", scene.params_hash()))
        });
        let pinned = [
            ["7277cd7571de5b22", "2084af1674573801"],
            ["5ce73a444cdd23eb", "6b88cda2035e6420"],
            ["5ce73a444cdd23eb", "e2e0aeb1f5725f91"],
        ];
        assert_eq!(
            keys, pinned,
            "the keys and seeds of scenes changed, so that every picture is drawn anew: if that is \
             meant, raise ENCODING_VERSION (other bytes of the same values) or RENDERER_VERSION (other values), and pin these"
        );
    }
}
