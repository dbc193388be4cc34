//! `grasp-builder experiment`.

use std::collections::BTreeSet;
use std::io::Write as _;
use std::path::PathBuf;

use clap::Subcommand;
use grasp_program::Global;
use grasp_renders::{Preset, RenderPlan, ViewGrid, Views};
use grasp_terminal::text::{counted, percent, shown};
use tracing::info;

use super::networks_experiment::Networks;
use super::plan::parse_step;
use super::preset::preset;
use super::preset_defaults::PresetDefaults;
use super::report::ENTRIES;
use super::seed::DEFAULT_SEED;
use crate::experiment::scale::data::Data;
use crate::experiment::scale::fit::power_law;
use crate::experiment::scale::plot::{self, PAPER_EXPONENT};
use crate::experiment::scale::table::Row;
use crate::experiment::scale::{Hash, Settings, default_sizes, redraw, run};
use crate::experiment::shapes;
use crate::interrupt;
use crate::plan_spec::PlanSpec;

/// Vary something and measure what the search does, as a table and a picture.
#[derive(Debug, clap::Args)]
pub(crate) struct Experiment {
    #[command(subcommand)]
    name: Name,
}

#[derive(Debug, Subcommand)]
enum Name {
    Scale(Scale),
    Shapes(Shapes),
    Networks(Networks),
}

/// How latency, candidates, recall, file size and build time grow with the number of entries.
///
/// Indexes of ever more hand shapes are built and searched, on one core, for queries of other hand
/// shapes, so that a neighbour within 5 % of the nearest is found for 95 % of them. DIR gets
/// scale.csv and scale.svg, renewed after every measurement; sizes that are in scale.csv are not
/// measured again.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder experiment scale --out scale
  grasp-builder experiment scale --out scale --largest 5011872       ten times as far; takes an hour
  grasp-builder queries --out q.npy
  grasp-builder experiment scale --descriptors x.npy --queries q.npy --sizes 10000,100000
  grasp-builder experiment scale --out tests/peers --redraw          its drawing, from its table

Exit status: 0 done, 2 an error, 130 stopped by Ctrl-C.")]
struct Scale {
    /// The folder of the results; made where there is none.
    #[arg(long, value_name = "DIR", default_value = "scale")]
    out: PathBuf,
    /// Half-decade steps from 5,012 (10^3.7) up to this many entries.
    #[arg(long, value_name = "N", default_value_t = 501_188, value_parser = clap::value_parser!(u64).range(100..=100_000_000))]
    largest: u64,
    /// These numbers of entries instead; rendered ones are rounded to whole hand shapes of 5,400.
    #[arg(long, value_name = "N,...", value_delimiter = ',', conflicts_with = "largest", value_parser = clap::value_parser!(u64).range(100..=100_000_000))]
    sizes: Vec<u64>,
    /// Measure these hashes; by default all.
    #[arg(long, value_name = "NAME", value_enum, value_delimiter = ',')]
    hash: Vec<Hash>,
    /// Measure the random hash up to this many entries: it takes long for more.
    #[arg(long, value_name = "N", default_value_t = 501_188)]
    random_largest: u64,
    /// Index the first rows of this array (float32) instead of rendering.
    #[arg(long, value_name = "X.npy", requires = "queries")]
    descriptors: Option<PathBuf>,
    /// Search for the rows of this array.
    #[arg(long, value_name = "Q.npy", requires = "descriptors")]
    queries: Option<PathBuf>,
    /// What all randomness comes from.
    #[arg(long, default_value_t = DEFAULT_SEED, value_name = "N")]
    seed: u64,
    /// Measure nothing: draw scale.svg anew from the scale.csv that is there.
    #[arg(long, conflicts_with_all = ["largest", "sizes", "hash", "random_largest", "descriptors", "queries"])]
    redraw: bool,
}

/// Indexes of ever more hand shapes, to find out what these are worth.
///
/// DIR gets hands-0001.idx and so on, each with the hand shapes of the smaller ones among its own;
/// those that are up to date are not built again. The command that scores labelled pictures by them
/// is printed.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder experiment shapes --out shapes
  grasp-builder experiment shapes --out shapes --counts 1,3,10 --step 12

Exit status: 0 done, 2 an error, 130 stopped by Ctrl-C.")]
struct Shapes {
    /// The folder of the indexes; made where there is none.
    #[arg(long, value_name = "DIR", default_value = "shapes")]
    out: PathBuf,
    /// Numbers of hand shapes: the mean hand, the named ones, then hands sampled from the human
    /// range.
    #[arg(long, value_name = "N,...", value_delimiter = ',', default_value = "1,3,10,30,100", value_parser = clap::value_parser!(u32).range(1..=9999))]
    counts: Vec<u32>,
    /// What is rendered of each hand shape: `paper`, `standard` or `wide`, as for `build`.
    #[arg(long, default_value_t = Preset::Paper, value_name = "NAME", value_parser = preset(), hide_possible_values = true)]
    preset: Preset,
    /// Step between views in degrees, in azimuth and elevation.
    #[arg(long, value_name = "DEG", value_parser = parse_step, allow_negative_numbers = true)]
    step: Option<f64>,
    /// How hand images are described: `learned`, `upright`, `default` or `paper`, as for `build`.
    /// By default as `build` does for the preset.
    #[arg(long, value_name = "NAME", value_parser = crate::descriptor::NAMES)]
    descriptor: Option<String>,
    /// What all randomness comes from.
    #[arg(long, default_value_t = DEFAULT_SEED, value_name = "N")]
    seed: u64,
}

