//! A posed hand, and what it is dressed in: an arm and a thing.

use std::sync::Arc;

use nalgebra::{UnitQuaternion, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::marks::{Mark, marks};
use super::randomised::Randomised;
use super::shading::smoothed;
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
        let arm = arm(&self.shape, &self.cut, ARM_LENGTH, width);
        let wrist = if randomised.arms { Wrist::random(&mut rng) } else { Wrist::STRAIGHT };
        let mut scene = CameraScene {
            hand_vertices: self.hand.vertices.len(),
            vertices: Vec::new(),
            places: Vec::new(),
            marks: self.marks.clone(),
            normals: Vec::new(),
            triangles: Vec::new(),
            is_sleeved,
            randomised,
            world_from_hand: self.world_from_hand,
            hand_length: self.hand_length(),
        };
        scene.add(&self.hand, HAND);
        scene.add(&smoothed(&arm), ARM);
        scene.bend(&wrist);
        if is_held {
            let parts = match randomised.things {
                true => dress(&self.object, self.largest, &mut rng),
                false => vec![self.object.mesh()],
            };
            for (part, mesh) in parts.iter().enumerate() {
                scene.add(&smoothed(mesh), FIRST_OBJECT.saturating_add(part as u8));
            }
        }
        scene
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

/// A posed hand with its arm and what it holds.
#[derive(Debug, Clone)]
pub struct CameraScene {
    pub(super) vertices: Vec<Vector3<f32>>,
    /// The same while the wrist was straight.
    pub(super) places: Vec<Vector3<f32>>,
    /// What the skin has at each vertex of the hand.
    pub(super) marks: Vec<Mark>,
    /// One unit normal a vertex.
    pub(super) normals: Vec<Vector3<f32>>,
    /// Corners, and the part that they are of.
    pub(super) triangles: Vec<([u32; 3], u8)>,
    /// Vertices before these are the hand's with what it has of a forearm.
    pub(super) hand_vertices: usize,
    /// Whether the arm that goes on behind the hand's own forearm is in a sleeve.
    pub(super) is_sleeved: bool,
    pub(super) randomised: Randomised,
    pub(super) world_from_hand: UnitQuaternion<f64>,
    pub(super) hand_length: f64,
}

impl CameraScene {
    /// Bends what there is, hand and arm.
    fn bend(&mut self, wrist: &Wrist) {
        for (vertex, normal) in self.vertices.iter_mut().zip(&mut self.normals) {
            wrist.bend(vertex, normal);
        }
    }

    fn add(&mut self, mesh: &Mesh, part: u8) {
        let offset = self.vertices.len() as u32;
        self.vertices.extend(&mesh.vertices);
        self.places.extend(&mesh.vertices);
        self.normals.extend(&mesh.normals);
        self.triangles.extend(mesh.triangles.iter().map(|corners| (corners.map(|c| c + offset), part)));
    }
}
