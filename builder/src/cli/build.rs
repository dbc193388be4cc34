//! `grasp-builder build`.

use std::collections::BTreeSet;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use clap::builder::ArgPredicate;
use grasp_index::{
    DescriptorModel, DescriptorParams, EPS, Effort, HashInfo, HashParams, Originals, RandomParams,
};
use grasp_program::{Global, output_file};
use grasp_renders::{Preset, RenderPlan};
use grasp_terminal::text::{counted, percent, shown};

use super::form::Form;
use super::plan::PlanOptions;
use super::seed::DEFAULT_SEED;
use crate::descriptor::{self, LEARNED, NAMES};
use crate::held_out::{Hands, HeldOut};
use crate::indexing::{Recipe, RenderSet, Report, Source, Vectors, build};
use crate::interrupt;
use crate::same_file::is_same_file;

/// Build an index from render sets, straight from hand shapes, or from vectors that were described
/// elsewhere.
///
/// RENDERS are folders with a manifest.csv, as `grasp-builder render` or any other program wrote
/// them. Without RENDERS the views are rendered on the fly. An existing index at FILE gives what it
/// knows of the same pictures, and is replaced in one step when the new one is whole; a program
/// that has it mapped goes on undisturbed.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder build --out grasp.idx                       the default: any hand, from any side
  grasp-builder build --preset paper --out paper.idx        the paper's 6 x 900 views of one hand
  grasp-builder build --hands 30 --rolls 12 --step 12 --out many.idx
  grasp-builder render --out renders
  grasp-builder build renders --out grasp.idx --descriptor paper
  grasp-builder build --descriptors x.npy --labels y.csv --out vectors.idx

Exit status: 0 done, 2 an error, 130 stopped by Ctrl-C.")]
pub(crate) struct Build {
    /// The index to write.
    #[arg(long, value_name = "FILE", default_value = "grasp.idx", value_parser = output_file())]
    out: PathBuf,
    #[command(flatten)]
    work: WorkOptions,
}

/// What to index, and how: what `build` and `shard` have in common.
#[derive(Debug, clap::Args)]
pub(super) struct WorkOptions {
    /// Render sets to index; none renders on the fly.
    #[arg(value_name = "RENDERS", conflicts_with_all = ["descriptors", "preset", "hands", "hand_shape", "hand_model", "stage", "step", "elevations", "rolls", "views", "examples", "distance", "forearm", "light_variation", "distance_variation"])]
    renders: Vec<PathBuf>,
    /// What all randomness comes from.
    #[arg(long, default_value_t = DEFAULT_SEED, value_name = "N")]
    seed: u64,
    #[command(flatten)]
    vectors: VectorOptions,
    #[command(flatten)]
    index: IndexOptions,
    #[command(flatten)]
    plan: PlanOptions,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Vectors in place of pictures")]
struct VectorOptions {
    /// Index the rows of this array: 32-bit floating-point numbers in NumPy's format, of any length
    /// of row.
    #[arg(long, value_name = "X.npy", conflicts_with_all = ["preset", "hands", "hand_shape", "hand_model", "stage", "step", "elevations", "rolls", "views", "examples", "distance", "forearm", "light_variation", "distance_variation", "thumbnails"])]
    descriptors: Option<PathBuf>,
    /// What the rows are, a line each: a table with the column `grasp` and any of `file`,
    /// `cutkosky`, `stage`, `hand`, `hand_shape`, `object`, `azimuth`, `elevation`, `roll`, `qx`,
    /// `qy`, `qz`, `qw`. Without it the index can be searched, but recognises nothing.
    #[arg(long, value_name = "Y.csv", requires = "descriptors")]
    labels: Option<PathBuf>,
    /// Measure the search by the rows of this array, which are like what will be searched for and
    /// not in the index.
    #[arg(long, value_name = "Q.npy", requires = "descriptors")]
    held_out: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "What to make of it")]
