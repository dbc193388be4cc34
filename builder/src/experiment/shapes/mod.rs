//! Indexes of ever more hand shapes, for `grasp-query experiment shapes` to score labelled pictures
//! by.
//!
//! The hand shapes of a smaller index are among those of every larger one. An index that is up to
//! date is not built again, so that stopped work goes on where it was.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use anyhow::Context as _;
use grasp_index::{DescriptorModel, HashParams, Originals};
use grasp_renders::RenderPlan;
use grasp_terminal::Progress;

use crate::held_out::{Hands, HeldOut};
use crate::indexing::{Recipe, Report, Source, build};
use crate::plan_spec::PlanSpec;

/// What to build.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Numbers of hand shapes, each at least 1.
    pub counts: BTreeSet<u32>,
    /// What is rendered of each hand shape; its own hand shapes do not matter.
    pub plan: RenderPlan,
    /// How the indexes keep that; `None` where it is none of the options of a build.
    pub seen: Option<PlanSpec>,
    /// How hand images are described.
    pub descriptor: DescriptorModel,
    /// Where the indexes go; made where there is none.
    pub out: PathBuf,
}

/// Builds what is missing and returns the indexes' paths, fewest hand shapes first. Calls
/// `report_index` with each path and what was done.
///
/// # Errors
/// Where an index cannot be built. [`crate::interrupt::Interrupted`] when the user asked to stop;
/// finished indexes stay.
pub fn run(
    settings: &Settings,
    progress: Progress,
    report_index: &mut dyn FnMut(&PathBuf, &Report),
) -> anyhow::Result<Vec<PathBuf>> {
    let out = &settings.out;
    fs::create_dir_all(out).with_context(|| format!("cannot make the folder {}", out.display()))?;
    let seed = settings.plan.seed;
    let build_one = |&count: &u32| {
        let path = out.join(format!("hands-{count:04}.idx"));
        let plan = settings.plan.clone().with_hands(count as usize);
        let recipe = Recipe {
            descriptor: settings.descriptor.clone(),
            hash: HashParams::Learned,
            originals: Originals::default(),
            held_out: HeldOut::Rendered(Box::new(Hands::of_a_build(&plan, &[], seed))),
            seen: settings.seen.clone(),
            // Nobody looks at the neighbours of these.
            thumbnail_side: 0,
            seed,
        };
        let report = build(&Source::Plan(Box::new(plan)), &recipe, &path, progress)?;
        report_index(&path, &report);
        Ok(path)
    };
    settings.counts.iter().map(build_one).collect()
}
