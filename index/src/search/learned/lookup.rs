//! One query after another on its way through a learned hash.

use super::Learned;
use super::centres::Ranking;
use crate::search::blocks::QuantisedQuery;
use crate::search::effort::RECALL_K;
use crate::search::nearest::Nearest;
use crate::search::simd::{self, Simd};
use crate::search::smallest::Smallest;

/// Entries that are measured exactly besides the k that are wanted: so many times as many, and one
/// for every four buckets, because who looks into many does not want to lose a neighbour to the
/// codes' rounding. With half of k in place of twice k, forty buckets of `wide` find 0.984 in place
/// of 0.996, and more buckets cost more than the measuring.
const MORE: usize = 2;
/// More are never measured exactly, whatever k is asked for.
const MOST: usize = 1 << 30;
/// Groups of centres that are looked through, besides three for every ten buckets that are wanted.
/// One for each bucket and three find less than 0.001 more (D = 128, 103,574 and 668,869 entries)
/// in up to an eighth more of the time.
const GROUPS: u32 = 6;
/// Bytes of a bucket that are asked for ahead of their use; the processor follows by itself.
const PREFETCHED: usize = 2048;

/// A query as the hash sees it, however many buckets are looked into.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rotated {
    /// In the principal axes.
    coordinates: Vec<f32>,
    quantised: QuantisedQuery,
}

/// Looks queries up in a learned hash: [`Self::rotate`] takes a query up, [`Self::rank`] chooses
/// the buckets, [`Self::gather`] takes the best of what they hold.
#[derive(Clone, Debug)]
pub(crate) struct Lookup<'a> {
    hash: Learned<'a>,
    pub(crate) query: Rotated,
    ranking: Ranking,
    /// The nearest entries by their codes.
    found: Smallest,
    /// Their ids.
    candidates: Vec<u32>,
}

impl<'a> Lookup<'a> {
    pub(crate) fn new(hash: Learned<'a>) -> Self {
        Self {
            hash,
            query: Rotated::default(),
            ranking: Ranking::default(),
            found: Smallest::default(),
            candidates: Vec::new(),
        }
    }

    pub(crate) fn hash(&self) -> &Learned<'a> {
        &self.hash
    }

    /// Turns the query into the principal axes and quantises it.
    pub(crate) fn rotate(&mut self, simd: Simd, vector: &[f32]) {
        let Self { hash, query: Rotated { coordinates, quantised }, .. } = self;
        coordinates.resize(hash.axes.count, 0.0);
        hash.axes.project(simd, vector, coordinates);
        quantised.set(coordinates);
    }

    /// Chooses the `probes` buckets whose centres are nearest to the rotated query.
    pub(crate) fn rank(&mut self, simd: Simd, probes: u32) {
        // A damaged or hostile request may ask for more than there is.
        let probes = probes.min(self.hash.most_probes());
        let groups = GROUPS + probes.saturating_mul(3) / 10;
        self.hash.centres.rank(simd, &self.query.quantised, groups, probes, &mut self.ranking);
    }

    /// The bytes of the chosen buckets.
    pub(crate) fn parts(&self) -> impl Iterator<Item = &'a [u8]> {
        self.hash.runs(&self.ranking.buckets).map(|(_, run)| run.bytes())
    }

    /// Asks the memory for the start of each chosen bucket.
    pub(crate) fn prefetch(&self) {
        self.parts().for_each(|part| simd::prefetch_all(&part[..part.len().min(PREFETCHED)]));
    }

    /// Scans the chosen buckets and keeps of their entries those that are nearest by their codes:
    /// the `k` that are wanted, and some more.
    pub(crate) fn gather(&mut self, simd: Simd, k: usize) {
        let Self { hash, query: Rotated { quantised, .. }, ranking, found, candidates } = self;
        // What a search finds was measured with so many neighbours, and depends on how many entries
        // are measured exactly: a search for fewer measures as many.
        let k = k.max(RECALL_K);
        let more = k.saturating_mul(MORE).saturating_add(ranking.buckets.len() / 4);
        found.reset(k.saturating_add(more).min(MOST));
        let factor = 2.0 * hash.residual_scale * quantised.step;
        found.scan(simd, hash.runs(&ranking.buckets), quantised, factor);
        candidates.clear();
        candidates.extend(found.unsorted().map(|(_, id)| id));
    }

    /// How many buckets were chosen.
    pub(crate) fn buckets(&self) -> usize {
        self.ranking.buckets.len()
    }

    /// How many entries they hold.
    pub(crate) fn held(&self) -> u32 {
        self.hash.runs(&self.ranking.buckets).fold(0, |held, (_, run)| held.saturating_add(run.vectors()))
    }

    /// The entries that were kept.
    pub(crate) fn shortlist(&self) -> &[u32] {
        &self.candidates
    }

    /// How many entries are kept at most.
    pub(crate) fn keep(&self) -> usize {
        self.found.keep()
    }

    /// Each kept entry's key, by which it was kept, and its id.
    pub(crate) fn keys(&mut self) -> impl Iterator<Item = (u32, u32)> {
        self.found.keys()
    }

    /// Offers the candidates at the squared distances that their codes give. An id past the last of
    /// so many `entries`, as a damaged file may hold, has none.
    pub(crate) fn estimate(&mut self, entries: usize, nearest: &mut Nearest) {
        // The query's own square, which the scores leave out.
        let square: f32 = self.query.coordinates.iter().map(|value| value * value).sum();
        for (score, id) in self.found.unsorted().filter(|&(_, id)| (id as usize) < entries) {
            nearest.offer(id, (score + square).max(0.0));
        }
    }
}
