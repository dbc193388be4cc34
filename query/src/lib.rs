//! The program `grasp-query`: recognition ([`grasp_recognise`]) with what people and programs ask
//! of it.
//!
//! [`grasp_answer`] writes the answer as text or JSON Lines and draws how it came about, and
//! [`evaluate`] scores labelled pictures, of which [`experiment`] makes the tables and drawings of
//! Section VII, and [`quiz`] asks a person the same. [`grasp_robot`] makes a strategy for a robot
//! hand of the answer (Section VI). [`live`] gives the frames of cameras and videos. [`search`]
//! takes raw descriptors instead of pictures. [`cli`] puts them behind the program `grasp-query`.

pub mod cli;
pub mod evaluate;
pub mod experiment;
pub mod live;
#[cfg(feature = "serve")]
pub mod quiz;
pub mod search;
