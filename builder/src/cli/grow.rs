//! `grasp-builder add`, `remove` and `compact`.

use std::path::PathBuf;

use anyhow::{Context as _, bail};
use grasp_index::Index;
use grasp_program::{Global, output_file};
use grasp_renders::Preset;
use grasp_terminal::text::shown;
use tracing::warn;

use super::plan::PlanOptions;
use super::preset::preset;
use super::report::print_report;
use crate::grow::{Growth, grow};
use crate::indexing::{OPTIONS, RenderSet, Source};
use crate::interrupt;
use crate::plan_spec::PlanSpec;
use crate::same_file::is_same_file;

/// Add render sets or hand shapes to an index.
///
/// What the index holds is taken over, not described again, and its parameters are kept; a picture
/// that it holds already is not added twice. Hands are posed and seen as those that it was built
/// with, but for what the options below say; --preset takes another plan altogether. The index is
/// replaced in one step, and the answers are those of an index built of the same entries from
/// nothing (to the last bit where it keeps descriptors as they are; --originals f16 hashes rounded
/// ones). With --segment the index is not touched.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder render --out more --hand-shape broad
  grasp-builder add grasp.idx more
  grasp-builder add grasp.idx --hand-shape slender
  grasp-builder add grasp.idx more --segment new.idx
  grasp-builder compact grasp.idx new.idx --out grasp.idx

Exit status: 0 done, 2 an error, 130 stopped by Ctrl-C.")]
pub(crate) struct Add {
    /// The index to add to.
    #[arg(value_name = "FILE")]
    index: PathBuf,
    /// Render sets to add; none renders on the fly.
    #[arg(value_name = "RENDERS", conflicts_with_all = ["hands", "hand_shape", "hand_model", "stage"])]
    renders: Vec<PathBuf>,
    /// Write an index of the added entries alone, which can be searched beside the other and joined
    /// to it with `compact`.
    #[arg(long, value_name = "FILE", value_parser = output_file())]
    segment: Option<PathBuf>,
    #[command(flatten)]
    plan: PlanOptions,
}

/// Take all entries of some hand shapes out of an index.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder remove grasp.idx --hand-shape slender

Exit status: 0 done, 2 an error, 130 stopped by Ctrl-C.")]
pub(crate) struct Remove {
    /// The index, which is replaced in one step.
    #[arg(value_name = "FILE")]
    index: PathBuf,
    /// The hand shape to remove (may be repeated).
    #[arg(long, value_name = "NAME", required = true)]
    hand_shape: Vec<String>,
    /// Measure and calibrate it on held-out hands that are seen as those of this preset, `paper`,
    /// `standard` or `wide`; by default as those that it was built with.
    #[arg(long, value_name = "NAME", value_parser = preset(), hide_possible_values = true)]
    preset: Option<Preset>,
}

/// Join indexes that are alike in everything but their entries.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder compact grasp.idx new.idx --out grasp.idx

Exit status: 0 done, 2 an error, 130 stopped by Ctrl-C.")]
pub(crate) struct Compact {
    /// The indexes, whose entries keep this order.
    #[arg(value_name = "FILE", required = true)]
    indexes: Vec<PathBuf>,
    /// The index to write, which may be one of them.
    #[arg(long, value_name = "FILE", default_value = "grasp.idx", value_parser = output_file())]
    out: PathBuf,
    /// Measure and calibrate what comes of them on held-out hands that are seen as those of this
    /// preset, `paper`, `standard` or `wide`; by default as those that the first was built with.
    #[arg(long, value_name = "NAME", value_parser = preset(), hide_possible_values = true)]
    preset: Option<Preset>,
}

