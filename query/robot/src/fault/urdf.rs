//! What can be wrong with a gripper's URDF and the file beside it.

use thiserror::Error;

/// What is wrong with a URDF, or with what stands beside it, and what would be right.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum UrdfFault {
    /// More bytes than any gripper's has.
    #[error("it has more than {most} bytes")]
    TooLong {
        /// The most.
        most: usize,
    },
    /// It is not a URDF yet.
    #[error("it holds xacro: expand it first (xacro FILE.xacro > FILE.urdf)")]
    Xacro,
    /// Elements in elements in elements.
    #[error("its elements lie more than {most} deep in one another")]
    TooDeep {
        /// The most.
        most: usize,
    },
    /// More elements than any hand's URDF has.
    #[error("it has more than {most} elements")]
    TooManyElements {
        /// The most.
        most: usize,
    },
    /// Namespaces that are many, long, or none.
    #[error(
        "its XML namespaces (xmlns, and attributes with a prefix) are more than a URDF needs, which is none: take them out"
    )]
    Namespaces,
    /// Text that is no markup.
    #[error("it holds <![CDATA[, where a URDF has nothing to say: take it out")]
    CharacterData,
    /// It is no XML, or no URDF: what the parser says.
    #[error("{0}")]
    Parser(String),
    /// More joints or links than any hand has.
    #[error("it has more than {most} joints or links")]
    TooMany {
        /// The most.
        most: usize,
    },
    /// A link with two parents.
    #[error("two joints carry the link `{0}`")]
    CarriedTwice(String),
    /// A circle of links.
    #[error("no link carries all others")]
    NoRoot,
    /// Two trees.
    #[error("both `{one}` and `{other}` are carried by no joint: one link must carry all others")]
    TwoRoots {
        /// A root.
        one: String,
        /// Another one.
        other: String,
    },
    /// A joint that follows what is not there.
    #[error("the joint `{joint}` follows `{leader}`, which is not there")]
    NoLeader {
        /// The joint.
        joint: String,
        /// Whom it follows.
        leader: String,
    },
    /// A joint that follows a follower.
    #[error("the joint `{joint}` follows `{leader}`, which follows another one: let both follow that one")]
    LeaderFollows {
        /// The joint.
        joint: String,
        /// Whom it follows.
        leader: String,
    },
    /// Two links on different branches.
    #[error("`{from}` does not carry `{to}`")]
    Apart {
        /// The link that should be nearer to the root.
        from: String,
        /// The link that it should carry.
        to: String,
    },
    /// A link that the URDF does not have.
    #[error("the URDF has no link `{link}`: its links are {known}")]
    NoLink {
        /// The link.
        link: String,
        /// Those that there are.
        known: String,
    },
    /// Links that carry each other.
    #[error("the links above `{0}` carry each other in a circle")]
    Circle(String),
    /// A joint that floats, or moves in a plane.
    #[error(
        "the joint `{0}` is of a kind that no finger has: it must be revolute, prismatic, continuous or fixed"
    )]
    Kind(String),
    /// A joint without limits.
    #[error(
        "the joint `{joint}` has the limits {low} and {high}: its <limit> must have lower and upper, the lower one first, and a finger turns by at most {most_turn:.2} rad and slides by at most {most_slide} m"
    )]
    Limits {
        /// The joint.
        joint: String,
        /// In radians, or metres where it slides.
        low: f64,
        /// See `low`.
        high: f64,
        /// How far from 0 a turning joint's may be, in radians.
        most_turn: f64,
        /// How far from 0 a sliding joint's may be, in metres.
        most_slide: f64,
    },
    /// No tips.
    #[error("tips = []: name the links at the fingers' ends")]
    NoTips,
    /// More tips than any hand has.
    #[error("{count} tips, where a hand has at most {most}: name the last link of each finger")]
    TooManyTips {
        /// How many.
        count: usize,
        /// The most.
        most: usize,
    },
    /// Nothing says how hard the fingers press.
    #[error("say by `max_contact_force`, in newtons, what the fingers may press with")]
    NoForce,
    /// Nothing moves.
    #[error("no joint moves between `{wrist}` and the tips {tips}: name the links at the fingers' ends")]
    NothingMoves {
        /// The wrist's link.
        wrist: String,
        /// The tips' links.
        tips: String,
    },
    /// More than one joint moves by itself, and nothing says how the hand closes.
    #[error(
        "{count} joints move by themselves ({joints}): say by [map] and [grasp.NAME] how they open and close, as in barrett.toml"
    )]
    NoGrasp {
        /// How many.
        count: usize,
        /// Their names.
        joints: String,
    },
    /// A palm whose directions are one.
    #[error("palm: approach {approach:?} and thumb {thumb:?} must be two different directions")]
    Palm {
        /// The direction in which the hand goes to the object.
        approach: [f64; 3],
        /// The direction across what is grasped.
        thumb: [f64; 3],
    },
    /// Tips that do not close against each other.
    #[error(
        "the tips open from {:.0} to {:.0} mm along palm.thumb by `{joint}`: name the links that close against each other in `tips`, the direction across them in palm.thumb, and in `pad` how far a tip's surface is from its link's frame",
        1e3 * shut, 1e3 * widest
    )]
    Opening {
        /// The joint.
        joint: String,
        /// The least opening, in metres.
        shut: f64,
        /// The most, in metres.
        widest: f64,
    },
}
