//! The names that entries refer to by number.

use std::collections::HashMap;

use anyhow::{Context as _, ensure};
use grasp_index::{ClassInfo, KeptFields};

/// The names that entries refer to by number.
#[derive(Clone, Debug, Default)]
pub(crate) struct Names {
    /// What is known of the entries.
    pub(crate) kept: KeptFields,
    pub(crate) classes: Vec<ClassInfo>,
    pub(crate) hand_shapes: Numbered,
    pub(crate) stages: Numbered,
}

/// Names in the order of their first use; a name's number is its position.
#[derive(Clone, Debug, Default)]
pub(crate) struct Numbered {
    pub(crate) names: Vec<String>,
    numbers: HashMap<String, usize>,
}

impl Names {
    /// Puts the classes in the order in which an index has them: by number, and those of one number
    /// by name.
    pub(crate) fn sort_classes(&mut self) {
        self.classes.sort_by(|a, b| (a.cutkosky, &a.name).cmp(&(b.cutkosky, &b.name)));
    }

    /// # Errors
    /// Where there are more than can be numbered.
    pub(crate) fn add_hand_shape(&mut self, name: &str) -> anyhow::Result<()> {
        let is_added = self.hand_shapes.add(name, 1 << 16);
        ensure!(is_added, "more than 65536 hand shapes: split what is to be indexed into several indexes");
        Ok(())
    }

    /// # Errors
    /// Where there are more than can be numbered.
    pub(crate) fn add_stage(&mut self, name: &str) -> anyhow::Result<()> {
        ensure!(self.stages.add(name, 1 << 8), "more than 256 stages: at most 256 can be numbered");
        Ok(())
    }

    pub(crate) fn class(&self, name: &str) -> anyhow::Result<u16> {
        number(self.classes.iter().position(|class| class.name == name), name)
    }

    pub(crate) fn hand_shape(&self, name: &str) -> anyhow::Result<u16> {
        number(self.hand_shapes.numbers.get(name).copied(), name)
    }

    pub(crate) fn stage(&self, name: &str) -> anyhow::Result<u8> {
        number(self.stages.numbers.get(name).copied(), name)
    }
}

impl Numbered {
    /// Numbers a name, unless there are `most` already; returns whether it has a number now.
    fn add(&mut self, name: &str, most: usize) -> bool {
        if self.numbers.contains_key(name) {
            return true;
        }
        if self.names.len() == most {
            return false;
        }
        self.numbers.insert(name.to_owned(), self.names.len());
        self.names.push(name.to_owned());
        true
    }
}

/// A position as the number that stands for it in the file.
fn number<N: TryFrom<usize>>(position: Option<usize>, name: &str) -> anyhow::Result<N> {
    position
        .and_then(|position| N::try_from(position).ok())
        .with_context(|| format!("more names than an index can number, or an unlisted one: {name}"))
}
