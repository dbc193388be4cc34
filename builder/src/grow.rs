//! Indexes that change: entries are added to what there is, removed from it, or several indexes
//! become one.
//!
//! What was described once is taken over; only the hash is made anew, which takes seconds for half
//! a million entries. So the answers are those of an index that is built of the same entries from
//! nothing, but for the rounding of descriptors that are kept in 16 bits.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context as _, bail};
use grasp_index::{
    AtomicFile, Catalogue, ClassInfo, EntryError, HashInfo, HashParams, Index, NewEntry, Originals,
    RandomParams,
};
use grasp_renders::RenderPlan;
use grasp_terminal::Progress;
use xxhash_rust::xxh3::xxh3_64;

use crate::held_out::{Hands, HeldOut};
use crate::indexing::{Described, Gathered, INPUTS, Known, Names, OPTIONS, Recipe, Report, Source, tool};
use crate::interrupt;
use crate::open_sound::open_sound;
use crate::plan_spec::PlanSpec;

/// Entries that are handed on at a time.
const ENTRIES_AT_ONCE: u32 = 1 << 10;

/// What an index is to be made of.
#[derive(Debug)]
pub struct Growth {
    /// The indexes whose entries it has, in this order. They are alike in how their entries are
    /// described and what they keep.
    pub indexes: Vec<PathBuf>,
    /// Whether their entries go in, or only the parameters of the first are taken.
    pub keep: bool,
    /// Hand shapes whose entries are left out.
    pub without: Vec<String>,
    /// Renders that come after them.
    pub more: Option<Source>,
    /// How the held-out hands that the index is measured by are posed and viewed.
    pub plan: RenderPlan,
    /// What the index keeps of this plan.
    pub spec: PlanSpec,
}

/// Makes the index `out`, which may be one of those that it is made of.
///
/// # Errors
/// When an index is damaged or unlike the first, a picture cannot be read, nothing is left, or
/// `out` cannot be written; the file at `out` is then as it was.
/// [`Interrupted`](crate::interrupt::Interrupted) when the user asked to stop.
pub fn grow(growth: &Growth, out: &Path, progress: Progress) -> anyhow::Result<Report> {
    let started = Instant::now();
    let file = AtomicFile::create(out)?;
    let indexes: Vec<Index> = growth.indexes.iter().map(|path| open(path)).collect::<Result<_, _>>()?;
    let Some(first) = indexes.first() else { bail!("no index is named") };
    for (index, path) in indexes.iter().zip(&growth.indexes) {
        if let Some(what) = unlike(first.catalogue(), index.catalogue()) {
            bail!("{} differs from the first index in {what}: build one of them again", path.display());
        }
    }
    let kept = if growth.keep { &indexes[..] } else { &[] };
    let names = names(first.catalogue(), kept, growth)?;
    let recipe = recipe(first, growth, &names);
    let origin = origin(kept, growth, &recipe)?;
    let mut gathered = Gathered::new(file, recipe.params(&names), origin)?;
    let mut there = HashSet::new();
    // What a segment is to hold is what none of the indexes has.
    for (index, path) in indexes.iter().zip(&growth.indexes).filter(|_| !growth.keep) {
        let read = || identities(index).collect::<Result<Vec<_>, _>>();
        there.extend(read().with_context(|| format!("cannot use {}", path.display()))?);
    }
    let bar = progress.bar(kept.iter().map(|index| index.len() as u64).sum(), "taking over", "entries");
    for (index, path) in kept.iter().zip(&growth.indexes) {
        let numbers = Numbers::new(index.catalogue(), &names);
        let ids: Vec<u32> = (0..index.len() as u32).collect();
        for ids in ids.chunks(ENTRIES_AT_ONCE as usize) {
            interrupt::check()?;
            let mut batch: Vec<Described> = Vec::with_capacity(ids.len());
            for &id in ids {
                let entry = index.new_entry(id).with_context(|| format!("cannot use {}", path.display()))?;
                // Entries of hand shapes that are left out have no number.
                if let Some(entry) = numbers.renumbered(entry) {
                    there.insert(identity(&entry.file, entry.source_hash));
                    batch.push(Some((entry, true)));
                }
            }
            gathered.take(batch)?;
            bar.inc(ids.len() as u64);
        }
        index.check_unchanged().with_context(|| format!("cannot use {}", path.display()))?;
    }
    drop(bar);
    if let Some(source) = &growth.more {
        let bar = progress.bar(source.len() as u64, "describing", "views");
        let (mut added, mut known) = (0, 0);
        let mut take = |mut batch: Vec<Described>| -> anyhow::Result<()> {
            bar.inc(batch.len() as u64);
            interrupt::check()?;
            let mut is_new = |entry: &NewEntry| there.insert(identity(&entry.file, entry.source_hash));
            let before = batch.len();
            batch.retain(|described| described.as_ref().is_none_or(|(entry, _)| is_new(entry)));
            known += before - batch.len();
            added += batch.iter().flatten().count();
            gathered.take(batch)
        };
        source.describe(&names, &recipe, &Known::nothing(), 0..source.pieces(), &mut take)?;
        drop(bar);
        if !growth.keep && added == 0 && known > 0 {
            bail!("the index holds all of these pictures: there is nothing for a segment of its own");
        }
    }
    let report = gathered.finish(&Known::nothing(), || recipe.held_out_rows(&names), progress)?;
    Ok(Report { elapsed: started.elapsed(), ..report })
}

