//! What the node is told: by options of its command line, and as nodes are told by ROS, behind
//! `--ros-args` and in files of parameters.
//!
//! A parameter is the option of the same name (with underscores), and so is checked and explained
//! by the same code; options that are given by themselves come last and win.

mod options;
mod parameter_file;
mod ros;

use std::ffi::OsString;

use anyhow::bail;
use clap::{CommandFactory as _, FromArgMatches as _};

pub(crate) use options::{Options, Transport};

use crate::log::Level;
use crate::names::{Names, Remap};
use ros::RosArguments;

/// The name of the node unless `__node` says otherwise.
const NODE: &str = "grasp";
/// What remaps the node's name, and its older form.
const NAME: [&str; 2] = ["__node", "__name"];
/// What remaps the node's namespace.
const NAMESPACE: &str = "__ns";
/// A parameter that every node of ROS has.
const EVERYWHERE: &str = "use_sim_time";

/// All that the node is told.
#[derive(Debug)]
pub(crate) struct Arguments {
    pub(crate) options: Options,
    /// The node's name and those of its topics.
    pub(crate) names: Names,
    /// The least level that is logged.
    pub(crate) level: Level,
    /// What was said that means nothing here.
    pub(crate) ignored: Vec<String>,
}

impl Arguments {
    /// Reads a command line, without the program's name, and the files that it names.
    ///
    /// # Errors
    /// Where an argument is none, or a file of parameters cannot be read. A `clap::Error` prints
    /// itself, as help does.
    pub(crate) fn read(line: impl IntoIterator<Item = OsString>) -> anyhow::Result<Self> {
        let RosArguments { own, remaps, parameters, files, level } = RosArguments::split(line)?;
        let is_name = |remap: &Remap| NAME.contains(&remap.from.as_str()) || remap.from == NAMESPACE;
        let (own_names, remaps): (Vec<Remap>, Vec<Remap>) = remaps.into_iter().partition(is_name);
        // As of rcl's, the first that is for the node counts.
        let renamed = |keys: &[&str], node: &str| {
            let found =
                own_names.iter().find(|remap| keys.contains(&remap.from.as_str()) && remap.is_for(node));
            found.map(|remap| remap.to.clone())
        };
        let node = renamed(&NAME, NODE).unwrap_or_else(|| NODE.to_owned());
        let namespace = renamed(&[NAMESPACE], &node).unwrap_or_else(|| "/".to_owned());
        let names = Names::new(&namespace, &node, remaps)?;

        let mut ignored = Vec::new();
        let mut line = vec![OsString::from("grasp-ros")];
        for file in &files {
            let known = parameter_file::read(file, &names)?;
            for (name, value) in known {
                if let Some(argument) = argument(&name, &value) {
                    line.push(argument);
                } else if name != EVERYWHERE {
                    ignored.push(format!("the parameter {name} of {}: there is none", file.display()));
                }
            }
        }
        for ros::Assignment { node, name, value } in parameters {
            if node.is_some_and(|node| node != names.node()) || name == EVERYWHERE {
                continue;
            }
            let Some(argument) = argument(&name, &value) else {
                bail!("there is no parameter {name}: there are {}", Options::names().join(", "));
            };
            line.push(argument);
        }
        line.extend(own);
        let matches = Options::command().try_get_matches_from(line)?;
        let options = Options::from_arg_matches(&matches)?;
        options.check()?;
        Ok(Self { options, names, level: level.unwrap_or(Level::Info), ignored })
    }
}

/// A parameter as an argument of the command line; `None` where there is no such parameter.
fn argument(name: &str, value: &str) -> Option<OsString> {
    let is_known = Options::names().iter().any(|known| known == name);
    is_known.then(|| format!("--{}={value}", name.replace('_', "-")).into())
}

#[cfg(test)]
mod tests;
