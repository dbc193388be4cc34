//! What can be wrong with a model inside a sound glTF document.

use thiserror::Error;

/// The file contradicts itself or the format.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ModelFault {
    /// Of another version of the container.
    #[error("it is glTF {0}, and glTF 2 is read: export it again")]
    Version(u32),
    /// Shorter than it says.
    #[error("truncated: {expected} bytes expected, {found} found")]
    Truncated {
        /// Bytes that it should have.
        expected: usize,
        /// Bytes that it has.
        found: usize,
    },
    /// It does not begin with its description.
    #[error("its first chunk is not a JSON document")]
    NoDocument,
    /// The document is of another version.
    #[error("its asset version is {0}, and 2.0 is read")]
    AssetVersion(String),
    /// An accessor that is not there.
    #[error("it names accessor {0}, which it does not have")]
    NoAccessor(usize),
    /// An accessor of another type than its use needs.
    #[error("accessor {accessor} holds {found}, not {wanted}")]
    AccessorType {
        /// Its number.
        accessor: usize,
        /// What it holds.
        found: String,
        /// What is needed.
        wanted: String,
    },
    /// An accessor with more rows than any mesh has.
    #[error("accessor {accessor} has {rows} rows; {most} at most")]
    AccessorRows {
        /// Its number.
        accessor: usize,
        /// How many rows it has.
        rows: usize,
        /// The most that are read.
        most: usize,
    },
    /// Numbers of a type that glTF does not know.
    #[error("accessor {accessor} has numbers of the unknown type {kind}")]
    NumberType {
        /// Its number.
        accessor: usize,
        /// glTF's number of the type.
        kind: u32,
    },
    /// An accessor beyond the file's numbers.
    #[error("accessor {0} lies outside the file's numbers")]
    AccessorOutside(usize),
    /// Rows closer together than they are long.
    #[error("the rows of accessor {0} overlap")]
    RowsOverlap(usize),
    /// A node below two others.
    #[error("node {0} has two parents")]
    TwoParents(usize),
    /// A child that is not there.
    #[error("node {0} has a child that is not there")]
    NoChild(usize),
    /// Numbers that are no place, no rotation or no scale.
    #[error("the place, rotation or scale of node {0} is out of range")]
    Pose(usize),
    /// Nodes without a root.
    #[error("some of its nodes go in a circle")]
    Circle,
    /// A mesh or a skin that is not there.
    #[error("a node names a mesh or a skin that is not there")]
    NoMesh,
    /// Too few inverse bind matrices.
    #[error("a skin has more joints than inverse bind matrices")]
    Binds,
    /// A joint that is not there.
    #[error("a skin names node {0}, which is not there")]
    NoJoint(usize),
    /// A mesh without places.
    #[error("a mesh has no POSITION")]
    NoPosition,
    /// A mesh that no joint moves.
    #[error("a mesh has a skin but no JOINTS_0 and WEIGHTS_0")]
    NoWeights,
    /// Corners that no joint moves.
    #[error("a mesh has fewer joints or weights than vertices")]
    FewWeights,
    /// A vertex that cannot be moved as the file says.
    #[error("vertex {0} of a mesh has weights or joints that are out of range")]
    Vertex(usize),
    /// A triangle of vertices that are not there.
    #[error("a triangle names a vertex that is not there")]
    Triangle,
}

/// Something that glTF allows and that is not read here.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Unsupported {
    /// An extension without which the file cannot be understood.
    #[error("it needs the extension {0}: export it without compression and extensions")]
    Extension(String),
    /// Numbers in another file.
    #[error("its numbers lie outside the file ({0}): export it as one .glb")]
    Outside(String),
    /// A sparse accessor.
    #[error("accessor {0} is sparse: export it without sparse accessors")]
    Sparse(usize),
    /// Lines or points.
    #[error("its mesh is not made of triangles: triangulate it")]
    NoTriangles,
    /// More vertices or triangles than are drawn in time.
    #[error("its mesh has more than {most} {what}: reduce it")]
    TooFine {
        /// `vertices`, `triangles`, or `rows of numbers`, counted as often as they are read.
        what: &'static str,
        /// The most that are read.
        most: usize,
    },
}

/// Why a sound model is no human hand.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum NotAHand {
    /// A palm without vertices.
    #[error("its palm and wrist have no skin of their own: bind the mesh to `wrist` there")]
    NoPalm,
    /// Joints that have no rest pose.
    #[error("its wrist and knuckles lie in one place or on one line: the joints need their rest pose")]
    NoRestPose,
    /// A rest pose that a mirror does not change.
    #[error(
        "it is so flat that a right hand cannot be distinguished from a left one: bend the rest pose's thumb and \
         fingers a little toward the palm"
    )]
    Flat,
    /// A palm without width.
    #[error("its wrist and knuckles lie on one line")]
    OnOneLine,
    /// Longer or shorter than any hand.
    #[error(
        "it is {metres:.3} m long from the wrist to the middle fingertip: glTF is in metres, and a hand has {least} to {most} m"
    )]
    Length {
        /// Its length.
        metres: f64,
        /// The least of a hand, in metres.
        least: f64,
        /// The most.
        most: f64,
    },
    /// Something beside the hand.
    #[error("a part of its mesh is more than a metre from the wrist: remove it")]
    FarPart,
    /// A measure that no hand of this length has.
    #[error("its {what} is {:.0} mm, {share:.2} times that of a human hand of this length: check the joints' names", 1e3 * metres)]
    Measure {
        /// Which measure.
        what: String,
        /// In metres.
        metres: f64,
        /// As a share of the mean hand's of the same length.
        share: f64,
    },
    /// A mesh that nothing moves.
    #[error("no mesh is bound to its joints: skin the mesh to them")]
    NoSkin,
}