fn open(path: &Path) -> anyhow::Result<Index> {
    let index = open_sound(path)?;
    if index.catalogue().originals == Originals::None {
        bail!("{} keeps no descriptors to take over: build it with --originals f32 or f16", path.display());
    }
    Ok(index)
}

/// What keeps two indexes from becoming one.
fn unlike(one: &Catalogue, other: &Catalogue) -> Option<&'static str> {
    let same_hash = matches!(
        (&one.hash, &other.hash),
        (HashInfo::Learned(_), HashInfo::Learned(_)) | (HashInfo::Random(_), HashInfo::Random(_))
    );
    [
        (one.descriptor_fingerprint == other.descriptor_fingerprint, "how pictures are described"),
        (one.originals == other.originals, "the form of the descriptors that it keeps (--originals)"),
        (one.kept == other.kept, "what it keeps of each entry"),
        (one.thumbnail_side == other.thumbnail_side, "the size of its thumbnails (--thumbnails)"),
        (same_hash, "its hash (--hash)"),
    ]
    .into_iter()
    .find_map(|(is_same, what)| (!is_same).then_some(what))
}

/// The names of everything that goes in, in the order of a build of the same indexes. Stages and
/// classes stay, whether or not an entry that is kept still has them.
fn names(first: &Catalogue, indexes: &[Index], growth: &Growth) -> anyhow::Result<Names> {
    let mut names = Names { kept: first.kept, ..Names::default() };
    let known = || indexes.iter().flat_map(|index| &index.catalogue().hand_shapes);
    if let Some(name) = growth.without.iter().find(|name| !known().any(|hand| hand == *name)) {
        bail!(
            "there is no hand shape {name} in the index: `grasp-builder inspect` lists those that it holds"
        );
    }
    for catalogue in indexes.iter().map(Index::catalogue) {
        for hand in catalogue.hand_shapes.iter().filter(|hand| !growth.without.contains(hand)) {
            names.add_hand_shape(hand)?;
        }
        catalogue.stages.iter().try_for_each(|stage| names.add_stage(stage))?;
        names.classes.extend_from_slice(&catalogue.classes);
    }
    if let Some(source) = &growth.more {
        if !first.descriptor.describes_pictures() || !first.kept.labels {
            bail!(
                "pictures cannot be added to an index of vectors without labels, or of vectors that this program did not compute"
            );
        }
        let more = source.names()?;
        more.hand_shapes.names.iter().try_for_each(|hand| names.add_hand_shape(hand))?;
        more.stages.names.iter().try_for_each(|stage| names.add_stage(stage))?;
        names.classes.extend(more.classes);
    }
    if first.kept.labels && names.hand_shapes.names.is_empty() {
        bail!("no hand shape would be left: there is nothing to index");
    }
    names.sort_classes();
    names.classes.dedup();
    let mut seen = HashSet::new();
    if let Some(class) = names.classes.iter().find(|class| !seen.insert(&class.name)) {
        bail!("the grasp {} has two numbers: give it the same one everywhere", class.name);
    }
    // In the order of the numbers; 0 is none. What an index tells apart it goes on to.
    let are_together = |one: &ClassInfo, other: &ClassInfo| {
        let has = |index: &Index, class: &ClassInfo| index.catalogue().classes.contains(class);
        indexes.iter().any(|index| has(index, one) && has(index, other))
    };
    for (one, other) in names.classes.iter().zip(names.classes.iter().skip(1)) {
        if one.cutkosky == other.cutkosky && one.cutkosky > 0 && !are_together(one, other) {
            bail!("{} and {} have the same number: give each grasp its own", one.name, other.name);
        }
    }
    Ok(names)
}

