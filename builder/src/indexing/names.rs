//! The names that entries refer to by number.

use std::collections::HashMap;

use anyhow::{Context as _, bail};
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
    /// More names than that cannot be numbered in the file.
    const MOST: usize = 1 << 16;

    pub(crate) fn add(&mut self, name: &str) -> anyhow::Result<()> {
        if !self.numbers.contains_key(name) {
            if self.names.len() == Self::MOST {
                bail!(
                    "more than {} different hand shapes: split the render sets into several indexes",
                    Self::MOST
                );
            }
            self.numbers.insert(name.to_owned(), self.names.len());
            self.names.push(name.to_owned());
        }
        Ok(())
    }
}

/// A position as the number that stands for it in the file.
fn number<N: TryFrom<usize>>(position: Option<usize>, name: &str) -> anyhow::Result<N> {
    position
        .and_then(|position| N::try_from(position).ok())
        .with_context(|| format!("more names than an index can number, or an unlisted one: {name}"))
}
