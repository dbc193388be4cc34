//! What is indexed, and how: the options that `build` and `shard` have in common.

use std::collections::BTreeSet;
use std::path::PathBuf;

use anyhow::{Context as _, bail};
use clap::builder::ArgPredicate;
use grasp_index::{DescriptorModel, DescriptorParams, HashParams, Originals, RandomParams};
use grasp_renders::{Preset, RenderPlan};

use super::plan::PlanOptions;
use super::preset_defaults::PresetDefaults;
use super::seed::DEFAULT_SEED;
use crate::descriptor::{self, LEARNED, NAMES};
use crate::held_out::{Hands, HeldOut};
use crate::indexing::{Recipe, RenderSet, Source, Vectors};
use crate::same_file::is_same_file;

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
    /// Measure the search by the rows of this array, as they are: they should be like what will be
    /// searched for, and not in the index.
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

    /// Warns, before any work, of buckets that take much room, for they do so by themselves: tens
    /// of entries can make an index of gigabytes.
    fn warn_of_empty_buckets(&self, tables: u32) {
        const MUCH: f64 = 1e9;
        let bytes = f64::from(tables) * f64::from(self.buckets) * 4.0;
        if bytes >= MUCH {
            tracing::warn!(
                subject = env!("CARGO_PKG_NAME"),
                "{tables} tables of {} buckets take {:.1} GB of the memory and of the file, however few the \
                 entries are: about as many --buckets as entries are enough",
                self.buckets,
                bytes / 1e9
            );
        }
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
                self.warn_of_empty_buckets(t);
                HashParams::Random(RandomParams::Fixed { k, t, buckets: self.buckets })
            }
            ("random", ..) => HashParams::Random(RandomParams::Auto),
            (_, Some(_), _) | (_, _, Some(_)) => {
                bail!("--tables and --planes size a random hash: add --hash random, or leave them out")
            }
            _ => HashParams::Learned,
        };
        let defaults = match source {
            Source::Plan(_) => PresetDefaults::of_preset(plan.preset()),
            Source::Sets(_) | Source::Vectors(_) => PresetDefaults::of_preset(Preset::Paper),
        };
        // A random hash knows its entries by their descriptors alone.
        let kept = if self.hash == "random" { "f32" } else { defaults.originals };
        let originals = self.originals.as_deref().unwrap_or(kept);
        let originals = Originals::by_name(originals)
            .with_context(|| format!("there is no form of descriptors named {originals}"))?;
        let named = self.descriptor()?;
        let (descriptor, thumbnail_side) = match source {
            Source::Plan(_) | Source::Sets(_) => {
                let descriptor = named.map_or_else(|| self.by_name(defaults.descriptor), Ok)?;
                (descriptor, self.thumbnails.unwrap_or(defaults.thumbnail_side))
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
    /// What all randomness comes from.
    pub(super) fn seed(&self) -> u64 {
        self.seed
    }

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