impl Experiment {
    /// Whether what was measured stays when it is stopped, so that it can be gone on with.
    pub(super) fn keeps_results(&self) -> bool {
        match self.name {
            Name::Scale(_) | Name::Shapes(_) => true,
            Name::Networks(_) => false,
        }
    }

    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        match &self.name {
            Name::Scale(scale) => scale.run(global),
            Name::Shapes(shapes) => shapes.run(global),
            Name::Networks(networks) => networks.run(global),
        }
    }
}

impl Scale {
    fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        let rows = if self.redraw { redraw(&self.out)? } else { self.measure(global)? };
        let mut stdout = std::io::stdout().lock();
        for hash in plot::hashes(&rows) {
            if let Some(law) = power_law(&plot::points(&rows, hash, |row| row.candidates)) {
                writeln!(
                    stdout,
                    "{hash}: candidates grow with N^{:.3}; the paper promises N^{PAPER_EXPONENT:.3}",
                    law.exponent
                )?;
            }
        }
        writeln!(stdout, "{}", shown(&self.out.join("scale.csv")))?;
        writeln!(stdout, "{}", shown(&self.out.join("scale.svg")))?;
        Ok(())
    }

    /// Measures what is not in the table yet.
    fn measure(&self, global: &Global) -> anyhow::Result<Vec<Row>> {
        let hashes = if self.hash.is_empty() { Hash::ALL.to_vec() } else { self.hash.clone() };
        let most = |hash| if hash == Hash::Random { self.random_largest } else { u64::MAX };
        let data = match (&self.descriptors, &self.queries) {
            (Some(descriptors), Some(queries)) => {
                Data::Files { descriptors: descriptors.clone(), queries: queries.clone() }
            }
            _ => Data::Rendered,
        };
        let sizes: BTreeSet<u64> = if self.sizes.is_empty() {
            default_sizes(self.largest.min(data.most()?))
        } else {
            self.sizes.iter().copied().collect()
        };
        let settings = Settings {
            data,
            sizes,
            hashes: hashes.into_iter().map(|hash| (hash, most(hash))).collect(),
            out: self.out.clone(),
            seed: self.seed,
        };
        run(&settings, global.progress(), &mut |row| info!("{}", line(row)))
    }
}

impl Shapes {
    fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        let mut plan = RenderPlan { seed: self.seed, ..RenderPlan::preset(self.preset) };
        if let Some(step_deg) = self.step {
            let grid = match plan.views {
                Views::Grid(grid) => ViewGrid { step_deg, ..grid },
                Views::Random(_) => {
                    ViewGrid { step_deg, elevation_deg: [-84.0, 84.0], ..ViewGrid::default() }
                }
            };
            plan.views = Views::Grid(grid);
        }
        let name = self.descriptor.as_deref().unwrap_or(PresetDefaults::of_preset(self.preset).descriptor);
        let descriptor = crate::descriptor::by_name(name, None)?;
        let counts = self.counts.iter().copied().collect();
        let seen = self.step.is_none().then(|| PlanSpec::of_preset(self.preset));
        let settings = shapes::Settings { counts, plan, seen, descriptor, out: self.out.clone() };
        let indexes = shapes::run(&settings, global.progress(), &mut |path, report| {
            let done = if report.written.is_some() { "built" } else { "is up to date" };
            let seconds = report.elapsed.as_secs_f64();
            let entries = counted(report.entries, ENTRIES);
            info!(entries = report.entries, seconds, "{} {done}: {entries}, {seconds:.1} s", shown(path));
        })?;
        let mut stdout = std::io::stdout().lock();
        write!(stdout, "grasp-query experiment shapes LABELS.csv --out {}", shown(&self.out))?;
        for index in indexes {
            write!(stdout, " --index {}", shown(&index))?;
        }
        writeln!(stdout)?;
        Ok(())
    }
}

fn line(row: &Row) -> String {
    format!(
        "{:>8}  {:>9} entries: {:>9.1} us a query, {:>9.0} candidates ({}), recall@10 {:.3}, eps-success {:.3}, \
         {:.1} MB, built in {:.1} s",
        row.hash,
        row.entries,
        row.ns_per_query / 1e3,
        row.candidates,
        percent(row.share_of_database),
        row.recall_at_10,
        row.eps_success,
        row.file_bytes as f64 / 1e6,
        row.build_s,
    )
}
