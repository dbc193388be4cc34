//! Objects on a table that come with the program, each with the grasp and the approach that fit it.

use crate::{ApproachSide, Object, RobotError};

/// An object and how it is taken.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// What commands and tables call it.
    pub name: &'static str,
    /// The robot's grasp.
    pub grasp: &'static str,
    /// From where the hand comes.
    pub from: ApproachSide,
    /// Whether the hand's turn about the vertical makes no difference to the object.
    pub is_round: bool,
    text: &'static str,
}

/// All that there are.
pub const SCENES: [Scene; 8] = [
    Scene {
        name: "cylinder-upright",
        grasp: "wrap",
        from: ApproachSide::Side,
        is_round: true,
        text: include_str!("../../../data/objects/cylinder-upright.toml"),
    },
    Scene {
        name: "cylinder-lying",
        grasp: "wrap",
        from: ApproachSide::Top,
        is_round: false,
        text: include_str!("../../../data/objects/cylinder-lying.toml"),
    },
    Scene {
        name: "box",
        grasp: "wrap",
        from: ApproachSide::Top,
        is_round: false,
        text: include_str!("../../../data/objects/box.toml"),
    },
    Scene {
        name: "sphere",
        grasp: "wrap",
        from: ApproachSide::Top,
        is_round: true,
        text: include_str!("../../../data/objects/sphere.toml"),
    },
    Scene {
        name: "disc",
        grasp: "precision-disc",
        from: ApproachSide::Top,
        is_round: true,
        text: include_str!("../../../data/objects/disc.toml"),
    },
    Scene {
        name: "block",
        grasp: "two-finger-thumb",
        from: ApproachSide::Top,
        is_round: false,
        text: include_str!("../../../data/objects/block.toml"),
    },
    Scene {
        name: "stick",
        grasp: "wrap",
        from: ApproachSide::Side,
        is_round: true,
        text: include_str!("../../../data/objects/stick.toml"),
    },
    Scene {
        name: "handle",
        grasp: "wrap",
        from: ApproachSide::Side,
        is_round: true,
        text: include_str!("../../../data/objects/handle.toml"),
    },
];

impl Scene {
    /// The scene of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        SCENES.iter().find(|scene| scene.name == name)
    }

    /// The scene in which a person would make this grasp.
    pub fn for_human(grasp: &str) -> Option<&'static Self> {
        let name = match grasp {
            "large-diameter" => "cylinder-upright",
            "small-diameter" => "stick",
            "abducted-thumb" => "handle",
            "power-sphere" => "sphere",
            "pinch" => "block",
            "precision-disc" => "disc",
            _ => return None,
        };
        Self::named(name)
    }

    /// The object.
    ///
    /// # Errors
    /// Never: a test reads every scene.
    pub fn object(&self) -> Result<Object, RobotError> {
        Object::parse(self.name, self.text)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn every_scene_holds_an_object_that_stands_on_its_table() {
        for scene in &SCENES {
            let object = scene.object().unwrap();
            let down = object.pose.inverse_transform_vector(&-Vector3::z());
            let lowest = object.pose.translation.z - object.shape.reach(&down);
            assert!(object.table == Some(0.0) && lowest.abs() < 1e-6, "{}: {lowest}", scene.name);
            assert_eq!(object.name, scene.name);
        }
    }
}
