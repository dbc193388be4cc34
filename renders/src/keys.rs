//! The encodings of all that a picture follows from: its key and its seeds are hashes of them.

use grasp_canonical::{Canonical, Encoder};

use crate::grasp::{
    Example, Grasp, Object, ObjectKind, ObjectRange, PlacedObject, Placement, Stage, StagePose,
};
use crate::hand::{Digit, FingerMeasures, HandPose, HandShape};
use crate::scene::{Look, SceneSpec};
use crate::view::{View, ViewGrid, Views};

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

#[cfg(test)]
mod tests {
    use crate::plan::{Preset, RenderPlan};

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