struct IndexOptions {
    /// How hand images are described: `learned`, by a network, of hands turned upright (the default
    /// of `--preset standard` and `wide`); `upright`, by gradients, of hands turned upright;
    /// `default`, by gradients, of hands as they are; or `paper` for the paper's own form. With
    /// --descriptors, how the rows were made: `raw` (in some other way), unless this is given.
    #[arg(long, value_name = "NAME", value_parser = NAMES)]
    descriptor: Option<String>,
    /// The network of a learned descriptor, as `train` writes it; by default the one that comes
    /// with this program.
    #[arg(long, value_name = "FILE")]
    network: Option<PathBuf>,
    /// How entries are hashed into buckets: by hyperplanes `learned` from them, or by `random` ones
    /// as in the paper.
    #[arg(long, default_value = "learned", default_value_if("tables", ArgPredicate::IsPresent, "random"), value_name = "NAME", value_parser = ["learned", "random"])]
    hash: String,
    /// Tables of a random hash (the paper's T); by default chosen by the data, together with
    /// --planes.
    #[arg(long, value_name = "T", requires = "planes", value_parser = clap::value_parser!(u32).range(1..=1024))]
    tables: Option<u32>,
    /// Hyperplanes per table (the paper's K).
    #[arg(long, value_name = "K", requires = "tables", value_parser = clap::value_parser!(u32).range(1..=64))]
    planes: Option<u32>,
    /// Buckets a table (the paper's H), for --tables and --planes.
    #[arg(long, value_name = "H", default_value_t = 4096, requires = "tables", value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    buckets: u32,
    /// Which form of the descriptors to keep for exact distances: as they are (`f32`), in half the
    /// space (`f16`; the default of `--preset standard` and `wide`, but for a random hash), or
    /// none.
    #[arg(long, value_name = "FORM", value_parser = Originals::ALL.map(Originals::name))]
    originals: Option<String>,
    /// Side of the pictures that the index keeps for showing neighbours, in pixels; 0 keeps none.
    /// By default 48 for pictures of render sets and `--preset paper`, 20 for the larger presets.
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(0..=1024))]
    thumbnails: Option<u32>,
}

impl IndexOptions {
    /// How the descriptors are made, `None` where no name was given.
    fn descriptor(&self) -> anyhow::Result<Option<DescriptorModel>> {
        self.descriptor.as_deref().map(|name| self.by_name(name)).transpose()
    }

    fn by_name(&self, name: &str) -> anyhow::Result<DescriptorModel> {
        if name != LEARNED && self.network.is_some() {
            bail!("--network is that of a learned descriptor: add --descriptor learned");
        }
        descriptor::by_name(name, self.network.as_deref())
    }

    fn recipe(
        &self,
        source: &Source,
        held_out: HeldOut,
        plan: &PlanOptions,
        seed: u64,
    ) -> anyhow::Result<Recipe> {
        let hash = match (self.hash.as_str(), self.planes, self.tables) {
            ("random", Some(k), Some(t)) => {
                HashParams::Random(RandomParams::Fixed { k, t, buckets: self.buckets })
            }
            ("random", ..) => HashParams::Random(RandomParams::Auto),
            (_, Some(_), _) | (_, _, Some(_)) => {
                bail!("--tables and --planes size a random hash: add --hash random, or leave them out")
            }
            _ => HashParams::Learned,
        };
        let form = match source {
            Source::Plan(_) => Form::of_preset(plan.preset()),
            Source::Sets(_) | Source::Vectors(_) => Form::of_preset(Preset::Paper),
        };
        // A random hash knows its entries by their descriptors alone.
        let kept = if self.hash == "random" { "f32" } else { form.originals };
        let originals = self.originals.as_deref().unwrap_or(kept);
        let originals = Originals::by_name(originals)
            .with_context(|| format!("there is no form of descriptors named {originals}"))?;
        let named = self.descriptor()?;
        let (descriptor, thumbnail_side) = match source {
            Source::Plan(_) | Source::Sets(_) => {
                let descriptor = named.map_or_else(|| self.by_name(form.descriptor), Ok)?;
                (descriptor, self.thumbnails.unwrap_or(form.thumbnail_side))
            }
            Source::Vectors(_) if self.network.is_some() && named.is_none() => {
                bail!(
                    "--network describes pictures: leave it out, or name what made these rows by --descriptor learned"
                );
            }
            Source::Vectors(vectors) => {
                let raw = || DescriptorModel::new(DescriptorParams::raw(vectors.dim()));
                let descriptor = named.map_or_else(raw, Ok)?;
                let params = descriptor.params();
                if params.dim() != vectors.dim() as usize {
                    bail!(
                        "the rows have {} values, and those of the descriptor `{}` have {}: leave --descriptor out",
                        vectors.dim(),
                        params.name(),
                        params.dim()
                    );
                }
                (descriptor, 0)
            }
        };
        let seen = matches!(held_out, HeldOut::Rendered(_)).then(|| plan.spec()).transpose()?;
        Ok(Recipe { descriptor, hash, originals, held_out, seen, thumbnail_side, seed })
    }
}

