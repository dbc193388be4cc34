//! One hand shape in one grasp at one stage with one object: built once, seen from many sides.

use std::sync::Arc;

use grasp_canonical::Encoder;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::grasp::{Example, Grasp, Object, PlacedObject, Stage, grip, hold};
use crate::hand::{Chain, HandPose, HandShape, HandSurface, Skeleton};
use crate::hand_model::HandModel;
use crate::mesh::{Mesh, surface_nets};
use crate::raster::{self, Drawing, Light};
use crate::view::{View, world_from_hand};

/// Changes whenever the same parameters give other pixels than before.
pub const RENDERER_VERSION: u32 = 4;

/// How a picture is taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Side of the square picture in pixels.
    pub side: usize,
    /// Length of the forearm behind the wrist in metres; 0 cuts the hand at the wrist.
    pub forearm: f64,
    /// Length of the black arm in metres that goes on where the hand is cut and hides what lies
    /// behind it, as a sleeve does once a picture is segmented; 0 leaves it out.
    pub arm: f64,
    /// How wide that arm is where it begins, as a share of the wrist: 1 is a bare wrist, 1.5 a wide
    /// sleeve.
    pub sleeve: f64,
    /// Distance of the camera from the hand's centre, in hand lengths.
    pub distance: f64,
    /// How far that distance may vary from view to view, as a share of it: 0 to 0.5.
    pub distance_variation: f64,
    /// How far the light may move from view to view: 0 (fixed) to 1 (anywhere on the camera's
    /// side).
    pub light_variation: f64,
    /// Side of the mesh's cells in metres.
    pub cell: f64,
}

impl Default for Look {
    fn default() -> Look {
        Look {
            side: 48,
            forearm: 0.0,
            arm: 0.25,
            sleeve: 1.2,
            distance: 4.0,
            distance_variation: 0.0,
            light_variation: 0.0,
            cell: 0.0035,
        }
    }
}

/// What a scene is made of. Cheap to copy; [`SceneSpec::build`] does the work.
#[derive(Debug, Clone)]
pub struct SceneSpec {
    /// Whose hand.
    pub hand_shape: Arc<HandShape>,
    /// The model whose measures these are, and whose skin is drawn.
    pub hand_model: Option<Arc<HandModel>>,
    /// In which grasp.
    pub grasp: Arc<Grasp>,
    /// How far closed.
    pub stage: Stage,
    /// Holding what.
    pub object: Object,
    /// Posed like this, and not by closing the fingers on the object.
    pub example: Option<Example>,
    /// Posed like this, with the object fitted into the hand. An example takes precedence.
    pub held: Option<HandPose>,
    /// Seen how.
    pub look: Look,
    /// Seed of the variations of light and distance.
    pub seed: u64,
}

/// Why a scene cannot be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// A parameter of the look that cannot be.
    #[error("{what} is {value}: it must lie in {range}")]
    Look {
        /// The parameter.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What would be right.
        range: &'static str,
    },
}

/// A posed and meshed hand with its object.
#[derive(Debug, Clone)]
pub struct Scene {
    drawing: Drawing,
    centre: Vector3<f64>,
    world_from_hand: UnitQuaternion<f64>,
    hand_length: f64,
    joints: JointPlaces,
    look: Look,
    noise: u64,
}

/// The centres of a posed hand's joints in metres in the frame of the hand: of the thumb and each
/// finger the root, the two joints and the tip.
pub type JointPlaces = [[Vector3<f32>; 4]; 5];

/// What a scene is put together from, in the frame of the hand.
pub(crate) struct Pieces {
    /// The posed hand's skin.
    pub(crate) hand: Mesh,
    pub(crate) object: PlacedObject,
    /// The middle of the place where the hand or its forearm is cut.
    pub(crate) cut: Vector3<f64>,
    /// The posed digits.
    pub(crate) chains: [Chain; 5],
}

impl Pieces {
    /// Where the joints are.
    pub(crate) fn joints(&self) -> JointPlaces {
        self.chains.map(|chain| chain.points.map(|point| point.cast()))
    }
}

/// One synthetic picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Render {
    /// Width and height in pixels.
    pub side: usize,
    /// Row by row; 0 outside the hand, at least [`crate::HAND_FLOOR`] on it.
    pub grey: Vec<u8>,
    /// The rotation from the hand's frame into the camera's.
    pub camera_from_hand: UnitQuaternion<f64>,
    /// From where.
    pub view: View,
}

impl SceneSpec {
    /// A hash of all that the scene's pixels follow from, the renderer's version included: the key
    /// by which pictures are known again, and the seed of their variations.
    pub fn params_hash(&self) -> u64 {
        Encoder::new().u32(RENDERER_VERSION).value(self).hash()
    }

