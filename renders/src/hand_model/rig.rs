//! Joints, bones and skin of a model in its rest pose, in the file's own frame.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use nalgebra::{Matrix4, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::error::HandModelError;
use super::fault::{ModelFault, NotAHand, Unsupported};
use super::glb::{Document, Glb, Node, Primitive, Skin as Binding};
use crate::hand::Digit;

type V = Vector3<f64>;

/// Corners that a mesh may have, and triangles: a scan is to be reduced first, or every view takes
/// seconds.
const MOST_VERTICES: usize = 500_000;
const MOST_TRIANGLES: usize = 1_000_000;
/// Sets of four joints a vertex (`JOINTS_0`, `JOINTS_1`).
const SETS: usize = 2;
/// Joints that still move a vertex after the weakest were left out.
pub(super) const INFLUENCES: usize = 4;
/// The palm with the wrist, and three bones a digit.
pub(super) const BONES: usize = 16;
/// The number of the bone that the palm and the wrist are.
pub(super) const PALM: usize = 0;

/// The wrist, and of each digit the joints from the palm outward; the tip comes last.
const WRIST: &str = "wrist";
pub(super) const THUMB: [&str; 4] =
    ["thumb-metacarpal", "thumb-phalanx-proximal", "thumb-phalanx-distal", "thumb-tip"];
pub(super) const FINGERS: [[&str; 5]; 4] = [
    [
        "index-finger-metacarpal",
        "index-finger-phalanx-proximal",
        "index-finger-phalanx-intermediate",
        "index-finger-phalanx-distal",
        "index-finger-tip",
    ],
    [
        "middle-finger-metacarpal",
        "middle-finger-phalanx-proximal",
        "middle-finger-phalanx-intermediate",
        "middle-finger-phalanx-distal",
        "middle-finger-tip",
    ],
    [
        "ring-finger-metacarpal",
        "ring-finger-phalanx-proximal",
        "ring-finger-phalanx-intermediate",
        "ring-finger-phalanx-distal",
        "ring-finger-tip",
    ],
    [
        "pinky-finger-metacarpal",
        "pinky-finger-phalanx-proximal",
        "pinky-finger-phalanx-intermediate",
        "pinky-finger-phalanx-distal",
        "pinky-finger-tip",
    ],
];

/// The number of a digit's bone, counted from the palm.
pub(super) fn bone(digit: Digit, i: usize) -> usize {
    1 + 3 * digit as usize + i
}

/// All joints with the bones that they move.
fn joints() -> impl Iterator<Item = (&'static str, usize)> {
    let thumb = THUMB.into_iter().enumerate().map(|(i, name)| (name, bone(Digit::Thumb, i.min(2))));
    let fingers = Digit::FINGERS.into_iter().zip(FINGERS).flat_map(|(digit, names)| {
        // A finger's first joint lies in the palm and does not move by itself.
        names.into_iter().enumerate().map(move |(i, name)| match i {
            0 => (name, PALM),
            _ => (name, bone(digit, (i - 1).min(2))),
        })
    });
    std::iter::once((WRIST, PALM)).chain(thumb).chain(fingers)
}

/// A joint at rest: where it is, and its own axes where they are told.
#[derive(Debug, Clone, Copy)]
pub(super) struct Joint {
    pub(super) at: V,
    /// WebXR has the bone along -z and the nail's side at +y; whether this file does is for the
    /// reader to see.
    pub(super) forward: V,
    pub(super) up: V,
}

/// A vertex's place and what moves it: bones and their weights, which sum to 1; unused ones weigh
/// 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vertex {
    pub(super) at: V,
    pub(super) bones: [(u8, f32); INFLUENCES],
}

impl Vertex {
    /// The bone that moves it most.
    pub(super) fn bone(&self) -> usize {
        usize::from(self.bones[0].0)
    }
}