impl WorkOptions {
    fn source(&self) -> anyhow::Result<(Source, HeldOut)> {
        let seed = self.seed;
        let held_out = |plan: &RenderPlan, known: &[String]| {
            HeldOut::Rendered(Box::new(Hands::of_a_build(plan, known, seed)))
        };
        if let Some(path) = &self.vectors.descriptors {
            let labels = self.vectors.labels.as_deref();
            let vectors = Vectors::open(path, labels, &self.plan.grasps()?)?;
            let held_out = self.vectors.held_out.clone().map_or(HeldOut::Nothing, HeldOut::File);
            return Ok((Source::Vectors(Box::new(vectors)), held_out));
        }
        let plan = self.plan().plan(seed)?;
        if self.renders.is_empty() {
            let held_out = held_out(&plan, &[]);
            return Ok((Source::Plan(Box::new(plan)), held_out));
        }
        for (at, folder) in self.renders.iter().enumerate() {
            if self.renders[..at].iter().any(|before| is_same_file(before, folder)) {
                bail!("{} is named twice: each of its pictures would be indexed twice", folder.display());
            }
        }
        let grasps = self.plan.grasps()?;
        let sets: Vec<RenderSet> =
            self.renders.iter().map(|folder| RenderSet::open(folder, &grasps)).collect::<Result<_, _>>()?;
        let known: BTreeSet<&str> = sets.iter().flat_map(RenderSet::hand_shapes).collect();
        let known: Vec<String> = known.into_iter().map(str::to_owned).collect();
        Ok((Source::Sets(sets), held_out(&plan, &known)))
    }

    /// Which renders to make. Render sets may show anything: the search is measured on hands seen
    /// as in the paper.
    fn plan(&self) -> PlanOptions {
        let plan = self.plan.clone();
        if self.renders.is_empty() { plan } else { plan.otherwise(Preset::Paper) }
    }

    /// The source and the recipe that the options describe.
    pub(super) fn work(&self) -> anyhow::Result<(Source, Recipe)> {
        let (source, held_out) = self.source()?;
        let recipe = self.index.recipe(&source, held_out, &self.plan(), self.seed)?;
        if source.is_empty() {
            bail!("the render sets hold no picture");
        }
        Ok((source, recipe))
    }
}

impl Build {
    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        let (source, recipe) = self.work.work()?;
        let report = build(&source, &recipe, &self.out, global.progress())?;
        let pictures = !matches!(source, Source::Vectors(_));
        print_report(&self.out, &report, pictures)?;
        if report.written.is_some() {
            writeln!(std::io::stdout().lock(), "  seed {}", self.work.seed)?;
        }
        Ok(())
    }
}

impl Build {
    /// What is kept when the build is stopped, and how to build so that more is.
    pub(super) fn when_stopped(&self) -> String {
        let out = shown(&self.out);
        let left = if self.out.exists() { "is as it was" } else { "is not written" };
        format!(
            "nothing of this build is kept, and {out} {left}.\nBuilt in parts, finished parts are kept: run `grasp-builder shard \
             --shard I/12 --out parts` with the other options\nof this build for I = 1 to 12, and after Ctrl-C again for those \
             that are missing; then `grasp-builder merge parts --out {out}`"
        )
    }
}

/// What an index holds, in the singular and the plural.
pub(super) const ENTRIES: [&str; 2] = ["entry", "entries"];

/// Prints for a person what came of a build.
pub(super) fn print_report(out: &Path, report: &Report, pictures: bool) -> anyhow::Result<()> {
    let mut stdout = std::io::stdout().lock();
    let (out, seconds) = (shown(out), report.elapsed.as_secs_f64());
    let Some(summary) = &report.written else {
        let entries = counted(report.entries, ENTRIES);
        writeln!(stdout, "{out} is up to date: {entries}, checked in {seconds:.2} s")?;
        return Ok(());
    };
    write!(
        stdout,
        "{out}: {}, {:.1} MB, in {seconds:.2} s",
        counted(summary.entries, ENTRIES),
        summary.bytes as f64 / 1e6
    )?;
    if pictures {
        let described = report.entries - report.reused;
        writeln!(stdout, " ({} reused, {described} described)", report.reused)?;
    } else {
        writeln!(stdout)?;
    }
    if report.without_hand > 0 {
        let views =
            counted(report.without_hand, ["view shows no hand and was", "views show no hand and were"]);
        writeln!(stdout, "  {views} left out")?;
    }
    match summary.hash {
        HashInfo::Random(hash) => {
            writeln!(
                stdout,
                "  hash: T = {} of K = {}",
                counted(hash.tables, ["table", "tables"]),
                counted(hash.planes, ["random hyperplane", "random hyperplanes"])
            )?;
        }
        HashInfo::Learned(hash) => {
            let planes = counted(hash.planes, ["learned hyperplane", "learned hyperplanes"]);
            writeln!(stdout, "  hash: K = {planes}")?;
        }
        _ => {}
    }
    if let Some(point) = summary.measured.enough(Effort::Recall(0.95)) {
        writeln!(
            stdout,
            "  for {} of {} a search finds {} of the 10 nearest entries, an entry within {} of the nearest for {} of \
             the queries, and looks at {} of the index",
            counted(summary.measured.queries, ["query", "queries"]),
            if summary.measured.held_out {
                "other hands"
            } else {
                "its own entries, each left out for its own,"
            },
            percent(point.recall_at_10),
            format_args!("{:.0} %", 100.0 * EPS),
            percent(point.success()),
            percent(point.share_of_database),
        )?;
    }
    Ok(())
}