fn recipe(index: &Index, growth: &Growth, names: &Names) -> Recipe {
    let first = index.catalogue();
    let held_out = if first.descriptor.describes_pictures() {
        let plan = RenderPlan { seed: first.seed, ..growth.plan.clone() };
        let hands = Hands::of_a_build(&plan, &names.hand_shapes.names, first.seed);
        HeldOut::Rendered(Box::new(hands))
    } else {
        HeldOut::Nothing
    };
    Recipe {
        descriptor: index.descriptor_model(),
        hash: match first.hash {
            HashInfo::Random(hash) => HashParams::Random(RandomParams::Fixed {
                k: hash.planes,
                t: hash.tables,
                buckets: hash.buckets,
            }),
            _ => HashParams::Learned,
        },
        originals: first.originals,
        seen: matches!(held_out, HeldOut::Rendered(_)).then(|| growth.spec.clone()),
        held_out,
        thumbnail_side: first.thumbnail_side,
        seed: first.seed,
    }
}

/// Where the index comes from: what the others say of themselves, and what is done here.
fn origin(indexes: &[Index], growth: &Growth, recipe: &Recipe) -> anyhow::Result<Vec<(String, String)>> {
    let own = [INPUTS, OPTIONS, "tool", "held out"];
    let mut origin = vec![tool()];
    let of_the_others = indexes.iter().flat_map(|index| &index.catalogue().provenance);
    origin.extend(of_the_others.filter(|(key, _)| !own.contains(&key.as_str())).cloned());
    if !growth.without.is_empty() {
        origin.push(("removed hand shapes".to_owned(), growth.without.join(", ")));
    }
    if let Some(source) = &growth.more {
        origin.extend(source.origin(recipe)?.into_iter().filter(|(key, _)| !own.contains(&key.as_str())));
    }
    origin.extend(recipe.seen.as_ref().map(|seen| (OPTIONS.to_owned(), seen.to_string())));
    origin.extend(recipe.held_out.provenance()?.map(|held_out| ("held out".to_owned(), held_out)));
    Ok(origin)
}

/// What the numbers of one index are in another; nothing for what is left out.
struct Numbers {
    classes: Vec<Option<u16>>,
    hand_shapes: Vec<Option<u16>>,
    stages: Vec<Option<u8>>,
    /// Entries without labels have no numbers, and all stay.
    are_kept: bool,
}

impl Numbers {
    fn new(from: &Catalogue, to: &Names) -> Self {
        Self {
            classes: from.classes.iter().map(|class| to.class(&class.name).ok()).collect(),
            hand_shapes: from.hand_shapes.iter().map(|hand| to.hand_shape(hand).ok()).collect(),
            stages: from.stages.iter().map(|stage| to.stage(stage).ok()).collect(),
            are_kept: from.kept.labels,
        }
    }

    fn renumbered(&self, entry: NewEntry) -> Option<NewEntry> {
        if !self.are_kept {
            return Some(entry);
        }
        Some(NewEntry {
            class: (*self.classes.get(usize::from(entry.class))?)?,
            hand_shape: (*self.hand_shapes.get(usize::from(entry.hand_shape))?)?,
            stage: (*self.stages.get(usize::from(entry.stage))?)?,
            ..entry
        })
    }
}

/// The same for the same picture under the same name.
type Identity = (u64, u64);

fn identity(file: &str, source_hash: u64) -> Identity {
    (xxh3_64(file.as_bytes()), source_hash)
}

/// Those of all entries of an index.
fn identities(index: &Index) -> impl Iterator<Item = Result<Identity, EntryError>> {
    let hashes = index.source_hashes();
    (0..index.len() as u32).map(move |id| {
        let hash = hashes.get(id as usize).copied().unwrap_or_default();
        Ok(identity(&index.entry(id)?.file, hash))
    })
}
