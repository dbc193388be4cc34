//! Making the hash of an index.

use super::effort::Measured;
use super::learned::fit::{Fitted, fit};
use super::measure::{self, QUERIES_OF_THE_VOTE};
use super::random::tables::Tables;
use super::random::{self, Random, RandomHash, RandomHyperplanes, tune};
use super::searcher::{Scratch, hashed};
use super::simd::Simd;
use super::stored::{Stored, Values};
use super::{Hash, Neighbour, Rows, SearchOptions, Source};
use crate::file::catalogue::HashInfo;
use crate::file::sections::SectionKind;
use rayon::prelude::*;

/// Which hash an index gets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HashParams {
    /// Hyperplanes fitted to the data.
    #[default]
    Learned,
    /// The paper's random hyperplanes.
    Random(RandomParams),
}

/// How a random hash is sized.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RandomParams {
    /// K and T are learned from the data: the cheapest that reach eps-success 0.95 at eps 0.05 on held-out queries.
    #[default]
    Auto,
    /// K, T and H as given.
    Fixed {
        /// The paper's K: hyperplanes a table, 1 to 64.
        k: u32,
        /// The paper's T: tables, 1 to 1024.
        t: u32,
        /// The paper's H: buckets a table, 1 to 2^20.
        buckets: u32,
    },
}

/// What is being done, told with the share of it that is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    Tune,
    Fill,
    Measure,
}

/// A hash on its way into a file.
#[derive(Debug)]
pub(crate) struct Built {
    table: Table,
    keeps_descriptors: bool,
    pub(crate) measured: Measured,
}

#[derive(Debug)]
enum Table {
    Random { size: RandomHash, normals: Vec<f32>, offsets: Vec<f32>, tables: Tables },
    Learned(Fitted),
}

/// Makes the hash that `params` asks for and measures it. `step` stops the work by returning an error.
pub(crate) fn build<E: Send>(
    source: Source<'_>,
    keeps_descriptors: bool,
    held_out: Rows<'_>,
    params: HashParams,
    sigma: f64,
    seed: u64,
    step: &dyn Fn(Step, f64) -> Result<(), E>,
) -> Result<Built, E> {
    step(Step::Tune, 0.0)?;
    let rows = source.rows;
    let table = match params {
        HashParams::Learned => Table::Learned(fit(rows, Simd::best(), &|share| step(Step::Fill, share))?),
        HashParams::Random(params) => {
            let size = match params {
                RandomParams::Auto => {
                    tune::choose(source, held_out, sigma, seed, &|share| step(Step::Tune, share))?
                }
                RandomParams::Fixed { k, t, buckets } => RandomHash { planes: k, tables: t, buckets },
            };
            step(Step::Fill, 0.0)?;
            source.file.will_jump();
            let (normals, offsets) = random::draw(rows, size.tables, size.planes, seed);
            source.file.will_pass();
            let hash = RandomHyperplanes { size, dim: rows.dim, normals: &normals, offsets: &offsets };
            let tables = Tables::build(rows, size.tables, size.buckets, |row, table| hash.home(row, table));
            Table::Random { size, normals, offsets, tables }
        }
    };
    step(Step::Measure, 0.0)?;
    let stored = stored(rows, keeps_descriptors);
    let go_on = |share| step(Step::Measure, share);
    let measured = measure::measure(source, stored, held_out, &*table.hash(rows), sigma, seed, &go_on)?;
    Ok(Built { table, keeps_descriptors, measured })
}

/// Rounded to 16 bits, descriptors find what they find as they are.
fn stored(rows: Rows<'_>, keeps_descriptors: bool) -> Stored<'_> {
    let values = if keeps_descriptors { Values::F32(rows.values) } else { Values::None };
    Stored { values, ..rows.into() }
}

impl Table {
    fn hash<'a>(&'a self, rows: Rows<'a>) -> Box<dyn Hash + 'a> {
        match self {
            Self::Learned(fitted) => Box::new(fitted.as_learned()),
            Self::Random { size, normals, offsets, tables } => Box::new(Random {
                hyperplanes: RandomHyperplanes { size: *size, dim: rows.dim, normals, offsets },
                buckets: tables.as_buckets(),
                entries: rows.len(),
            }),
        }
    }
}

impl Built {
    pub(crate) fn info(&self) -> HashInfo {
        match &self.table {
            Table::Learned(fitted) => HashInfo::Learned(fitted.size),
            Table::Random { size, .. } => HashInfo::Random(*size),
        }
    }

    /// Held-out rows, moved by `noise` in units of `sigma`, each with the `k` entries that a search finds by default.
    pub(crate) fn ask(
        &self,
        source: Source<'_>,
        held_out: Rows<'_>,
        k: usize,
        noise: [f64; 2],
        sigma: f64,
        seed: u64,
    ) -> Vec<(u32, Vec<Neighbour>)> {
        let rows = source.rows;
        let hash = self.table.hash(rows);
        let enough = self.measured.enough(SearchOptions::default().effort);
        let probes = enough.or(self.measured.curve.last()).map_or(1, |point| point.probes);
        let stored = stored(rows, self.keeps_descriptors);
        let queries = measure::moved(held_out, QUERIES_OF_THE_VOTE, noise, sigma, seed, 3);
        let find = |scratch: &mut Scratch, (row, vector): (u32, Vec<f32>)| {
            (row, hashed(stored, &*hash, Simd::best(), &vector, k, probes, scratch).neighbours)
        };
        source.file.will_jump();
        let found = queries.into_par_iter().map_init(Scratch::default, find).collect();
        source.file.will_pass();
        found
    }

    /// The bytes of one of the hash's sections; none for a section that is another's.
    pub(crate) fn section(&self, kind: SectionKind) -> &[u8] {
        match (&self.table, kind) {
            (Table::Random { normals, .. }, SectionKind::PlaneNormals) => bytemuck::cast_slice(normals),
            (Table::Random { offsets, .. }, SectionKind::PlaneOffsets) => bytemuck::cast_slice(offsets),
            (Table::Random { tables, .. }, SectionKind::BucketDirectory) => {
                bytemuck::cast_slice(&tables.directory)
            }
            (Table::Random { tables, .. }, SectionKind::BucketIds) => bytemuck::cast_slice(&tables.ids),
            (Table::Learned(fitted), SectionKind::Axes) => bytemuck::cast_slice(&fitted.axes.projection),
            (Table::Learned(fitted), SectionKind::GroupCentres) => &fitted.groups,
            (Table::Learned(fitted), SectionKind::GroupDirectory) => {
                bytemuck::cast_slice(&fitted.group_directory)
            }
            (Table::Learned(fitted), SectionKind::BucketCentres) => &fitted.centres,
            (Table::Learned(fitted), SectionKind::BucketDirectory) => {
                bytemuck::cast_slice(&fitted.bucket_directory)
            }
            (Table::Learned(fitted), SectionKind::EntryBlocks) => &fitted.entries,
            _ => &[],
        }
    }
}
