//! Where object, palm and fingers are in the world, and what of that is seen from the side and from
//! above: all that a drawing of a strategy shows.

use nalgebra::{Isometry3, Point3, Translation3, Vector3};
use serde::Serialize;

use super::outline::outline;
use super::placed::{Placed, posture};
use super::pose::Pose;
use super::pose::rounded;
use super::{Object, RobotGrasp, RobotHand, Shape};

/// An approach whose horizontal part is shorter than this comes from above or below.
const VERTICAL: f64 = 0.35;

/// Where everything is when the fingers begin to close. Metres, in the world.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Layout {
    /// The object.
    pub object: LaidObject,
    /// The middle of the palm where the approach begins.
    pub palm_at_start: Pose,
    /// The middle of the palm after the retreat.
    pub palm_lifted: Pose,
    /// Each finger's middle line in the open posture, from the palm to its tip; none for a hand
    /// whose description has no fingers.
    pub fingers: Vec<Vec<[f64; 3]>>,
    /// The height of the table, where there is one.
    pub table: Option<f64>,
    /// The same as flat drawings: from the side, in the plane of the approach, and from above.
    pub views: [View; 2],
    #[serde(skip)]
    palm: Palm,
}

/// The object's shape and where it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct LaidObject {
    /// `box`, `cylinder` (about the z of its pose) or `sphere`.
    pub shape: &'static str,
    /// Extents along the axes of its pose.
    pub size: [f64; 3],
    /// Of its middle.
    pub pose: Pose,
}

/// What is seen along one direction. Coordinates are metres along `right` and `up`, from the
/// world's origin.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct View {
    /// `from the side` or `from above`.
    pub name: &'static str,
    /// The direction in the world that goes right in the drawing, of length 1; the same in both.
    pub right: [f64; 3],
    /// The direction that goes up.
    pub up: [f64; 3],
    /// The object's outline: convex, counter-clockwise.
    pub object: Vec<[f64; 2]>,
    /// The palm's outline where the fingers close.
    pub palm: Vec<[f64; 2]>,
    /// The palm's outline where the approach begins.
    pub palm_at_start: Vec<[f64; 2]>,
    /// Each finger's middle line.
    pub fingers: Vec<Vec<[f64; 2]>>,
    /// The way of the palm's middle to the object: from, to.
    pub approach: [[f64; 2]; 2],
    /// Its way with the object: from, to.
    pub retreat: [[f64; 2]; 2],
    /// The height of the table, in the view from the side.
    pub table: Option<f64>,
}

/// The palm as a cylinder that ends in its surface.
#[derive(Clone, Debug, Default)]
struct Palm {
    /// The middle of its surface.
    surface: Isometry3<f64>,
    /// In the world, from where the palm closes to where its approach begins.
    back: Vector3<f64>,
    radius: f64,
    height: f64,
}

impl Layout {
    pub(super) fn new(
        hand: &RobotHand,
        grasp: &RobotGrasp,
        object: &Object,
        world_from_object: &Isometry3<f64>,
        placed: &Placed,
    ) -> Self {
        let palm = Palm {
            surface: placed.world_from_palm,
            back: -placed.approach * hand.approach.distance,
            radius: hand.palm_radius,
            height: hand.palm_height(),
        };
        let open = posture(&grasp.open, placed.width);
        let in_world =
            |points: &Vec<Point3<f64>>| points.iter().map(|point| palm.surface * point).collect::<Vec<_>>();
        let fingers: Vec<Vec<Point3<f64>>> = hand.fingers(&open).iter().map(in_world).collect();
        let start = Translation3::from(palm.back) * palm.surface;
        let lifted = Translation3::new(0.0, 0.0, hand.retreat.distance) * palm.surface;
        let seen =
            Seen { palm: &palm, fingers: &fingers, shape: object.shape, world_from_object, lifted: &lifted };
        let right = across(placed);
        let (shape, size) = extents(object.shape);
        Self {
            views: [
                seen.from("from the side", right, Vector3::z(), object.table),
                seen.from("from above", right, Vector3::z().cross(&right), None),
            ],
            object: LaidObject { shape, size, pose: Pose::new("world", world_from_object) },
            palm_at_start: Pose::new("world", &start),
            palm_lifted: Pose::new("world", &lifted),
            fingers: fingers
                .iter()
                .map(|points| points.iter().map(|point| point.coords.map(rounded).into()).collect())
                .collect(),
            table: object.table,
            palm,
        }
    }

    /// The middle of the palm's surface where the fingers close.
    pub(super) fn palm(&self) -> Point3<f64> {
        self.palm.surface.translation.vector.into()
    }

    /// The height of the palm's lowest point, in metres: where the fingers close and where the
    /// approach begins.
    pub(super) fn lowest_of_palm(&self) -> [f64; 2] {
        let (shape, pose) = self.palm.solid();
        let down = pose.inverse_transform_vector(&-Vector3::z());
        let lowest = pose.translation.z - shape.reach(&down);
        [lowest, lowest + self.palm.back.z]
    }

    /// The height of the fingers' lowest point, in metres; `None` where no fingers are known.
    pub(super) fn lowest_of_fingers(&self) -> Option<f64> {
        self.fingers.iter().flatten().map(|[_, _, z]| *z).reduce(f64::min)
    }
}

impl Palm {
    fn solid(&self) -> (Shape, Isometry3<f64>) {
        let middle = self.surface * Translation3::new(0.0, 0.0, -0.5 * self.height);
        (Shape::Cylinder { radius: self.radius, height: self.height }, middle)
    }
}

/// The horizontal direction in which the hand comes, or, where it comes from above, in which its
/// fingers close: so that the view from the side shows them from the side.
fn across(placed: &Placed) -> Vector3<f64> {
    let flat = |vector: Vector3<f64>| Vector3::new(vector.x, vector.y, 0.0);
    let along = flat(placed.approach);
    let along = if along.norm() > VERTICAL { along } else { flat(placed.world_from_palm * Vector3::y()) };
    along.try_normalize(1e-9).unwrap_or_else(Vector3::x)
}

fn extents(shape: Shape) -> (&'static str, [f64; 3]) {
    match shape {
        Shape::Box { size } => ("box", size),
        Shape::Cylinder { radius, height } => ("cylinder", [2.0 * radius, 2.0 * radius, height]),
        Shape::Sphere { radius } => ("sphere", [2.0 * radius; 3]),
    }
}

/// All that views show.
struct Seen<'a> {
    palm: &'a Palm,
    fingers: &'a [Vec<Point3<f64>>],
    shape: Shape,
    world_from_object: &'a Isometry3<f64>,
    lifted: &'a Isometry3<f64>,
}

impl Seen<'_> {
    fn from(&self, name: &'static str, right: Vector3<f64>, up: Vector3<f64>, table: Option<f64>) -> View {
        let flat = |point: Vector3<f64>| [rounded(point.dot(&right)), rounded(point.dot(&up))];
        let (palm, at) = self.palm.solid();
        let surface = self.palm.surface.translation.vector;
        View {
            name,
            right: right.map(rounded).into(),
            up: up.map(rounded).into(),
            object: outline(self.shape, self.world_from_object, &right, &up),
            palm: outline(palm, &at, &right, &up),
            palm_at_start: outline(palm, &(Translation3::from(self.palm.back) * at), &right, &up),
            fingers: self
                .fingers
                .iter()
                .map(|points| points.iter().map(|point| flat(point.coords)).collect())
                .collect(),
            approach: [flat(surface + self.palm.back), flat(surface)],
            retreat: [flat(surface), flat(self.lifted.translation.vector)],
            table,
        }
    }
}
