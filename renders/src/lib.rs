//! A hand shape, a grasp, an object and a view become a picture.
//!
//! A [`HandShape`] holds the measures of one person's hand. A [`Grasp`] says, as data, how a hand
//! opens and closes and on what. [`RenderPlan`] lists which renders to make; each [`SceneSpec`] of
//! it is posed (the fingers close by themselves until they touch the object), meshed once, and then
//! seen from many views by a small z-buffer rasteriser. [`render_set`] writes and reads folders of
//! renders.
//!
//! ```
//! use grasp_renders::{Preset, RenderPlan};
//!
//! let plan = RenderPlan::preset(Preset::Paper);
//! let scene = plan.scenes()[0].build()?;
//! let render = scene.render(&plan.views(&plan.scenes()[0])[450]);
//! assert_eq!(render.grey.len(), 48 * 48);
//! assert!(render.grey.iter().any(|&grey| grey > 0));
//! # Ok::<(), grasp_renders::SceneError>(())
//! ```
//!
//! The same parameters give the same pixels on every machine: arithmetic is IEEE 754 in a fixed
//! order, elementary functions are `libm`'s, and keys and seeds are hashes of canonical bytes
//! ([`grasp_canonical`]).
//!
//! Frames, for all parts of the project: `hand` has its origin at the wrist's centre, x toward the
//! middle knuckle, z out of the back of the hand, y toward the thumb; `camera` is an optical frame
//! with z forward, x right, y down; `world` has z up. Metres; degrees only where a name says so.

mod camera;
mod grasp;
mod hand;
mod hand_model;
mod keys;
mod mesh;
mod plan;
pub mod random;
mod raster;
mod scene;
mod variation;
mod view;

pub mod render_set;

pub use camera::{CameraScene, Framing, Layers, Part, Picture, PosedHand, Randomised};
pub use grasp::{
    Example, Grasp, GraspFault, GraspSet, GraspSetError, Object, ObjectKind, ObjectRange, PlacedObject,
    Placement, PoseGroup, RecordedPose, Stage, StagePose, UnknownStage, alike_grasps, presented_grasps,
};
pub use hand::{
    Digit, FingerMeasures, HandPose, HandShape, HandShapeError, JOINT_NAMES, Joints, Skeleton, joint_limits,
};
pub use hand_model::{HandModel, HandModelError, ModelFault, NotAHand, Unsupported};
pub use plan::{Preset, RenderPlan, UnknownPreset};
pub use raster::HAND_FLOOR;
pub use scene::{JointPlaces, Look, RENDERER_VERSION, Render, Scene, SceneError, SceneSpec};
pub use variation::Variation;
pub use view::{View, ViewGrid, Views, world_from_hand};