/// The skin at rest.
#[derive(Debug, Clone, Default)]
pub(super) struct Skin {
    /// Corners and triangles read, those in one place and those of no area among them: the work
    /// that a file makes is bounded.
    read: [usize; 2],
    pub(super) vertices: Vec<Vertex>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// A model at rest.
#[derive(Debug)]
pub(super) struct Rig {
    pub(super) wrist: V,
    /// Of each digit, thumb first, the three joints that bend or turn it, and the tip.
    pub(super) digits: [[Joint; 4]; 5],
    pub(super) skin: Skin,
}

impl Rig {
    /// Finds joints and skin.
    pub(super) fn read(glb: &Glb) -> Result<Rig, HandModelError> {
        let scene = Nodes::new(&glb.document)?;
        let named = name_joints(&glb.document)?;
        let joint = |name: &str| {
            // Every name was found.
            let pose = named.get(name).and_then(|&node| scene.poses.get(node)).copied().unwrap_or_default();
            let axis = |i: usize| pose.fixed_view::<3, 1>(0, i).into_owned();
            Joint { at: axis(3), forward: -axis(2), up: axis(1) }
        };
        let mut digits = [THUMB.map(joint); 5];
        for (digit, names) in digits[1..].iter_mut().zip(FINGERS) {
            let [_, rest @ ..] = names;
            *digit = rest.map(joint);
        }
        let mut bones: Vec<Option<usize>> = vec![None; glb.document.nodes.len()];
        for (name, bone) in joints() {
            if let Some(slot) = named.get(name).and_then(|&node| bones.get_mut(node)) {
                *slot = Some(bone);
            }
        }
        let skin = read_skin(glb, &scene, &bones)?;
        Ok(Rig { wrist: joint(WRIST).at, digits, skin })
    }
}

/// The nodes of all 25 joints.
fn name_joints(document: &Document) -> Result<HashMap<&'static str, usize>, HandModelError> {
    let mut found = HashMap::new();
    let mut missing = Vec::new();
    for (name, _) in joints() {
        let mut nodes = document.nodes.iter().enumerate().filter(|(_, n)| n.name.as_deref() == Some(name));
        match (nodes.next(), nodes.next()) {
            (None, _) => missing.push(name),
            (Some((node, _)), None) => {
                found.insert(name, node);
            }
            (Some(_), Some(_)) => return Err(HandModelError::TwiceJoint(name)),
        }
    }
    if missing.is_empty() { Ok(found) } else { Err(HandModelError::MissingJoints(missing)) }
}

/// The tree of nodes.
struct Nodes {
    parents: Vec<Option<usize>>,
    /// All nodes, parents before their children.
    order: Vec<usize>,
    /// From each node's frame into the scene's.
    poses: Vec<Matrix4<f64>>,
}

impl Nodes {
    fn new(document: &Document) -> Result<Nodes, HandModelError> {
        let nodes = &document.nodes;
        let mut parents = vec![None; nodes.len()];
        for (parent, node) in nodes.iter().enumerate() {
            for &child in &node.children {
                match parents.get_mut(child) {
                    Some(slot @ None) => *slot = Some(parent),
                    Some(_) => return Err(ModelFault::TwoParents(child).into()),
                    None => return Err(ModelFault::NoChild(parent).into()),
                }
            }
        }
        // From the roots down; what is not reached goes in a circle.
        let mut poses = vec![None; nodes.len()];
        let mut open: Vec<(usize, Matrix4<f64>)> =
            (0..nodes.len()).filter(|&i| parents[i].is_none()).map(|i| (i, Matrix4::identity())).collect();
        let mut order = Vec::with_capacity(nodes.len());
        while let Some((i, above)) = open.pop() {
            let pose = above * local(&nodes[i]);
            if !pose.iter().all(|x| x.is_finite()) {
                return Err(ModelFault::Pose(i).into());
            }
            poses[i] = Some(pose);
            order.push(i);
            open.extend(nodes[i].children.iter().map(|&child| (child, pose)));
        }
        let poses: Option<Vec<_>> = poses.into_iter().collect();
        let poses = poses.ok_or(ModelFault::Circle)?;
        Ok(Nodes { parents, order, poses })
    }

    /// Of every node, what `of` says of it or else of the nearest one above it.
    fn inherited<T: Copy>(&self, of: &[Option<T>]) -> Vec<Option<T>> {
        let mut known = of.to_vec();
        for &node in &self.order {
            known[node] = known[node].or_else(|| known[self.parents[node]?]);
        }
        known
    }
}