impl Add {
    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        let seen = seen(self.plan.clone(), std::slice::from_ref(&self.index))?;
        let spec = seen.options.spec()?;
        // The seed of the index's own renders.
        let plan = seen.options.plan(seen.seed)?;
        let more = if self.renders.is_empty() {
            Source::Plan(Box::new(plan.clone()))
        } else {
            let grasps = seen.options.grasps()?;
            let open = |folder| RenderSet::open(folder, &grasps);
            Source::Sets(self.renders.iter().map(PathBuf::as_path).map(open).collect::<Result<_, _>>()?)
        };
        let growth = Growth {
            indexes: vec![self.index.clone()],
            keep: self.segment.is_none(),
            without: Vec::new(),
            more: Some(more),
            plan,
            spec,
        };
        let out = self.segment.as_ref().unwrap_or(&self.index);
        if self.segment.is_some() && is_same_file(out, &self.index) {
            bail!("--segment names the index itself, which it leaves as it is: name another file");
        }
        print_report(out, &grow(&growth, out, global.progress())?, true)
    }
}

impl Remove {
    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        let seen = seen(PlanOptions::of_preset(self.preset), std::slice::from_ref(&self.index))?;
        let growth = Growth {
            indexes: vec![self.index.clone()],
            keep: true,
            without: self.hand_shape.clone(),
            more: None,
            plan: seen.options.plan(seen.seed)?,
            spec: seen.options.spec()?,
        };
        print_report(&self.index, &grow(&growth, &self.index, global.progress())?, false)
    }
}

impl Compact {
    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        for (at, index) in self.indexes.iter().enumerate() {
            if self.indexes[..at].iter().any(|before| is_same_file(before, index)) {
                bail!("{} is named twice: each of its entries would be there twice", index.display());
            }
        }
        let seen = seen(PlanOptions::of_preset(self.preset), &self.indexes)?;
        let growth = Growth {
            indexes: self.indexes.clone(),
            keep: true,
            without: Vec::new(),
            more: None,
            plan: seen.options.plan(seen.seed)?,
            spec: seen.options.spec()?,
        };
        print_report(&self.out, &grow(&growth, &self.out, global.progress())?, false)
    }
}

/// How the hands of indexes are seen.
struct Seen {
    options: PlanOptions,
    seed: u64,
}

/// The options `own`, and beside them those that the first of the indexes was built with, unless a
/// preset is named.
fn seen(own: PlanOptions, indexes: &[PathBuf]) -> anyhow::Result<Seen> {
    let mut kept = Vec::with_capacity(indexes.len());
    let mut seed = 0;
    for path in indexes {
        let name = || format!("cannot use the index {}", path.display());
        let index = Index::open(path).with_context(name)?;
        let catalogue = index.catalogue();
        if kept.is_empty() {
            seed = catalogue.seed;
        }
        // Of vectors of unknown making, no hands are held out.
        if !catalogue.descriptor.describes_pictures() {
            return Ok(Seen { options: own, seed });
        }
        let text = catalogue.provenance.iter().find(|(key, _)| key == OPTIONS).map(|(_, text)| text);
        let spec = text.map(|text| text.parse::<PlanSpec>()).transpose();
        let spec =
            spec.with_context(|| format!("cannot tell how the hands of {} are seen", path.display()))?;
        if own.names_a_preset() {
            // Another way to pose and see them, of the same grasps.
            return Ok(Seen { options: own.or_grasps(spec.and_then(|spec| spec.grasps)), seed });
        }
        kept.push(spec);
    }
    let mut kept = kept.into_iter();
    let first = kept.next().flatten();
    let differs = kept.any(|other| other != first);
    if first.is_none() {
        warn!(
            subject = env!("CARGO_PKG_NAME"),
            "{} does not say how its hands are seen: it is taken to be as in the paper's preset; name another with --preset",
            indexes.first().map_or_else(String::new, |path| shown(path))
        );
    } else if differs {
        warn!(
            subject = env!("CARGO_PKG_NAME"),
            "the hands of these indexes are seen in different ways: the search is measured as that of the first was; name another \
             way with --preset"
        );
    }
    Ok(Seen { options: own.or(first.unwrap_or_else(|| PlanSpec::of_preset(Preset::Paper))), seed })
}
