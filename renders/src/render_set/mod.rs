//! Render sets on disk: a folder of PNG files by hand shape and grasp, and one `manifest.csv`.
//!
//! # The manifest
//!
//! A CSV file with a header line, UTF-8, one line a render. Any program can write one (Blender,
//! Poser, a camera rig with known poses); columns may come in any order, and columns not named here
//! are ignored.
//!
//! | column | | meaning |
//! |---|---|---|
//! | `file` | needed | the picture, relative to the manifest's folder, `/` between folders; grey or colour, black outside the hand |
//! | `grasp` | needed | the class: a name of the [`GraspSet`](crate::GraspSet) |
//! | `qx`, `qy`, `qz`, `qw` | needed | `camera_from_hand`: the unit quaternion that turns the hand's axes (x wrist to middle knuckle, z out of the back, y toward the thumb; right hand) into the camera's (z forward, x right, y down) |
//! | `hand_shape` | `unknown` | whose hand |
//! | `hand` | `right` | must be `right`: pictures of left hands, and their rotations, are to be flipped |
//! | `cutkosky` | from the grasp | the class's number; must agree with `grasp` |
//! | `stage` | `grasp` | `reach`, `close` or `grasp` |
//! | `azimuth`, `elevation`, `roll` | 0 | degrees, as in [`View`](crate::View); kept in the index; the roll also tells two pictures of one view apart |
//! | `object` | empty | what the hand holds |
//! | `seed` | 0 | seed of the variations |
//!
//! The second column says what an absent or empty field means.

mod manifest;
mod picture;
mod write;

pub use manifest::{MANIFEST, Manifest, ManifestError, ManifestRow, Problem};
pub use write::{RenderSetError, Summary, render_file, write_set};
