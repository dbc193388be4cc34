//! The arguments that every node of ROS takes, behind `--ros-args`.

use std::ffi::OsString;
use std::path::PathBuf;

use anyhow::{Context as _, bail};

use crate::log::Level;
use crate::names::Remap;

/// A command line, what is for ROS apart from the rest.
#[derive(Debug, Default)]
pub(super) struct RosArguments {
    /// What stands before `--ros-args` and behind the `--` that ends it.
    pub(super) own: Vec<OsString>,
    pub(super) remaps: Vec<Remap>,
    pub(super) parameters: Vec<Assignment>,
    pub(super) files: Vec<PathBuf>,
    pub(super) level: Option<Level>,
}

/// `-p [NODE:]NAME:=VALUE`.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Assignment {
    pub(super) node: Option<String>,
    pub(super) name: String,
    pub(super) value: String,
}

/// Options that are accepted because launch files give them, and change nothing here.
const WITHOUT_EFFECT: [&str; 6] = [
    "--enable-rosout-logs",
    "--disable-rosout-logs",
    "--enable-stdout-logs",
    "--disable-stdout-logs",
    "--enable-external-lib-logs",
    "--disable-external-lib-logs",
];

impl RosArguments {
    /// Tells the arguments of ROS from the others.
    ///
    /// # Errors
    /// Where one is not known, or lacks its value.
    pub(super) fn split(line: impl IntoIterator<Item = OsString>) -> anyhow::Result<Self> {
        let mut found = Self::default();
        let mut line = line.into_iter();
        let mut is_ros = false;
        while let Some(word) = line.next() {
            if !is_ros {
                is_ros = word == "--ros-args";
                if !is_ros {
                    found.own.push(word);
                }
                continue;
            }
            let word = word.into_string().map_err(|word| {
                anyhow::anyhow!("behind --ros-args, {} is no text", word.to_string_lossy())
            })?;
            let mut value = || {
                let value = line.next().and_then(|value| value.into_string().ok());
                value.with_context(|| format!("{word} needs a value behind it"))
            };
            match word.as_str() {
                "--" => is_ros = false,
                "--ros-args" => {}
                "-p" | "--param" => found.parameters.push(assignment(&value()?)?),
                "-r" | "--remap" => found.remaps.push(remap(&value()?)?),
                "--params-file" => found.files.push(value()?.into()),
                "--log-level" => found.level = Some(level(&value()?)?),
                known if WITHOUT_EFFECT.contains(&known) => {}
                "-e" | "--enclave" | "--log-config-file" | "--log-file-name" => drop(value()?),
                other => match other.split_once(":=") {
                    // As ROS 1 had it, and as some launch files still have it.
                    Some(_) => found.remaps.push(remap(other)?),
                    None => bail!(
                        "{other} behind --ros-args is not known: there are -p NAME:=VALUE, -r FROM:=TO, --params-file FILE and \
                         --log-level LEVEL; end them with -- before options of the program"
                    ),
                },
            }
        }
        Ok(found)
    }
}

fn halves(text: &str, what: &str) -> anyhow::Result<(Option<String>, String, String)> {
    let (left, right) =
        text.split_once(":=").with_context(|| format!("{text:?} is no {what}: LEFT:=RIGHT is needed"))?;
    let (node, left) = match left.split_once(':') {
        Some((node, left)) => (Some(node.to_owned()), left),
        None => (None, left),
    };
    if left.is_empty() {
        bail!("{text:?} is no {what}: nothing stands before :=");
    }
    Ok((node, left.to_owned(), right.to_owned()))
}

fn assignment(text: &str) -> anyhow::Result<Assignment> {
    let (node, name, value) = halves(text, "parameter")?;
    // Values are YAML: a quoted one is text.
    let quoted = ['"', '\''].iter().find_map(|&mark| value.strip_prefix(mark)?.strip_suffix(mark));
    let value = quoted.unwrap_or(&value).to_owned();
    Ok(Assignment { node, name, value })
}

fn remap(text: &str) -> anyhow::Result<Remap> {
    let (node, from, to) = halves(text, "remapping")?;
    if to.is_empty() {
        bail!("{text:?} is no remapping: nothing stands behind :=");
    }
    Ok(Remap { node, from, to })
}

/// A level, or the level of this node's logger: `NAME:=LEVEL`.
fn level(text: &str) -> anyhow::Result<Level> {
    let name = text.rsplit_once(":=").map_or(text, |(_, level)| level);
    Level::named(name)
        .with_context(|| format!("{name:?} is no level of logging: debug, info, warn, error or fatal"))
}