    /// Poses the hand, closes it on the object and meshes it.
    ///
    /// # Errors
    ///
    /// [`SceneError::Look`] when a parameter of the look is out of its range.
    pub fn build(&self) -> Result<Scene, SceneError> {
        self.look.check()?;
        let pieces = self.pieces();
        let joints = pieces.joints();
        let Pieces { hand, object, cut, .. } = pieces;
        let sleeve = arm(&self.hand_shape, &cut, self.look.arm, self.look.sleeve);
        let black = [object.mesh(), sleeve];
        let (drawing, centre) = assemble(hand, &black, cut.x);
        Ok(Scene {
            drawing,
            centre,
            world_from_hand: world_from_hand(&self.grasp.up),
            hand_length: self.hand_shape.length(),
            joints,
            look: self.look.clone(),
            noise: self.params_hash(),
        })
    }

    /// The posed hand and what it holds.
    pub(crate) fn pieces(&self) -> Pieces {
        let skeleton = match &self.hand_model {
            None => Skeleton::new(&self.hand_shape),
            Some(model) => model.skeleton(),
        };
        let (pose, object) = self.pose(&skeleton);
        let (hand, cut) = self.hand(&skeleton, &pose);
        Pieces { hand, object, cut, chains: skeleton.chains(&pose) }
    }

    /// The posed hand, and the middle of the place where it is cut.
    fn hand(&self, skeleton: &Skeleton, pose: &HandPose) -> (Mesh, Vector3<f64>) {
        if let Some(model) = &self.hand_model {
            let cut = model.cut(self.look.forearm);
            return (model.posed(pose, cut.x), cut);
        }
        let surface = HandSurface::new(skeleton, pose, self.look.forearm);
        let (low, high) = surface.bounds();
        // A margin of two cells: the surface must not touch the grid's border.
        let margin = Vector3::repeat(2.0 * self.look.cell);
        let hand = surface_nets(low - margin, high + margin, self.look.cell, &surface);
        (hand, Vector3::new(surface.cut_x(), 0.0, 0.0))
    }

    /// The hand's joint angles and the object's place at this stage.
    fn pose(&self, skeleton: &Skeleton) -> (HandPose, PlacedObject) {
        if let Some(example) = &self.example {
            return (example.pose, example.object);
        }
        let held = match &self.held {
            None => grip(skeleton, &self.grasp, self.object),
            Some(pose) => hold(skeleton, &self.grasp, self.object, pose),
        };
        let stage = self.grasp.stage(self.stage);
        let mut object = held.object;
        object.centre += held.away * stage.away;
        (self.grasp.relaxed.toward(&held.pose, stage.closure), object)
    }
}

impl Look {
    pub(crate) fn check(&self) -> Result<(), SceneError> {
        let side = self.side as f64;
        let rules = [
            ("the picture's side in pixels", side, 8.0, 1024.0, "8 to 1024"),
            ("the sleeve's width in wrists", self.sleeve, 0.5, 3.0, "0.5 to 3"),
            ("the forearm's length in metres", self.forearm, 0.0, 0.4, "0 to 0.4"),
            ("the black arm's length in metres", self.arm, 0.0, 1.0, "0 to 1"),
            ("the camera's distance in hand lengths", self.distance, 1.5, 1000.0, "1.5 to 1000"),
            ("the variation of distance", self.distance_variation, 0.0, 0.5, "0 to 0.5"),
            ("the variation of light", self.light_variation, 0.0, 1.0, "0 to 1"),
            ("the mesh's cell in metres", self.cell, 0.0005, 0.01, "0.0005 to 0.01"),
        ];
        for (what, value, low, high, range) in rules {
            if !(low..=high).contains(&value) {
                return Err(SceneError::Look { what, value, range });
            }
        }
        Ok(())
    }
}

/// Puts hand and black things into one list, the hand first, around the hand's centre (given back).
fn assemble(hand: Mesh, black: &[Mesh], cut_x: f64) -> (Drawing, Vector3<f64>) {
    let (mut low, mut high) = (Vector3::repeat(f32::MAX), Vector3::repeat(f32::MIN));
    for v in &hand.vertices {
        low = low.inf(v);
        high = high.sup(v);
    }
    let centre = (low + high) * 0.5;
    // The cut through the wrist is black: where the arm goes on there is no hand.
    let rim = cut_x as f32 + 5e-4;
    let on_cut = |t: &[u32; 3]| t.iter().all(|&v| hand.vertices[v as usize].x < rim);
    let (cap, skin): (Vec<[u32; 3]>, Vec<[u32; 3]>) = hand.triangles.iter().partition(|t| on_cut(t));
    let mut drawing = Drawing {
        hand_vertices: hand.vertices.len(),
        hand_triangles: skin.len(),
        vertices: hand.vertices.iter().map(|v| v - centre).collect(),
        normals: hand.normals,
        triangles: skin.into_iter().chain(cap).collect(),
    };
    for body in black {
        let offset = drawing.vertices.len() as u32;
        drawing.vertices.extend(body.vertices.iter().map(|v| v - centre));
        drawing.normals.extend(&body.normals);
        drawing.triangles.extend(body.triangles.iter().map(|t| t.map(|v| v + offset)));
    }
    (drawing, centre.cast())
}

