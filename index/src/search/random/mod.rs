//! The paper's hash: `T` tables, each of `K` random hyperplanes through the region where the data
//! lies. The side of each plane is a bit; the `K` bits are hashed to one of `H` buckets.

mod id_set;
pub(crate) mod lookup;
pub(crate) mod tables;
pub(crate) mod tune;

use crate::search::distance;
use crate::search::rows::Rows;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use tables::Buckets;
use xxhash_rust::xxh3::xxh3_64_with_seed;

/// The most planes of a table: the bit string is a `u64`.
pub(crate) const MAX_PLANES: u32 = 64;

/// The size of a random-hyperplane hash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RandomHash {
    /// The paper's K: hyperplanes a table, 1 to 64.
    pub planes: u32,
    /// The paper's T: tables.
    pub tables: u32,
    /// The paper's H: buckets a table.
    pub buckets: u32,
}

/// Hyperplanes as they lie in the file: `normals` holds `T * K` rows of `dim` values, `offsets`
/// their `T * K` offsets. A vector x is on the upper side of a plane where `normal . x >= offset`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RandomHyperplanes<'a> {
    pub(crate) size: RandomHash,
    pub(crate) dim: usize,
    pub(crate) normals: &'a [f32],
    pub(crate) offsets: &'a [f32],
}

impl RandomHyperplanes<'_> {
    /// Calls `each` with how far `vector` lies above each plane of `table`.
    fn margins(&self, vector: &[f32], table: u32, mut each: impl FnMut(usize, f32)) {
        let planes = self.size.planes as usize;
        let start = table as usize * planes;
        let normals = self.normals.chunks_exact(self.dim).zip(self.offsets).skip(start).take(planes);
        for (plane, (normal, offset)) in normals.enumerate() {
            each(plane, distance::dot(normal, vector) - offset);
        }
    }

    /// The paper's f: bit `k` is the side of plane `k`.
    pub(crate) fn bits(&self, vector: &[f32], table: u32) -> u64 {
        let mut bits = 0;
        self.margins(vector, table, |plane, margin| bits |= u64::from(margin >= 0.0) << plane);
        bits
    }

    /// The paper's h: the bucket, of the table's `H`, of a bit string.
    fn bucket(&self, bits: u64, table: u32) -> u32 {
        (xxh3_64_with_seed(&bits.to_le_bytes(), u64::from(table)) % u64::from(self.size.buckets.max(1)))
            as u32
    }

    /// The bucket of `table` that `vector` belongs to.
    pub(crate) fn home(&self, vector: &[f32], table: u32) -> u32 {
        self.bucket(self.bits(vector, table), table)
    }
}

/// Hyperplanes with the buckets behind them.
#[derive(Clone, Debug)]
pub(crate) struct Random<'a> {
    pub(crate) hyperplanes: RandomHyperplanes<'a>,
    /// The buckets' entries, file by file: a bucket holds those of the bucket of its number in
    /// each.
    pub(crate) files: Vec<Entries<'a>>,
}

/// The entries that the buckets hold in one file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entries<'a> {
    pub(crate) buckets: Buckets<'a>,
    pub(crate) count: usize,
    /// The number of the file's first entry among those of all files.
    pub(crate) first: u32,
}

impl Random<'_> {
    pub(crate) fn tables(&self) -> u32 {
        self.hyperplanes.size.tables
    }

    /// A table's own bucket, and those across one of its planes.
    pub(crate) fn most_probes(&self) -> u32 {
        self.hyperplanes.size.planes + 1
    }
}

/// Draws `planes` hyperplanes for each of `tables` tables: normals and offsets as
/// [`RandomHyperplanes`] has them. A table's planes depend on the rows, the seed and its own number
/// alone, and the first planes of a table do not depend on how many follow.
///
/// A plane is perpendicular to the line between two drawn rows, half-way: so it passes through the
/// region where the data lies and its direction is one in which the data varies. (A direction drawn
/// evenly from all of space mostly crosses a cloud that is flat in most of them without telling its
/// points apart.)
pub(crate) fn draw(rows: Rows<'_>, tables: u32, planes: u32, seed: u64) -> (Vec<f32>, Vec<f32>) {
    let drawn: Vec<(Vec<f32>, Vec<f32>)> = (0..tables)
        .into_par_iter()
        .map(|table| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(u64::from(table) + 1);
            let mut normals = Vec::with_capacity(planes as usize * rows.dim);
            let mut offsets = Vec::with_capacity(planes as usize);
            for _ in 0..planes {
                let row = |rng: &mut ChaCha8Rng| {
                    let at = rng.random_range(0..rows.len() as u64) as usize * rows.dim;
                    &rows.values[at..at + rows.dim]
                };
                let (a, mut b) = (row(&mut rng), row(&mut rng));
                // Equal rows have no line between them. Should all rows be equal, any plane will
                // do.
                for _ in 0..16 {
                    if a != b {
                        break;
                    }
                    b = row(&mut rng);
                }
                let normal: Vec<f32> = a.iter().zip(b).map(|(a, b)| a - b).collect();
                let middle: Vec<f32> = a.iter().zip(b).map(|(a, b)| (a + b) / 2.0).collect();
                offsets.push(distance::dot(&normal, &middle));
                normals.extend(normal);
            }
            (normals, offsets)
        })
        .collect();
    drawn.into_iter().fold(Default::default(), |(mut normals, mut offsets), (more_normals, more_offsets)| {
        normals.extend(more_normals);
        offsets.extend(more_offsets);
        (normals, offsets)
    })
}
