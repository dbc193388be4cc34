//! `grasp-builder experiment shapes`.

use std::io::Write as _;
use std::path::PathBuf;

use grasp_program::Global;
use grasp_renders::{Preset, RenderPlan, ViewGrid, Views};
use grasp_terminal::text::{counted, shown};
use tracing::info;

use crate::cli::plan::parse_step;
use crate::cli::preset::preset;
use crate::cli::preset_defaults::PresetDefaults;
use crate::cli::report::ENTRIES;
use crate::cli::seed::DEFAULT_SEED;
use crate::experiment::shapes;
use crate::interrupt;
use crate::plan_spec::PlanSpec;

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
pub(super) struct Shapes {
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

impl Shapes {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<()> {
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
