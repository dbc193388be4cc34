//! `grasp-builder queries`.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::bail;
use grasp_program::{Global, output_file};
use grasp_terminal::text::{counted, shown};

use super::plan::PlanOptions;
use super::preset_defaults::PresetDefaults;
use super::seed::DEFAULT_SEED;
use crate::descriptor;
use crate::held_out::{self, Hands};
use crate::{array, interrupt};

/// Write descriptors of hands that no plan renders, to search an index for: an array for
/// benchmarks.
///
/// Each is moved a little in a direction in which hands differ, so that its nearest neighbours are
/// about as far as those of real pictures; those of our own renders, as they are, lie closer and
/// make any search look better than it is.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder queries --out q.npy
  grasp-builder queries --out q.npy --preset wide --hands 8 --count 10000
  grasp-query search q.npy --index grasp.idx --out ids.npy --timings

Exit status: 0 done, 2 an error, 130 stopped by Ctrl-C.")]
pub(crate) struct Queries {
    /// The array to write: 32-bit floating-point numbers in NumPy's format, one row per query.
    #[arg(long, value_name = "Q.npy", value_parser = output_file())]
    out: PathBuf,
    /// Render about N views; those that show no hand are left out.
    #[arg(long, default_value_t = 2_000, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    count: u32,
    /// Leave the descriptors as they are.
    #[arg(long)]
    clean: bool,
    /// What all randomness comes from.
    #[arg(long, default_value_t = DEFAULT_SEED, value_name = "N")]
    seed: u64,
    /// How hand images are described: `learned`, `upright`, `default` or `paper`, as for `build`.
    /// By default as `build` does for the preset.
    #[arg(long, value_name = "NAME", value_parser = descriptor::NAMES)]
    descriptor: Option<String>,
    #[command(flatten)]
    plan: PlanOptions,
}

impl Queries {
    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        let name =
            self.descriptor.as_deref().unwrap_or(PresetDefaults::of_preset(self.plan.preset()).descriptor);
        let model = descriptor::by_name(name, None)?;
        if self.plan.names_hand_shapes() {
            bail!("queries are of hands that no index holds: leave out --hand-shape");
        }
        let plan = self.plan.plan(self.seed)?;
        if !plan.hand_models.is_empty() {
            bail!("queries are of hands that no index holds: leave out --hand-model");
        }
        if let Some(option) = self.plan.views_option() {
            bail!("queries are seen from anywhere, --count of them in all: leave out {option}");
        }
        let hands = self.plan.hands().unwrap_or(held_out::HANDS);
        if hands > self.count as usize {
            bail!(
                "{hands} hands are more than {} views: lower --hands, or ask for more by --count",
                self.count
            );
        }
        let hands = Hands::beside(&plan, &[], hands, self.count as usize, self.seed);
        let spinner = global.progress().spinner("rendering hands that no plan renders");
        let clean = hands.describe(&model)?.descriptors;
        drop(spinner);
        let dim = model.params().dim();
        let rows = if self.clean { clean } else { held_out::moved(&clean, dim, self.seed) };
        let count = rows.len() / dim;
        if count == 0 {
            bail!("none of the {} views shows a hand: ask for more with --count", self.count);
        }
        let mut next = rows.chunks_exact(dim);
        array::write(&self.out, count as u64, dim, |_, values| {
            values.extend_from_slice(next.next().unwrap_or_default());
            Ok(())
        })?;
        let moved = if self.clean { "" } else { ", each moved" };
        let count = counted(count, ["descriptor", "descriptors"]);
        writeln!(std::io::stdout().lock(), "{}: {count}{moved}; {hands}", shown(&self.out))?;
        Ok(())
    }
}
