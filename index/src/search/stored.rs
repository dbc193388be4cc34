//! The descriptors that an index keeps, by which distances are measured.

use super::nearest::Nearest;
use super::originals::Originals;
use super::rows::Rows;
use super::simd::{self, Simd};
use half::f16;
use half::slice::HalfFloatSliceExt as _;
use half::vec::HalfFloatVecExt as _;
use std::borrow::Cow;

/// The descriptors of an index, as exactly as it keeps them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stored<'a> {
    pub(crate) dim: usize,
    pub(crate) entries: usize,
    pub(crate) values: Values<'a>,
}

/// Rows of values.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Values<'a> {
    /// As they were made.
    F32(&'a [f32]),
    /// Rounded to half the bits.
    F16(&'a [f16]),
    /// As they were made, to be rounded to half the bits when they are measured: an index that will
    /// keep them so, while it is built.
    ToBeHalved(&'a [f32]),
    /// None: an entry's distance is known by its codes alone.
    None,
    /// In several files.
    Several(&'a dyn Several),
}

/// Several files of descriptors, whose entries are numbered on from one to the next.
pub(crate) trait Several: std::fmt::Debug + Sync {
    /// The file of an entry, and its number there.
    fn locate(&self, id: u32) -> Option<(Stored<'_>, u32)>;

    /// All files, each with the number of its first entry.
    fn all(&self) -> Vec<(u32, Stored<'_>)>;
}

impl<'a> From<Rows<'a>> for Stored<'a> {
    fn from(rows: Rows<'a>) -> Self {
        Self { dim: rows.dim, entries: rows.len(), values: Values::F32(rows.values) }
    }
}

impl<'a> Stored<'a> {
    /// Rows as an index will keep them.
    pub(crate) fn of(rows: Rows<'a>, originals: Originals) -> Self {
        let values = match originals {
            Originals::F32 => Values::F32(rows.values),
            Originals::F16 => Values::ToBeHalved(rows.values),
            Originals::None => Values::None,
        };
        Self { values, ..rows.into() }
    }

    pub(crate) fn are_kept(&self) -> bool {
        !matches!(self.values, Values::None)
    }

    /// The descriptor of an entry; `None` where there is no such entry or none is kept.
    pub(crate) fn get(&self, id: u32) -> Option<Cow<'a, [f32]>> {
        match self.values {
            Values::F32(values) => row_of(values, self.dim, id).map(Cow::Borrowed),
            Values::F16(values) => row_of(values, self.dim, id).map(|row| Cow::Owned(row.to_f32_vec())),
            Values::ToBeHalved(values) => {
                row_of(values, self.dim, id).map(|row| Cow::Owned(halved(row).to_f32_vec()))
            }
            Values::None => None,
            Values::Several(several) => several.locate(id).and_then(|(stored, id)| stored.get(id)),
        }
    }

    /// The same, widened to `row` where need be.
    fn row<'r>(&self, id: u32, row: &'r mut Vec<f32>) -> Option<&'r [f32]>
    where
        'a: 'r,
    {
        match self.values {
            Values::F32(values) => row_of(values, self.dim, id),
            Values::F16(values) => {
                row.resize(self.dim, 0.0);
                row_of(values, self.dim, id)?.convert_to_f32_slice(row);
                Some(row)
            }
            Values::ToBeHalved(values) => {
                row.resize(self.dim, 0.0);
                halved(row_of(values, self.dim, id)?).convert_to_f32_slice(row);
                Some(row)
            }
            Values::None => None,
            Values::Several(several) => several.locate(id).and_then(|(stored, id)| stored.row(id, row)),
        }
    }

    /// Measures the squared distances of some entries. An id past the last entry, as a damaged file
    /// may hold, has none.
    pub(crate) fn measure(
        &self,
        simd: Simd,
        query: &[f32],
        ids: &[u32],
        row: &mut Vec<f32>,
        nearest: &mut Nearest,
    ) {
        match self.values {
            Values::F32(values) => {
                let rows = Rows { values, dim: self.dim };
                let known = ids.iter().map(|&id| rows.get(id).unwrap_or(&[]));
                simd.distances(query, known, |at, squared| {
                    if let Some(&id) = ids.get(at).filter(|&&id| (id as usize) < self.entries) {
                        nearest.offer(id, squared);
                    }
                });
            }
            Values::F16(values) => {
                let known = ids.iter().map(|&id| row_of(values, self.dim, id).unwrap_or(&[]));
                simd.distances_of_halves(query, known, row, |at, squared| {
                    if let Some(&id) = ids.get(at).filter(|&&id| (id as usize) < self.entries) {
                        nearest.offer(id, squared);
                    }
                });
            }
            Values::ToBeHalved(_) | Values::Several(_) => {
                for &id in ids {
                    if let Some(row) = self.row(id, row) {
                        simd.distances(query, [row].into_iter(), |_, squared| nearest.offer(id, squared));
                    }
                }
            }
            Values::None => {}
        }
    }

    /// The bytes of a descriptor; none where there is no such entry or none is kept.
    pub(crate) fn part(&self, id: u32) -> &'a [u8] {
        let part: Option<&[u8]> = match self.values {
            Values::F32(values) | Values::ToBeHalved(values) => {
                row_of(values, self.dim, id).map(bytemuck::cast_slice)
            }
            Values::F16(values) => row_of(values, self.dim, id).map(bytemuck::cast_slice),
            Values::None => None,
            Values::Several(several) => several.locate(id).map(|(stored, id)| stored.part(id)),
        };
        part.unwrap_or(&[])
    }

    /// Asks the memory for the descriptors that will be measured.
    pub(crate) fn prefetch(&self, ids: &[u32]) {
        // More than that would drive out each other.
        const MOST: usize = 64;
        for &id in ids.iter().take(MOST) {
            simd::prefetch_all(self.part(id));
        }
    }

    /// All entries in chunks of at most `bytes` (of values as wide as a query's; of one entry,
    /// where it has more), each with the number of its first entry: no chunk where no descriptors
    /// are kept. A chunk is of one file.
    pub(crate) fn chunks(&self, bytes: usize) -> Vec<(u32, Stored<'a>)> {
        let entries = (bytes / size_of::<f32>() / self.dim.max(1)).max(1);
        let length = entries * self.dim.max(1);
        let numbered = |(at, values): (usize, Values<'a>)| {
            let start = at * entries;
            (start as u32, Self { entries: entries.min(self.entries.saturating_sub(start)), values, ..*self })
        };
        match self.values {
            Values::F32(values) => values.chunks(length).map(Values::F32).enumerate().map(numbered).collect(),
            Values::F16(values) => values.chunks(length).map(Values::F16).enumerate().map(numbered).collect(),
            Values::ToBeHalved(values) => {
                values.chunks(length).map(Values::ToBeHalved).enumerate().map(numbered).collect()
            }
            Values::None => Vec::new(),
            Values::Several(several) => {
                let of_a_file = |(start, stored): (u32, Stored<'a>)| {
                    let chunks = stored.chunks(bytes).into_iter();
                    chunks.map(move |(first, chunk)| (start.saturating_add(first), chunk))
                };
                several.all().into_iter().flat_map(of_a_file).collect()
            }
        }
    }

    /// The values of a chunk, widened to `into` where need be.
    pub(crate) fn widened<'r>(&self, into: &'r mut Vec<f32>) -> Option<&'r [f32]>
    where
        'a: 'r,
    {
        match self.values {
            Values::F32(values) => Some(values),
            Values::F16(values) => {
                into.resize(values.len(), 0.0);
                values.convert_to_f32_slice(into);
                Some(into)
            }
            Values::ToBeHalved(values) => {
                into.resize(values.len(), 0.0);
                halved(values).convert_to_f32_slice(into);
                Some(into)
            }
            Values::None | Values::Several(_) => None,
        }
    }

    /// The bytes of a chunk as they are kept.
    pub(crate) fn bytes(&self) -> &'a [u8] {
        match self.values {
            Values::F32(values) | Values::ToBeHalved(values) => bytemuck::cast_slice(values),
            Values::F16(values) => bytemuck::cast_slice(values),
            Values::None | Values::Several(_) => &[],
        }
    }
}

/// Values rounded to half their bits, all at once.
fn halved(values: &[f32]) -> Vec<f16> {
    Vec::from_f32_slice(values)
}

fn row_of<T>(values: &[T], dim: usize, id: u32) -> Option<&[T]> {
    let start = (id as usize).checked_mul(dim)?;
    values.get(start..start.checked_add(dim)?)
}