fn local(node: &Node) -> Matrix4<f64> {
    if let Some(matrix) = node.matrix {
        return Matrix4::from_column_slice(&matrix);
    }
    let [x, y, z, w] = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    // A rotation of no length becomes NaN, which the caller looks for.
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).to_homogeneous();
    let scale = Matrix4::new_nonuniform_scaling(&V::from(node.scale.unwrap_or([1.0; 3])));
    Translation3::from(node.translation.unwrap_or([0.0; 3])).to_homogeneous() * turn * scale
}

/// Every mesh that is bound to the hand's joints, in one. `bones[node]` is the node's bone; `None`
/// if it is no joint.
fn read_skin(glb: &Glb, scene: &Nodes, bones: &[Option<usize>]) -> Result<Skin, HandModelError> {
    let document = &glb.document;
    // Bones of no hand's (twists, the forearm) go with the joint above them, or with the wrist.
    let above: Vec<usize> = scene.inherited(bones).iter().map(|bone| bone.unwrap_or(PALM)).collect();
    // A skin's, once for all nodes that are bound by it.
    let mut moves_of: HashMap<usize, Moves> = HashMap::new();
    let mut skin = Skin::default();
    // Corners in one place are one: seams of textures must not show.
    let mut places: HashMap<[u64; 3], u32> = HashMap::new();
    for node in &document.nodes {
        let (Some(mesh), Some(number)) = (node.mesh, node.skin) else { continue };
        let (Some(mesh), Some(bound)) = (document.meshes.get(mesh), document.skins.get(number)) else {
            return Err(ModelFault::NoMesh.into());
        };
        let moves = match moves_of.entry(number) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => {
                let is_hand = |joint: &usize| bones.get(*joint).copied().flatten().is_some();
                new.insert(match bound.joints.iter().any(is_hand) {
                    true => moves(glb, bound, scene, &above)?,
                    false => Vec::new(),
                })
            }
        };
        if moves.is_empty() {
            continue;
        }
        for primitive in &mesh.primitives {
            read_primitive(glb, primitive, moves, &mut skin, &mut places)?;
        }
    }
    if skin.triangles.is_empty() {
        return Err(NotAHand::NoSkin.into());
    }
    Ok(skin)
}

/// Of each joint of a skin, where it moves what is bound to it, and the bone that it goes with.
type Moves = Vec<(Matrix4<f64>, usize)>;

/// Those of a skin; `above` is the bone that each node goes with.
fn moves(glb: &Glb, bound: &Binding, scene: &Nodes, above: &[usize]) -> Result<Moves, HandModelError> {
    let mut binds = vec![Matrix4::identity(); bound.joints.len()];
    if let Some(accessor) = bound.inverse_bind_matrices {
        let matrices = glb.rows::<16>(accessor, "MAT4")?;
        if matrices.len() < binds.len() {
            return Err(ModelFault::Binds.into());
        }
        for (bind, matrix) in binds.iter_mut().zip(matrices) {
            *bind = Matrix4::from_column_slice(&matrix);
        }
    }
    let moved = |(&joint, bind): (&usize, &Matrix4<f64>)| {
        let (pose, bone) = scene.poses.get(joint).zip(above.get(joint)).ok_or(ModelFault::NoJoint(joint))?;
        Ok((pose * bind, *bone))
    };
    bound.joints.iter().zip(&binds).map(moved).collect()
}

