//! Labelled pictures that are recognised and scored: what the subcommands that do so share.

use grasp_index::Index;
use grasp_recognise::{RecogniseOptions, Recogniser};

use super::options::RecogniseArguments;
use super::selection::{Selected, Selection};
use crate::evaluate::Outcome;
use grasp_program::Global;

/// Which pictures are recognised, how, and in which form their score is printed.
#[derive(Debug, clap::Args)]
pub(super) struct LabelledArguments {
    #[command(flatten)]
    pub(super) selection: Selection,
    /// Take the labelled masks of camera pictures instead of finding the hands.
    #[arg(long)]
    pub(super) labelled_masks: bool,
    /// Print the figures as one JSON record.
    #[arg(long)]
    pub(super) json: bool,
    #[command(flatten)]
    pub(super) recognise: RecogniseArguments,
}

impl LabelledArguments {
    /// The table, as the command names it.
    pub(super) fn table(&self) -> String {
        self.selection.path().display().to_string()
    }

    /// The selected rows that are labelled with the index's classes, or with none of them.
    pub(super) fn read(&self, index: &Index) -> anyhow::Result<Selected> {
        self.selection.read(&index.catalogue().class_names())
    }

    /// Recognises every picture by the index; the outcomes are in the table's order.
    ///
    /// # Errors
    /// Where the index was overwritten meanwhile.
    pub(super) fn score(
        &self,
        selected: &Selected,
        index: &Index,
        options: RecogniseOptions,
        global: &Global,
    ) -> anyhow::Result<Vec<Outcome>> {
        self.check_masks(selected);
        selected.score(&Recogniser::new(index, options), self.labelled_masks, global)
    }

    /// Warns where masks are asked for and there is none.
    pub(super) fn check_masks(&self, selected: &Selected) {
        if self.labelled_masks && !selected.has_camera_masks() {
            tracing::warn!(
                "--labelled-masks changes nothing: no camera picture has a mask in {}",
                self.table()
            );
        }
    }
}
