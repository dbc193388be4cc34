//! `grasp-query experiment shapes`.

use std::path::PathBuf;

use anyhow::bail;
use grasp_answer::index_file;
use grasp_index::Index;

use crate::cli::figures::print;
use crate::cli::labelled::LabelledArguments;
use crate::cli::outputs::make_folder;
use crate::experiment::shapes::{Scored, Shapes};
use grasp_program::Global;
use grasp_program::status::{ERROR, SUCCESS};

/// Hand shapes against accuracy: the same labelled pictures, recognised by indexes of ever more
/// hand shapes.
///
/// How many an index holds is read from it; `grasp-builder experiment shapes` builds such indexes.
/// With --out, DIR gets shapes.csv, shapes.json and shapes.svg.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder experiment shapes --out shapes --counts 1,3,10
  grasp-query experiment shapes tests/pictures/labels.csv \\
    --index shapes/hands-0001.idx --index shapes/hands-0003.idx --index shapes/hands-0010.idx \\
    --hand right --out results

LABELS.csv is as for `grasp-query evaluate`.

Exit status: 0, or 2 where the table or a picture of it could not be used.")]
pub(super) struct ShapesArguments {
    /// An index to recognise the pictures by; several may be named.
    #[arg(long = "index", value_name = "FILE", required = true)]
    indexes: Vec<PathBuf>,
    /// Write table and drawing into this folder; made where there is none.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    labelled: LabelledArguments,
}

impl ShapesArguments {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<u8> {
        // All of them first: a wrong name should not be found out after the work.
        let mut indexes: Vec<(&PathBuf, Index)> = Vec::new();
        for path in &self.indexes {
            indexes.push((path, index_file::open_for_pictures(path, false)?));
        }
        let classes = indexes.first().map(|(_, index)| index.catalogue().class_names()).unwrap_or_default();
        if let Some((path, _)) = indexes.iter().find(|(_, index)| index.catalogue().class_names() != classes)
        {
            bail!(
                "{} has other classes than the first index: name indexes of the same grasps",
                path.display()
            );
        }
        let selected = self.labelled.selection.read(&classes)?;
        if let Some(folder) = &self.out {
            let indexes = self.indexes.iter().map(PathBuf::as_path);
            make_folder(folder, &Shapes::FILES, indexes.chain([self.labelled.selection.path()]))?;
        }
        let options = self.labelled.recognise.options()?;
        let score = |(path, index): &(&PathBuf, Index)| -> anyhow::Result<Scored> {
            Ok(Scored {
                index: path.display().to_string(),
                hand_shapes: index.catalogue().hand_shapes.len(),
                entries: index.len(),
                outcomes: self.labelled.score(&selected, index, options.clone(), global)?,
            })
        };
        let scored: Vec<Scored> = indexes.iter().map(score).collect::<Result<_, _>>()?;
        let shapes = Shapes::new(self.labelled.table(), &classes, &scored, &selected.broken);
        if let Some(folder) = &self.out {
            shapes.write(folder)?;
        }
        print(self.labelled.json, &shapes, || shapes.text())?;
        Ok(if shapes.errors.is_empty() { SUCCESS } else { ERROR })
    }
}
