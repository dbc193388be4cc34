//! Files of parameters, as `--params-file` names them and launch files write them: YAML, in which
//! a node's name leads to its `ros__parameters`.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use anyhow::{Context as _, bail};
use serde_json::Value;

use crate::names::Names;

/// The key under which a node's parameters stand.
const PARAMETERS: &str = "ros__parameters";
/// A file of parameters is not larger, in bytes.
const MOST: u64 = 1 << 20;
/// No node lies deeper in namespaces.
const DEEPEST: usize = 32;

/// The parameters that a file has for a node, in the file's order of names; those of a name without
/// wildcards come last and win. Names of nested ones are joined by dots.
///
/// # Errors
/// Where the file cannot be read, or is no file of parameters.
pub(super) fn read(path: &Path, names: &Names) -> anyhow::Result<Vec<(String, String)>> {
    let context = || format!("cannot read the parameters of {}", path.display());
    let mut text = String::new();
    let file = File::open(path).with_context(context)?;
    file.take(MOST + 1).read_to_string(&mut text).with_context(context)?;
    if text.len() as u64 > MOST {
        bail!("{}: it is larger than {MOST} bytes", context());
    }
    of_text(&text, names).with_context(context)
}

/// The same of a file's text.
pub(super) fn of_text(text: &str, names: &Names) -> anyhow::Result<Vec<(String, String)>> {
    let value: Value = serde_saphyr::from_str(text)?;
    let Value::Object(nodes) = value else {
        bail!("names of nodes are needed, and under each {PARAMETERS}");
    };
    let mut found = Found { names, general: BTreeMap::new(), own: BTreeMap::new() };
    found.visit("", nodes, 0)?;
    let Found { mut general, own, .. } = found;
    general.extend(own);
    Ok(general.into_iter().collect())
}

struct Found<'a> {
    names: &'a Names,
    /// Of nodes whose names have wildcards.
    general: BTreeMap<String, String>,
    /// Of this node by its name.
    own: BTreeMap<String, String>,
}

impl Found<'_> {
    fn visit(
        &mut self,
        place: &str,
        keys: serde_json::Map<String, Value>,
        depth: usize,
    ) -> anyhow::Result<()> {
        if depth > DEEPEST {
            bail!("namespaces are nested too deep");
        }
        for (key, value) in keys {
            match value {
                Value::Object(inner) if key == PARAMETERS => {
                    if matches(place, &self.names.node_path()) {
                        let into = if place.contains('*') { &mut self.general } else { &mut self.own };
                        flatten("", inner, into, depth)?;
                    }
                }
                Value::Object(inner) => {
                    let below = format!("{place}/{}", key.trim_start_matches('/'));
                    self.visit(&below, inner, depth + 1)?;
                }
                Value::Null => {}
                _ => bail!("{key} leads to no {PARAMETERS}"),
            }
        }
        Ok(())
    }
}

/// Whether a node's full name is one that `pattern` stands for: `*` is any one part, `**` any
/// number of them.
fn matches(pattern: &str, name: &str) -> bool {
    let name: Vec<&str> = parts(name).collect();
    // Which beginnings of the name, by their number of parts, the pattern so far stands for.
    let mut matched = vec![false; name.len() + 1];
    matched[0] = true;
    for part in parts(pattern) {
        if part == "**" {
            let least = matched.iter().position(|matched| *matched).unwrap_or(matched.len());
            matched[least..].fill(true);
        } else {
            for (at, own) in name.iter().enumerate().rev() {
                matched[at + 1] = matched[at] && (part == "*" || part == *own);
            }
            matched[0] = false;
        }
    }
    matched[name.len()]
}

fn parts(path: &str) -> impl Iterator<Item = &str> {
    path.split('/').filter(|part| !part.is_empty())
}

fn flatten(
    prefix: &str,
    values: serde_json::Map<String, Value>,
    into: &mut BTreeMap<String, String>,
    depth: usize,
) -> anyhow::Result<()> {
    if depth > DEEPEST {
        bail!("parameters are nested too deep");
    }
    for (key, value) in values {
        let name = if prefix.is_empty() { key } else { format!("{prefix}.{key}") };
        match value {
            Value::Object(inner) => flatten(&name, inner, into, depth + 1)?,
            Value::String(text) => drop(into.insert(name, text)),
            Value::Null => drop(into.insert(name, String::new())),
            other => drop(into.insert(name, other.to_string())),
        }
    }
    Ok(())
}
