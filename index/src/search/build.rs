//! Making the hash of an index.

use super::effort::Measured;
use super::hash::{Hash, HashInfo};
use super::in_flight::InFlight;
use super::learned::fit::{Fitted, fit};
use super::measure::measure;
use super::nearest::Neighbour;
use super::options::SearchOptions;
use super::originals::Originals;
use super::queries::{HeldOut, QUERIES_OF_THE_VOTE, moved};
use super::random::tables::Tables;
use super::random::{self, Entries, Random, RandomHash, RandomHyperplanes, tune};
use super::rows::{Rows, Source};
use super::simd::Simd;
use super::stored::Stored;
use crate::phase::Phase;
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
    /// K and T are learned from the data: the cheapest that reach eps-success 0.95 at eps 0.05 on
    /// held-out queries.
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

/// A hash on its way into a file, and how well it searches.
#[derive(Debug)]
pub(crate) struct BuiltHash {
    pub(crate) hash: OwnedHash,
    originals: Originals,
    pub(crate) measured: Measured,
}

/// A hash and its buckets in memory.
#[derive(Debug)]
pub(crate) enum OwnedHash {
    Random { size: RandomHash, normals: Vec<f32>, offsets: Vec<f32>, tables: Tables },
    Learned(Fitted),
}

/// Makes the hash that `params` asks for and measures it. `progress` hears what is being done and
/// the share of it that is done, and stops the work by returning an error.
pub(crate) fn build<E: Send>(
    source: Source<'_>,
    originals: Originals,
    held_out: HeldOut<'_>,
    params: HashParams,
    sigma: f64,
    seed: u64,
    progress: &dyn Fn(Phase, f64) -> Result<(), E>,
) -> Result<BuiltHash, E> {
    progress(Phase::Tune, 0.0)?;
    let rows = source.rows;
    let hash = match params {
        HashParams::Learned => {
            let progress = |share| progress(Phase::Tables, share);
            OwnedHash::Learned(fit(rows, originals != Originals::None, Simd::best(), &progress)?)
        }
        HashParams::Random(params) => {
            let size = match params {
                RandomParams::Auto => {
                    tune::choose(source, held_out, sigma, seed, &|share| progress(Phase::Tune, share))?
                }
                RandomParams::Fixed { k, t, buckets } => RandomHash { planes: k, tables: t, buckets },
            };
            progress(Phase::Tables, 0.0)?;
            source.will_jump();
            let (normals, offsets) = random::draw(rows, size.tables, size.planes, seed);
            source.will_pass();
            let planes = RandomHyperplanes { size, dim: rows.dim, normals: &normals, offsets: &offsets };
            let tables = Tables::build(rows, size.tables, size.buckets, |row, table| planes.home(row, table));
            OwnedHash::Random { size, normals, offsets, tables }
        }
    };
    progress(Phase::Measure, 0.0)?;
    let stored = Stored::of(rows, originals);
    let progress = |share| progress(Phase::Measure, share);
    let measured = measure(source, stored, held_out, &hash.as_hash(rows), sigma, seed, &progress)?;
    Ok(BuiltHash { hash, originals, measured })
}

impl OwnedHash {
    fn as_hash<'a>(&'a self, rows: Rows<'a>) -> Hash<'a> {
        match self {
            Self::Learned(fitted) => Hash::Learned(fitted.as_learned()),
            Self::Random { size, normals, offsets, tables } => Hash::Random(Random {
                hyperplanes: RandomHyperplanes { size: *size, dim: rows.dim, normals, offsets },
                files: vec![Entries { buckets: tables.as_buckets(), count: rows.len(), first: 0 }],
            }),
        }
    }

    pub(crate) fn info(&self) -> HashInfo {
        match self {
            Self::Learned(fitted) => HashInfo::Learned(fitted.size),
            Self::Random { size, .. } => HashInfo::Random(*size),
        }
    }
}

impl BuiltHash {
    /// Held-out rows, moved by `noise` in units of `sigma`, each with the `k` entries that a search
    /// finds by default.
    pub(crate) fn neighbours_of_held_out(
        &self,
        source: Source<'_>,
        held_out: Rows<'_>,
        k: usize,
        noise: [f64; 2],
        sigma: f64,
        seed: u64,
    ) -> Vec<(u32, Vec<Neighbour>)> {
        let rows = source.rows;
        let hash = self.hash.as_hash(rows);
        let enough = self.measured.enough(SearchOptions::default().effort);
        let probes = enough.or(self.measured.curve.last()).map_or(1, |point| point.probes);
        let stored = Stored::of(rows, self.originals);
        let queries = moved(held_out, QUERIES_OF_THE_VOTE, noise, sigma, seed, 3);
        let find = |in_flight: &mut InFlight<'_>, (row, vector): (u32, Vec<f32>)| {
            (row, in_flight.search(stored, Simd::best(), &vector, k, probes).neighbours)
        };
        source.will_jump();
        let found = queries.into_par_iter().map_init(|| InFlight::new(&hash), find).collect();
        source.will_pass();
        found
    }
}