fn read_primitive(
    glb: &Glb,
    primitive: &Primitive,
    moves: &[(Matrix4<f64>, usize)],
    skin: &mut Skin,
    places: &mut HashMap<[u64; 3], u32>,
) -> Result<(), HandModelError> {
    if primitive.mode.unwrap_or(4) != 4 {
        return Err(Unsupported::NoTriangles.into());
    }
    let attribute = |name: &str| primitive.attributes.get(name).copied();
    let position = attribute("POSITION").ok_or(ModelFault::NoPosition)?;
    let positions = glb.rows::<3>(position, "VEC3")?;
    let mut sets = Vec::new();
    for set in 0..SETS {
        let (Some(joints), Some(weights)) =
            (attribute(&format!("JOINTS_{set}")), attribute(&format!("WEIGHTS_{set}")))
        else {
            break;
        };
        sets.push((glb.rows::<4>(joints, "VEC4")?, glb.rows::<4>(weights, "VEC4")?));
    }
    if sets.is_empty() {
        return Err(ModelFault::NoWeights.into());
    }
    // Parts without vertices take time as well.
    skin.read[0] += positions.len().max(1);
    if skin.read[0] > MOST_VERTICES {
        return Err(Unsupported::TooFine { what: "vertices", most: MOST_VERTICES }.into());
    }
    let mut numbers = Vec::with_capacity(positions.len());
    for (i, position) in positions.iter().enumerate() {
        let mut influences = Vec::with_capacity(4 * SETS);
        for (joints, weights) in &sets {
            let (Some(joints), Some(weights)) = (joints.get(i), weights.get(i)) else {
                return Err(ModelFault::FewWeights.into());
            };
            influences.extend(joints.iter().copied().zip(weights.iter().copied()));
        }
        let vertex = bind(position, &influences, moves).ok_or(ModelFault::Vertex(i))?;
        // Adding 0 makes -0 the same as 0.
        let place = vertex.at.map(|x| (x + 0.0).to_bits()).into();
        numbers.push(*places.entry(place).or_insert_with(|| {
            skin.vertices.push(vertex);
            skin.vertices.len() as u32 - 1
        }));
    }
    let order: Vec<f64> = match primitive.indices {
        Some(accessor) => glb.rows::<1>(accessor, "SCALAR")?.into_iter().map(|[i]| i).collect(),
        None => (0..numbers.len()).map(|i| i as f64).collect(),
    };
    skin.read[1] += order.len() / 3;
    if skin.read[1] > MOST_TRIANGLES {
        return Err(Unsupported::TooFine { what: "triangles", most: MOST_TRIANGLES }.into());
    }
    for vertices in order.chunks_exact(3) {
        let mut triangle = [0; 3];
        for (slot, &index) in triangle.iter_mut().zip(vertices) {
            let number = whole(index).and_then(|i| numbers.get(i));
            *slot = *number.ok_or(ModelFault::Triangle)?;
        }
        let [a, b, c] = triangle;
        if a != b && b != c && c != a {
            skin.triangles.push(triangle);
        }
    }
    Ok(())
}

/// Where a vertex is at rest, and the bones that move it; `None` when its weights or joints cannot
/// be.
fn bind(position: &[f64; 3], influences: &[(f64, f64)], moves: &[(Matrix4<f64>, usize)]) -> Option<Vertex> {
    let mut weights = [0.0; BONES];
    let mut at = V::zeros();
    let mut sum = 0.0;
    for &(joint, weight) in influences {
        // Unused places may name any joint.
        if weight == 0.0 {
            continue;
        }
        if !(weight > 0.0 && weight.is_finite()) {
            return None;
        }
        let (pose, bone) = moves.get(whole(joint)?)?;
        at += (pose * V::from(*position).push(1.0)).xyz() * weight;
        weights[*bone] += weight;
        sum += weight;
    }
    let at = at / sum;
    if sum == 0.0 || !at.iter().all(|x| x.is_finite()) {
        return None;
    }
    let mut strongest: Vec<usize> = (0..BONES).collect();
    strongest.sort_by(|&a, &b| weights[b].total_cmp(&weights[a]));
    strongest.truncate(INFLUENCES);
    let kept: f64 = strongest.iter().map(|&bone| weights[bone]).sum();
    let mut bones = [(0, 0.0); INFLUENCES];
    for (slot, bone) in bones.iter_mut().zip(strongest) {
        *slot = (bone as u8, (weights[bone] / kept) as f32);
    }
    Some(Vertex { at, bones })
}

/// A number that was stored as a whole one.
fn whole(value: f64) -> Option<usize> {
    (value >= 0.0 && value.fract() == 0.0 && value < f64::from(u32::MAX)).then_some(value as usize)
}
