//! Where pictures come from.

use std::ops::Range;

use grasp_renders::RenderPlan;

use super::described::Take;
use super::inputs::{OPTIONS, tool};
use super::known::Known;
use super::names::Names;
use super::recipe::Recipe;
use super::sets::RenderSet;
use super::vectors::Vectors;
use super::{planned, sets, vectors};
use crate::plan_spec::PlanSpec;

/// Where the pictures come from.
#[derive(Debug)]
pub enum Source {
    /// Rendered on the fly; no picture is written.
    Plan(Box<RenderPlan>),
    /// Read from the disk.
    Sets(Vec<RenderSet>),
    /// Described elsewhere.
    Vectors(Box<Vectors>),
}

impl Source {
    /// How many pictures there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Plan(plan) => plan.renders(),
            Self::Sets(sets) => sets.iter().map(RenderSet::len).sum(),
            Self::Vectors(vectors) => vectors.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// In how many pieces the work can be split: scenes that are to be rendered, pictures or rows.
    /// Scenes come hand shape by hand shape.
    #[must_use]
    pub fn pieces(&self) -> usize {
        match self {
            Self::Plan(plan) => plan.renders() / plan.views.count().max(1),
            Self::Sets(_) | Self::Vectors(_) => self.len(),
        }
    }

    /// What is done with the pictures, and what they are called, for a progress bar.
    pub(crate) fn work(&self) -> (&'static str, &'static str) {
        match self {
            Self::Plan(_) | Self::Sets(_) => ("describing", "views"),
            Self::Vectors(_) => ("reading", "rows"),
        }
    }

    pub(crate) fn names(&self) -> anyhow::Result<Names> {
        match self {
            Self::Plan(plan) => planned::names(plan),
            Self::Sets(sets) => sets::names(sets),
            Self::Vectors(vectors) => Ok(vectors::names(vectors)),
        }
    }

    /// Where an index of this source and recipe comes from, as its provenance says.
    pub(crate) fn origin(&self, recipe: &Recipe) -> anyhow::Result<Vec<(String, String)>> {
        Ok(origin(self, recipe.held_out.provenance()?, recipe.seen.as_ref()))
    }

    /// A number for all that some of the [`Self::pieces`] are made from: as long as it is the same,
    /// so are their entries.
    pub(crate) fn digest(&self, pieces: Range<usize>) -> anyhow::Result<u64> {
        match self {
            Self::Plan(plan) => Ok(planned::digest(plan)),
            Self::Sets(sets) => sets::digest(sets, pieces),
            Self::Vectors(vectors) => vectors::digest(vectors, pieces),
        }
    }

    /// Hands the pictures of some of the [`Self::pieces`] to `take`, described, in order.
    pub(crate) fn describe(
        &self,
        names: &Names,
        recipe: &Recipe,
        known: &Known,
        pieces: Range<usize>,
        take: Take<'_>,
    ) -> anyhow::Result<()> {
        match self {
            Self::Plan(plan) => planned::describe(plan, names, recipe, known, pieces, take),
            Self::Sets(sets) => sets::describe(sets, names, recipe, known, pieces, take),
            Self::Vectors(vectors) => vectors::describe(vectors, pieces, take),
        }
    }
}

/// Where an index of `source` comes from, measured by what `held_out` tells of, on hands that are
/// seen as `seen` says.
fn origin(source: &Source, held_out: Option<String>, seen: Option<&PlanSpec>) -> Vec<(String, String)> {
    let mut provenance = vec![tool()];
    match source {
        Source::Plan(plan) => {
            let hands = plan.hand_shapes.len() + plan.hand_models.len();
            let (grasps, views) = (plan.grasps.len(), plan.views.count());
            let scenes = plan.renders() / views.max(1);
            let text = format!(
                "rendered: {scenes} scenes (hand shapes: {hands}, grasps: {grasps}) of {views} views, seed {}",
                plan.seed
            );
            provenance.push(("source".to_owned(), text));
        }
        Source::Sets(sets) => provenance.extend(sets.iter().map(|set| {
            let text =
                format!("{}, {} pictures, manifest xxh3 {:016x}", set.name(), set.len(), set.manifest_hash());
            ("render set".to_owned(), text)
        })),
        Source::Vectors(vectors) => provenance.push(("vectors".to_owned(), vectors.provenance())),
    }
    provenance.extend(seen.map(|seen| (OPTIONS.to_owned(), seen.to_string())));
    provenance.extend(held_out.map(|held_out| ("held out".to_owned(), held_out)));
    provenance
}