/// The arm in its sleeve, backwards from the middle of the cut: an elliptic cone that begins
/// `sleeve` times as wide as the wrist.
pub(crate) fn arm(shape: &HandShape, cut: &Vector3<f64>, length: f64, sleeve: f64) -> Mesh {
    const SIDES: u32 = 32;
    let mut mesh = Mesh::default();
    if length == 0.0 {
        return mesh;
    }
    // (distance behind the cut, widening), the ends closed by a ring of no size.
    for (back, wide) in [(0.0, 0.0), (0.0, sleeve), (length, sleeve + length), (length, 0.0)] {
        for side in 0..SIDES {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(side) / f64::from(SIDES));
            let y = 0.5 * shape.wrist_breadth * wide * cos;
            let z = 0.6 * shape.wrist_thickness * wide * sin;
            mesh.vertices.push((cut + Vector3::new(-back, y, z)).cast());
            mesh.normals.push(Vector3::x());
        }
    }
    for ring in 0..3 {
        for side in 0..SIDES {
            let next = (side + 1) % SIDES;
            let [a, b] = [ring * SIDES + side, ring * SIDES + next];
            let [c, d] = [a + SIDES, b + SIDES];
            mesh.triangles.push([a, d, b]);
            mesh.triangles.push([a, c, d]);
        }
    }
    mesh
}

impl Scene {
    /// Takes a picture.
    pub fn render(&self, view: &View) -> Render {
        let camera_from_hand = view.camera_from_world() * self.world_from_hand;
        let turn: Matrix3<f32> = camera_from_hand.to_rotation_matrix().matrix().cast();
        let (light, distance) = self.light_and_distance(view);
        let metres = distance * self.hand_length;
        let grey = raster::draw(&self.drawing, &turn, metres as f32, &light, self.look.side);
        Render { side: self.look.side, grey, camera_from_hand, view: *view }
    }

    /// Where the hand's joints are.
    pub fn joints(&self) -> &JointPlaces {
        &self.joints
    }

    /// Length of the hand in metres.
    pub fn hand_length(&self) -> f64 {
        self.hand_length
    }

    /// The point that the camera looks at, in the hand frame: the middle of the hand's box.
    pub fn centre(&self) -> Vector3<f64> {
        self.centre
    }

    /// Light and distance (in hand lengths) of a view; they follow from the parameters and the view
    /// alone, not from the order in which views are rendered.
    fn light_and_distance(&self, view: &View) -> (Light, f64) {
        // From the upper left, from behind the camera.
        let mut toward = Vector3::new(-0.30, -0.55, -0.78);
        let mut ambient = 0.40;
        let mut distance = self.look.distance;
        if self.look.light_variation > 0.0 || self.look.distance_variation > 0.0 {
            let mut rng = ChaCha8Rng::seed_from_u64(self.noise ^ Encoder::new().value(view).hash());
            let mut either = || (rng.next_u64() >> 11) as f64 / (1u64 << 52) as f64 - 1.0;
            distance *= 1.0 + self.look.distance_variation * either();
            let v = self.look.light_variation;
            toward += Vector3::new(either(), either(), 0.3 * either()) * v;
            ambient += 0.2 * v * either();
        }
        let light = Light { toward: toward.normalize().cast(), ambient: ambient as f32 };
        (light, distance)
    }

    /// The hand without what it holds: places in metres in the frame of the hand, relative to
    /// [`Self::centre`], and the triangles between them, outside counter-clockwise.
    pub fn hand(&self) -> (&[Vector3<f32>], &[[u32; 3]]) {
        let Drawing { vertices, triangles, hand_vertices, .. } = &self.drawing;
        // The cut through the wrist is drawn black, but belongs to the hand.
        let hand = *hand_vertices as u32;
        let end = triangles.partition_point(|corners| corners.iter().all(|&corner| corner < hand));
        (&vertices[..*hand_vertices], &triangles[..end])
    }

    /// What hides the hand, the object that it holds and the arm where the look has one: as
    /// [`Self::hand`].
    pub fn occluders(&self) -> (&[Vector3<f32>], Vec<[u32; 3]>) {
        let Drawing { vertices, triangles, hand_vertices, .. } = &self.drawing;
        let first = *hand_vertices as u32;
        let theirs = triangles.iter().filter(|corners| corners.iter().all(|&corner| corner >= first));
        (&vertices[*hand_vertices..], theirs.map(|corners| corners.map(|corner| corner - first)).collect())
    }

