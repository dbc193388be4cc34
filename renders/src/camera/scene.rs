//! A posed hand, and what it is dressed in: an arm and a thing.

use std::sync::Arc;

use nalgebra::{UnitQuaternion, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::company::Company;
use super::marks::{Mark, marks};
use super::randomised::Randomised;
use super::shading::smoothed;
use super::surface_mesh::SurfaceMesh;
use super::things::dress;
use super::wrist::Wrist;
use crate::grasp::PlacedObject;
use crate::hand::HandShape;
use crate::mesh::Mesh;
use crate::random::{between, unit};
use crate::scene::{JointPlaces, Pieces, SceneError, SceneSpec, arm};
use crate::view::world_from_hand;

/// Length of the arm that goes on behind the hand's own forearm, in metres: out of the picture.
const ARM_LENGTH: f64 = 0.45;
/// How much wider than the wrist it begins: bare, or in a sleeve from tight to wide.
const BARE: f64 = 1.04;
const SLEEVE: [f64; 2] = [1.06, 1.6];
/// How often it is in a sleeve.
const SLEEVED: f64 = 0.45;
/// Numbers of the parts.
const HAND: u8 = 1;
const ARM: u8 = 2;
pub(super) const FIRST_OBJECT: u8 = 3;
/// Numbers from here on are of what is not the hand's own.
pub(super) const FIRST_OF_COMPANY: u8 = 64;

/// A posed hand and the plain body that it closes on, meshed once: it can be dressed in many ways.
#[derive(Debug, Clone)]
pub struct PosedHand {
    shape: Arc<HandShape>,
    hand: Mesh,
    marks: Vec<Mark>,
    object: PlacedObject,
    /// The largest radius of the bodies that the grasp closes on, in metres.
    largest: f64,
    /// The middle of the place where the hand is cut.
    cut: Vector3<f64>,
    world_from_hand: UnitQuaternion<f64>,
    joints: JointPlaces,
}

impl PosedHand {
    /// Poses and meshes the hand of a scene.
    ///
    /// # Errors
    /// As [`SceneSpec::build`].
    pub fn build(spec: &SceneSpec) -> Result<Self, SceneError> {
        spec.look.check()?;
        let pieces = spec.pieces();
        let joints = pieces.joints();
        let Pieces { hand, object, cut, chains } = pieces;
        let [_, largest] = spec.grasp.object.radius;
        Ok(Self {
            shape: Arc::clone(&spec.hand_shape),
            marks: marks(&hand, &chains),
            hand,
            object,
            largest,
            cut,
            world_from_hand: world_from_hand(&spec.grasp.up),
            joints,
        })
    }

    /// The hand on an arm, its wrist bent, and a thing that people hold in place of the plain body,
    /// all by `seed`; empty hands where `is_held` is false. Arm and thing, and later the pictures
    /// of the scene, vary as far as `randomised` says.
    pub fn dressed(&self, is_held: bool, randomised: Randomised, seed: u64) -> CameraScene {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let is_sleeved = unit(&mut rng) < SLEEVED && randomised.arms;
        let width = if is_sleeved { between(&mut rng, SLEEVE) } else { BARE };
        let wrist = if randomised.arms { Wrist::random(&mut rng) } else { Wrist::STRAIGHT };
        let mut own = self.with_arm(width, &wrist, [HAND, ARM]);
        let things_from = own.vertices.len();
        if is_held {
            let parts = match randomised.things {
                true => self.things(&mut rng),
                false => vec![smoothed(&self.object.mesh())],
            };
            for (part, mesh) in parts.iter().enumerate() {
                own.add(mesh, FIRST_OBJECT.saturating_add(part as u8));
            }
        }
        CameraScene {
            own,
            hand_vertices: self.hand.vertices.len(),
            things_from,
            company: SurfaceMesh::default(),
            sleeve: is_sleeved.then_some(width),
            randomised,
            world_from_hand: self.world_from_hand,
            hand_length: self.hand_length(),
        }
    }

    /// The hand on an arm so much wider than its wrist, which is bent; with the numbers of both.
    pub(super) fn with_arm(&self, width: f64, wrist: &Wrist, [hand_part, arm_part]: [u8; 2]) -> SurfaceMesh {
        let mut out = SurfaceMesh::default();
        out.add_hand(&self.hand, &self.marks, hand_part);
        out.add(&smoothed(&arm(&self.shape, &self.cut, ARM_LENGTH, width)), arm_part);
        out.bend(wrist);
        out
    }

    /// The parts of a thing that people hold so.
    pub(super) fn things(&self, rng: &mut ChaCha8Rng) -> Vec<Mesh> {
        dress(&self.object, self.largest, rng).iter().map(smoothed).collect()
    }

    /// The middle of the plain body that the hand closes on, in the hand's frame.
    pub(super) fn holds_at(&self) -> Vector3<f64> {
        self.object.centre
    }

    /// Where the hand's joints are.
    pub fn joints(&self) -> &JointPlaces {
        &self.joints
    }

    /// Length of the hand in metres.
    pub fn hand_length(&self) -> f64 {
        self.shape.length()
    }
}

/// A posed hand with its arm and what it holds, and what is about it.
#[derive(Debug, Clone)]
pub struct CameraScene {
    /// The hand, its arm and the thing, in the hand's frame.
    pub(super) own: SurfaceMesh,
    /// Its vertices before these are the hand's with what it has of a forearm, and from these on
    /// the thing's.
    pub(super) hand_vertices: usize,
    pub(super) things_from: usize,
    /// What else there is, in the same frame.
    pub(super) company: SurfaceMesh,
    /// How much wider than the wrist the sleeve is on the arm that goes on behind the hand's own
    /// forearm, if it is in one.
    sleeve: Option<f64>,
    pub(super) randomised: Randomised,
    pub(super) world_from_hand: UnitQuaternion<f64>,
    pub(super) hand_length: f64,
}

impl CameraScene {
    /// The same with what may be about a hand, by `seed`: often nothing, now and then `second`, the
    /// person's other hand, and things that stand and lie about.
    pub fn in_company(mut self, second: Option<&PosedHand>, seed: u64) -> Self {
        if self.randomised.company {
            self.company = Company::random(&self, second, &mut ChaCha8Rng::seed_from_u64(seed));
        }
        self
    }

    /// How much wider than the wrist an arm of this person is.
    pub(super) fn arm_width(&self) -> f64 {
        self.sleeve.unwrap_or(BARE)
    }

    /// Whether the arm that goes on behind the hand's own forearm is in a sleeve.
    pub(super) fn is_sleeved(&self) -> bool {
        self.sleeve.is_some()
    }
}
