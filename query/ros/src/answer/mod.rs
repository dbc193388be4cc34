//! What is published of a recognised hand: `detection`, `pose`, `marker` and `grasp` are each a
//! topic's messages. All carry the stamp of the picture, and all but the grasp its frame.

pub(crate) mod detection;
pub(crate) mod grasp;
pub(crate) mod marker;
mod place;

use grasp_recognise::{Recognition, Side};
use nalgebra::{Quaternion, UnitQuaternion};

use crate::messages::geometry::{self, Pose, PoseStamped};
use crate::messages::standard::Header;
use crate::view::View;
pub(crate) use place::Original;
use place::Rectangle;

/// A hand whose grasp is known.
#[derive(Clone, Debug)]
pub(crate) struct Hand {
    /// The picture's.
    pub(crate) header: Header,
    pub(crate) side: Side,
    /// The classes' names with their probabilities, most probable first; at least one.
    pub(crate) classes: Vec<(String, f64)>,
    /// Where it is in the picture.
    pub(crate) rectangle: Rectangle,
    /// `camera_from_hand`.
    pub(crate) rotation: UnitQuaternion<f64>,
    /// The root mean square of the angles between the neighbours' rotations and that, in degrees.
    pub(crate) spread_deg: f64,
    /// Its place in the camera's optical frame, in metres.
    pub(crate) position: [f64; 3],
}

impl Hand {
    /// What was recognised in a picture; `None` where the hand is unknown. It is put `depth` metres
    /// in front of the camera, on the ray of the middle of what is seen of it, or on the optical
    /// axis where the camera is not known.
    pub(crate) fn new(
        found: &Recognition,
        header: Header,
        original: Original,
        view: Option<&View>,
        depth: f64,
    ) -> Option<Self> {
        let vote = &found.best.vote;
        let classes: Vec<(String, f64)> =
            vote.classes.iter().map(|class| (class.name.clone(), class.probability)).collect();
        if found.doubt.is_some() || classes.is_empty() {
            return None;
        }
        let rectangle = Rectangle::of(&found.prepared.mask, original)?;
        Some(Self {
            header,
            side: found.best.side,
            classes,
            position: view.map_or([0.0, 0.0, depth], |view| view.point(rectangle.centre, depth)),
            rectangle,
            rotation: vote.orientation.rotation,
            spread_deg: vote.orientation.spread_deg,
        })
    }

    /// The grasp, and how probable it is.
    pub(crate) fn grasp(&self) -> (&str, f64) {
        self.classes.first().map_or(("", 0.0), |(name, probability)| (name, *probability))
    }

    /// The pose of the hand in the camera's optical frame.
    pub(crate) fn pose(&self) -> Pose {
        let [x, y, z] = self.position;
        Pose { position: geometry::Point { x, y, z }, orientation: quaternion(&self.rotation) }
    }

    /// The same as a message.
    pub(crate) fn pose_stamped(&self) -> PoseStamped {
        PoseStamped { header: self.header.clone(), pose: self.pose() }
    }
}

/// A rotation as a message.
fn quaternion(rotation: &UnitQuaternion<f64>) -> geometry::Quaternion {
    let [x, y, z, w] = grasp_recognise::orientation::xyzw(rotation);
    geometry::Quaternion { x, y, z, w }
}

/// A message as a rotation; `None` where it is none.
fn rotation(quaternion: &geometry::Quaternion) -> Option<UnitQuaternion<f64>> {
    let geometry::Quaternion { x, y, z, w } = *quaternion;
    let found = Quaternion::new(w, x, y, z);
    // Rounded by whoever measured it, but a rotation.
    ((found.norm() - 1.0).abs() < 0.01).then(|| UnitQuaternion::new_normalize(found))
}

#[cfg(test)]
mod tests;