    /// How many triangles the hand has.
    pub fn triangles(&self) -> usize {
        self.drawing.hand_triangles
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grasp::GraspSet;
    use crate::plan::{Preset, RenderPlan};
    use crate::raster::HAND_FLOOR;
    use crate::view::ViewGrid;

    fn spec(shape: HandShape, grasp: &str, stage: Stage) -> SceneSpec {
        let set = GraspSet::builtin();
        let grasp = set.get(grasp).expect("a grasp").clone();
        SceneSpec {
            hand_shape: Arc::new(shape),
            hand_model: None,
            object: grasp.object.object(0.5),
            example: None,
            held: None,
            grasp: Arc::new(grasp),
            stage,
            look: Look::default(),
            seed: 1,
        }
    }

    #[test]
    fn every_shape_grasp_and_stage_is_whole_and_seen_from_all_sides() {
        let plan = RenderPlan {
            hand_shapes: HandShape::presets(),
            stages: Stage::ALL.to_vec(),
            look: Look { cell: 0.004, ..Look::default() },
            ..RenderPlan::preset(Preset::Paper)
        };
        let grid = ViewGrid { step_deg: 30.0, elevation_deg: [-90.0, 90.0], rolls_deg: vec![0.0] };
        for spec in plan.scenes() {
            let name = format!("{} {} {}", spec.hand_shape.name, spec.grasp.name, spec.stage);
            let skeleton = Skeleton::new(&spec.hand_shape);
            let (pose, _) = spec.pose(&skeleton);
            let surface = HandSurface::new(&skeleton, &pose, 0.0);
            let (low, high) = surface.bounds();
            let mesh = surface_nets(low.add_scalar(-0.008), high.add_scalar(0.008), 0.004, &surface);
            assert!(mesh.is_closed(), "{name} has a hole");
            // A hand has 250 to 600 ml.
            assert!((1.8e-4..8e-4).contains(&mesh.volume()), "{name}: {} m3", mesh.volume());
            let scene = spec.build().expect("a scene");
            for view in grid.views() {
                let seen = scene.render(&view).grey.iter().filter(|g| **g >= HAND_FLOOR).count();
                assert!(seen > 30, "{name} from {view:?}: {seen} pixels");
            }
        }
    }

    #[test]
    fn a_point_of_the_hand_is_seen_where_the_quaternion_says() {
        // The index fingertip of an almost flat hand is the picture's uppermost part when x points
        // up.
        let scene = spec(HandShape::mean(), "pinch", Stage::Reach).build().expect("a scene");
        let view = View { azimuth_deg: 180.0, elevation_deg: 84.0, roll_deg: 0.0 };
        let render = scene.render(&view);
        let forward = render.camera_from_hand * Vector3::x();
        assert!(forward.y < -0.9, "the fingers point up in the picture: {forward:?}");
        let width = |row: usize| render.grey[row * 48..(row + 1) * 48].iter().filter(|g| **g > 0).count();
        let (tips, wrist) = (width(3), width(44));
        assert!(tips > 0 && tips < wrist, "fingertips {tips}, wrist {wrist}");
        // The thumb is on the right: the right hand seen from the back, fingers up, has it on the
        // left.
        assert!((render.camera_from_hand * Vector3::y()).x < -0.9);
    }

    #[test]
    fn the_arm_is_closed_and_right_side_out() {
        let mesh = arm(&HandShape::mean(), &Vector3::new(-0.01, 0.0, 0.0), 0.25, 1.2);
        assert!(mesh.is_closed());
        assert!(mesh.volume() > 3e-4, "{}", mesh.volume());
    }

    #[test]
    fn variations_follow_from_the_seed_alone() {
        let varied = |seed| SceneSpec {
            look: Look { light_variation: 0.5, distance_variation: 0.2, ..Look::default() },
            seed,
            ..spec(HandShape::mean(), "pinch", Stage::Grasp)
        };
        let view = View { azimuth_deg: 30.0, elevation_deg: 30.0, roll_deg: 0.0 };
        let picture = |seed| varied(seed).build().expect("a scene").render(&view).grey;
        assert_eq!(picture(1), picture(1));
        assert_ne!(picture(1), picture(2));
        assert_ne!(varied(1).params_hash(), varied(2).params_hash());
    }

    #[test]
    fn a_look_out_of_range_is_refused() {
        let mut wrong = spec(HandShape::mean(), "pinch", Stage::Grasp);
        wrong.look.distance = 0.2;
        let error = wrong.build().expect_err("too near");
        insta::assert_snapshot!(error, @"the camera's distance in hand lengths is 0.2: it must lie in 1.5 to 1000");
    }
}
