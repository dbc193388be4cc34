//! What can be wrong with a grasp in a file.

use thiserror::Error;

use super::stage::UnknownStage;

/// What is wrong with a grasp, and what would be right.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum GraspFault {
    /// Two grasps have one name, or one of Cutkosky's numbers.
    #[error("its name or its number is taken by another grasp")]
    Taken,
    /// The name has other characters than a folder's name may have here.
    #[error("its name becomes a folder's: use a-z, 0-9 and -")]
    Name,
    /// A stage goes too far.
    #[error("stage {0}: closure must lie in 0..1 and away in 0..0.5 m")]
    Stage(&'static str),
    /// No digit touches the object.
    #[error("touch names no digit")]
    NothingTouches,
    /// A digit cannot do as its neighbour does.
    #[error("follow names fingers after the index that are not in touch")]
    Follow,
    /// A sphere has a length.
    #[error("a sphere has no length")]
    SphereWithLength,
    /// A cylinder or a disc has none.
    #[error("the object's length is missing")]
    NoLength,
    /// A place in the palm is far from it.
    #[error("anchor is given in shares of the palm: -2 to 2")]
    Anchor,
    /// The keys of an object in the palm.
    #[error("place = \"palm\" needs anchor and push and nothing else")]
    Palm,
    /// The keys of an object at the finger tips.
    #[error("place = \"tips\" needs between and nothing else")]
    Tips,
    /// The thumb is opposite to itself, or to nothing.
    #[error("between names the fingers opposite to the thumb")]
    Between,
    /// A range of sizes that is empty or of no object.
    #[error("{key} must be [smallest, largest] in metres, from 0.001 to 0.5; it is [{low}, {high}]")]
    Range {
        /// The key.
        key: &'static str,
        /// What it says.
        low: f64,
        /// See `low`.
        high: f64,
    },
    /// An angle that no joint has.
    #[error("{pose}.{digit}: {joint} is {degrees} degrees, but that joint goes from {low:.0} to {high:.0}")]
    Angle {
        /// Which pose.
        pose: String,
        /// Whose joint.
        digit: &'static str,
        /// Which joint.
        joint: &'static str,
        /// The angle.
        degrees: f64,
        /// The joint's limits in degrees.
        low: f64,
        /// See `low`.
        high: f64,
    },
    /// Three numbers that are all 0, or not finite.
    #[error("{0} has no direction: it needs three numbers that are not all 0")]
    Direction(&'static str),
    /// An example at no stage.
    #[error("example: {0}")]
    ExampleStage(#[from] UnknownStage),
    /// An example's object of a size that none has.
    #[error("example: the object's {what} is {metres}; 0.001 to 0.5 m is supported")]
    ExampleSize {
        /// Radius or length.
        what: &'static str,
        /// What it says.
        metres: f64,
    },
    /// An example's object somewhere else.
    #[error("example: the object's centre lies within half a metre of the wrist")]
    ExampleCentre,
    /// An example's sphere that is turned.
    #[error("example: a sphere has no length and no axis")]
    ExampleSphere,
    /// An example's cylinder or disc that lacks something.
    #[error("example: the object needs radius, length, axis and centre")]
    ExampleObject,
}
