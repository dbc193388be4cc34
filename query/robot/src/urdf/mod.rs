//! A gripper by its URDF: joints, limits, and which joint follows which. What a URDF does not say
//! stands in a TOML file beside it: where the palm is, which links are the fingers' tips, and,
//! where more than one joint moves by itself, how the hand grasps.
//!
//! Both become one description in the form of a HAND.toml, which is read and checked like any
//! other.

mod derive;
mod markup;
mod tree;
mod values;

use std::path::Path;

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde::Deserialize;
use toml::{Table, Value};

use crate::read::{Source, text};
use crate::{DescriptionFault, RobotError, UrdfFault};
use tree::Tree;
use values::{numbers, way};

/// No hand has more fingers; what is made of a URDF has all segments of each.
const MOST_TIPS: usize = 32;
/// An axis whose length is less has no direction.
const SHORTEST_AXIS: f64 = 1e-3;

/// What the file beside a URDF says that no HAND.toml has.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Companion {
    palm: PalmFrame,
    tips: Vec<String>,
    /// From a tip's frame to the surface of its pad, toward the other tip, in metres.
    #[serde(default)]
    pad: f64,
}

/// Where the palm is.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PalmFrame {
    /// The link that it is part of.
    link: String,
    /// The middle of its surface in that link's frame, in metres.
    #[serde(default)]
    at: [f64; 3],
    /// The direction in which the hand goes to the object.
    approach: [f64; 3],
    /// The direction to the thumb, or to one of two fingers: across what is grasped.
    thumb: [f64; 3],
}

/// The description that a URDF and the file beside it make together, as a HAND.toml.
///
/// # Errors
/// [`RobotError::Read`], [`RobotError::NoCompanion`], [`RobotError::Format`].
pub(super) fn description(path: &Path) -> Result<String, RobotError> {
    let urdf = text(path)?;
    let companion = path.with_extension("toml");
    let name = path.display().to_string();
    let source = Source { name: &name, what: "a gripper as URDF" };
    let tree = Tree::parse(source, &urdf)?;
    if !companion.exists() {
        return Err(RobotError::NoCompanion { companion, example: example(&tree) });
    }
    let stem = path.file_stem().map_or_else(|| "gripper".into(), |stem| stem.to_string_lossy());
    let table = merged(&tree, &stem, source, &companion)?;
    // Tables of numbers and names can always be written.
    toml::to_string(&table).map_err(|error| source.error(UrdfFault::Parser(error.to_string()).into()))
}

/// A companion that could be right: the root for the palm, and the links that carry no others for
/// the tips.
fn example(tree: &Tree) -> String {
    let tips: Vec<String> = tree.leaves().iter().take(4).map(|leaf| format!("{leaf:?}")).collect();
    format!(
        "    palm = {{ link = {:?}, at = [0.0, 0.0, 0.06], approach = [0, 0, 1], thumb = [0, 1, 0] }}\n    tips = [{}]\n    max_contact_force = 40.0",
        tree.root(),
        tips.join(", ")
    )
}

/// What the URDF says, with what the companion adds and says otherwise.
fn merged(tree: &Tree, name: &str, urdf: Source<'_>, path: &Path) -> Result<Table, RobotError> {
    let beside = path.display().to_string();
    let source = Source { name: &beside, what: "what a URDF does not say of a hand" };
    let mut own: Table = source.parse(&text(path)?)?;
    let companion: Table =
        ["palm", "tips", "pad"].into_iter().filter_map(|key| own.remove_entry(key)).collect();
    let companion: Companion = Value::Table(companion)
        .try_into()
        .map_err(|error: toml::de::Error| source.error(DescriptionFault::Toml(error)))?;
    let wrist = match own.get("wrist_link") {
        Some(Value::String(link)) => link.clone(),
        _ => tree.root().to_owned(),
    };
    let palm = companion.palm.in_wrist(source, tree, &wrist)?;
    if !own.contains_key("max_contact_force") {
        return Err(source.error(UrdfFault::NoForce.into()));
    }
    if companion.tips.is_empty() {
        return Err(source.error(UrdfFault::NoTips.into()));
    }
    if companion.tips.len() > MOST_TIPS {
        let count = companion.tips.len();
        return Err(source.error(UrdfFault::TooManyTips { count, most: MOST_TIPS }.into()));
    }
    let mut chains = Vec::new();
    for tip in &companion.tips {
        chains.push(tree.chain(source, &wrist, tip)?);
    }
    let limits = tree.limits(urdf, &chains)?;
    if limits.is_empty() {
        let tips = companion.tips.join(", ");
        return Err(source.error(UrdfFault::NothingMoves { wrist, tips }.into()));
    }

    let mut table = Table::new();
    let mut set = |key: &str, value: Value| {
        table.insert(key.to_owned(), value);
    };
    set("name", name.into());
    set("about", format!("{}, by its URDF", tree.name()).into());
    set("wrist_link", wrist.into());
    set("wrist_from_palm", numbers(palm.translation.vector.into()));
    set("wrist_from_palm_xyzw", numbers(palm.rotation.coords.into()));
    set("palm_height", palm.translation.vector.norm().max(0.01).into());
    set("touch_links", Value::Array(tree.links_of(&chains).into_iter().map(Value::from).collect()));
    set("approach", way(0.10, 0.05));
    set("retreat", way(0.10, 0.05));
    set("chain", Value::Array(chains.iter().map(|chain| tree.table(chain)).collect()));
    if !own.contains_key("grasp") {
        let joints: Vec<&String> = limits.keys().collect();
        let [joint] = joints[..] else {
            let names: Vec<&str> = joints.iter().map(|joint| joint.as_str()).collect();
            let fault = UrdfFault::NoGrasp { count: names.len(), joints: names.join(", ") };
            return Err(source.error(fault.into()));
        };
        let ends = limits.get(joint).copied().unwrap_or_default();
        let tips = derive::Gripper::new(tree, &chains, &palm, companion.pad);
        let (map, grasp) = tips.grasp(source, joint, ends)?;
        set("map", map);
        set("grasp", grasp);
    }
    let limits = limits.into_iter().map(|(joint, ends)| (joint, numbers(ends))).collect();
    set("limits", Value::Table(limits));
    table.extend(own);
    Ok(table)
}

impl PalmFrame {
    /// The palm in the wrist's frame, all joints being at 0.
    fn in_wrist(&self, source: Source<'_>, tree: &Tree, wrist: &str) -> Result<Isometry3<f64>, RobotError> {
        source.position("palm.at", self.at)?;
        let link = tree.pose(source, wrist, &self.link)?;
        let [approach, thumb] = [self.approach, self.thumb].map(Vector3::from);
        let z = approach.try_normalize(SHORTEST_AXIS);
        let y = z.and_then(|z| (thumb - z * thumb.dot(&z)).try_normalize(SHORTEST_AXIS));
        let (Some(z), Some(y)) = (z, y) else {
            let fault = UrdfFault::Palm { approach: self.approach, thumb: self.thumb };
            return Err(source.error(fault.into()));
        };
        let axes = Matrix3::from_columns(&[y.cross(&z), y, z]);
        let turned = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        Ok(link * Isometry3::from_parts(Translation3::from(self.at), turned))
    }
}
