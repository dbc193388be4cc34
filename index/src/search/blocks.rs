//! Quantised vectors as they lie in the file: blocks of sixteen.
//!
//! A vector is a code for each of P axes, a *scalar* that a distance needs besides, and, where it
//! is an entry, its id. A code is a byte, of which 128 stands for 0, or half a byte, of which 8
//! does. A block holds, one after the other,
//!
//! - `P / 4` groups of 64 bytes: four axes of the first vector, the same four of the second, and so
//!   on to the sixteenth, because a processor multiplies and adds four neighbouring bytes at once;
//!   where a code is half a byte, `P / 8` groups, rounded up: eight axes of each vector, the first
//!   four in the lower halves of its four bytes, the others in the upper;
//! - sixteen f32, the scalars; infinity where there is no vector;
//! - sixteen u32, the ids, in blocks of entries alone.
//!
//! So all that a scan needs of a vector lies together, and a run of blocks is read from front to
//! back.

/// Vectors of a block.
pub(crate) const LANES: usize = 16;
/// The most axes: the largest sum of products still fits an i32.
pub(crate) const MAX_AXES: usize = 512;
/// The largest code of 8 bits, and the largest value of a quantised query.
pub(crate) const MAX_CODE: i32 = 127;
const MAX_VALUE: i32 = (1 << 14) - 1;
/// What the high half of a query's value counts.
const HALF: i32 = 128;

/// How many bits a code of a learned hash's entries has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CodeBits {
    /// Half the bytes of a scan; for entries that are measured exactly in the end.
    Four,
    /// For centres, and for entries that are known by their codes alone.
    Eight,
}

impl CodeBits {
    /// The number.
    pub fn count(self) -> u32 {
        match self {
            Self::Four => 4,
            Self::Eight => 8,
        }
    }

    /// What is added to a code so that it is not negative.
    pub(crate) const fn zero(self) -> i32 {
        match self {
            Self::Four => 8,
            Self::Eight => 128,
        }
    }

    /// The largest code; the smallest is its negative.
    pub(crate) const fn largest(self) -> i32 {
        self.zero() - 1
    }

    /// Bytes of a vector's codes.
    pub(crate) const fn bytes(self, axes: usize) -> usize {
        match self {
            Self::Four => axes.div_ceil(8) * 4,
            Self::Eight => axes,
        }
    }
}

/// A run of blocks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blocks<'a> {
    bytes: &'a [u8],
    bits: CodeBits,
    /// Bytes of the codes of a block.
    codes: usize,
    stride: usize,
    /// The number of the first block among all.
    first: u32,
    /// What is added to the ids.
    first_id: u32,
}

/// One block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block<'a> {
    pub(crate) codes: &'a [u8],
    pub(crate) scalars: &'a [f32; LANES],
    /// No id where the block holds none.
    ids: &'a [u32],
    number: u32,
    first_id: u32,
}

impl Block<'_> {
    /// The id of a vector, or its place among all vectors where the block holds no ids.
    #[inline]
    pub(crate) fn id(&self, lane: usize) -> u32 {
        match self.ids.get(lane) {
            Some(id) => id.wrapping_add(self.first_id),
            None => self.number.wrapping_mul(LANES as u32).wrapping_add(lane as u32),
        }
    }
}

/// Bytes of a block of centres.
pub(crate) const fn centre_stride(axes: usize) -> usize {
    LANES * (axes + 4)
}

/// Bytes of a block of entries.
pub(crate) const fn entry_stride(axes: usize, bits: CodeBits) -> usize {
    LANES * (bits.bytes(axes) + 8)
}

impl<'a> Blocks<'a> {
    /// Blocks of centres: no ids.
    pub(crate) fn of_centres(bytes: &'a [u8], axes: usize) -> Self {
        let bits = CodeBits::Eight;
        Self { bytes, bits, codes: LANES * axes, stride: centre_stride(axes), first: 0, first_id: 0 }
    }

    /// Blocks of entries.
    pub(crate) fn of_entries(bytes: &'a [u8], axes: usize, bits: CodeBits) -> Self {
        let (codes, stride) = (LANES * bits.bytes(axes), entry_stride(axes, bits));
        Self { bytes, bits, codes, stride, first: 0, first_id: 0 }
    }

    /// The width of the codes.
    pub(crate) fn bits(&self) -> CodeBits {
        self.bits
    }

    /// The same entries, the first of the index being number `first_id`.
    pub(crate) fn numbered_from(self, first_id: u32) -> Self {
        Self { first_id, ..self }
    }

    pub(crate) fn len(&self) -> usize {
        self.bytes.len() / self.stride
    }

    /// The blocks from `start` up to `end`; none where that makes no sense.
    pub(crate) fn run(self, start: u32, end: u32) -> Self {
        let at = |block: u32| (block as usize).checked_mul(self.stride);
        let range = at(start).zip(at(end)).and_then(|(start, end)| self.bytes.get(start..end));
        Self { bytes: range.unwrap_or(&[]), first: self.first.wrapping_add(start), ..self }
    }

    /// The number of a vector of this run: its id, or its place among all vectors where blocks hold
    /// no ids.
    #[inline]
    pub(crate) fn number(&self, at: usize) -> Option<u32> {
        let (block, lane) = (at / LANES, at % LANES);
        let first = block.checked_mul(self.stride)?;
        let bytes = self.bytes.get(first..first + self.stride)?;
        Some(self.split(bytes, self.first.wrapping_add(block as u32))?.id(lane))
    }

    /// How many vectors a run holds: only its last block has unused places.
    pub(crate) fn vectors(&self) -> u32 {
        let last = self
            .iter()
            .last()
            .map_or(0, |last| last.scalars.iter().filter(|scalar| scalar.is_finite()).count());
        (self.len().saturating_sub(1) * LANES + last) as u32
    }

    pub(crate) fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    #[inline(always)]
    pub(crate) fn iter(self) -> impl Iterator<Item = Block<'a>> {
        let numbers = (0..).map(move |at: u32| self.first.wrapping_add(at));
        self.bytes
            .chunks_exact(self.stride)
            .zip(numbers)
            .filter_map(move |(bytes, number)| self.split(bytes, number))
    }

    /// Sections start at multiples of 64 bytes and so do all parts of a block, as `axes` is a
    /// multiple of 4: the casts do not fail.
    #[inline(always)]
    fn split(&self, bytes: &'a [u8], number: u32) -> Option<Block<'a>> {
        let (codes, rest) = bytes.split_at_checked(self.codes)?;
        let (scalars, ids) = rest.split_at_checked(LANES * 4)?;
        let scalars: &[f32] = bytemuck::try_cast_slice(scalars).ok()?;
        Some(Block {
            codes,
            scalars: scalars.try_into().ok()?,
            ids: bytemuck::try_cast_slice(ids).ok()?,
            number,
            first_id: self.first_id,
        })
    }
}

/// A block of a file in the making, all zeros before its vectors are put there.
pub(crate) struct BlockMut<'a> {
    codes: &'a mut [u8],
    scalars: &'a mut [u8],
    /// None in a block of centres.
    ids: &'a mut [u8],
    bits: CodeBits,
}

impl<'a> BlockMut<'a> {
    /// The block that `bytes` are: as many as a stride.
    pub(crate) fn new(bytes: &'a mut [u8], axes: usize, bits: CodeBits) -> Self {
        let (codes, rest) = bytes.split_at_mut(LANES * bits.bytes(axes));
        let (scalars, ids) = rest.split_at_mut(LANES * 4);
        Self { codes, scalars, ids, bits }
    }

    /// Puts one vector there.
    pub(crate) fn put(&mut self, lane: usize, codes: &[i8], scalar: f32, id: Option<u32>) {
        for (axis, &code) in codes.iter().enumerate() {
            let byte = (i32::from(code) + self.bits.zero()) as u8;
            let (group, byte) = match self.bits {
                CodeBits::Four if axis / 4 % 2 == 1 => (axis / 8, byte << 4),
                CodeBits::Four => (axis / 8, byte),
                CodeBits::Eight => (axis / 4, byte),
            };
            self.codes[group * 4 * LANES + lane * 4 + axis % 4] |= byte;
        }
        self.end(lane, scalar, id);
    }

    /// Puts vector `at` of another block of such codes there, as entry `id`.
    pub(crate) fn copy(&mut self, lane: usize, from: &Block<'_>, at: usize, id: u32) {
        let groups = self.codes.chunks_exact_mut(4 * LANES).zip(from.codes.chunks_exact(4 * LANES));
        for (to, from) in groups {
            to[lane * 4..][..4].copy_from_slice(&from[at * 4..][..4]);
        }
        self.end(lane, from.scalars[at], Some(id));
    }

    /// Marks a lane that holds no vector.
    pub(crate) fn put_nothing(&mut self, lane: usize) {
        let id = (!self.ids.is_empty()).then_some(u32::MAX);
        self.end(lane, f32::INFINITY, id);
    }

    fn end(&mut self, lane: usize, scalar: f32, id: Option<u32>) {
        self.scalars[lane * 4..][..4].copy_from_slice(&scalar.to_le_bytes());
        if let Some(id) = id {
            self.ids[lane * 4..][..4].copy_from_slice(&id.to_le_bytes());
        }
    }
}

/// A coordinate as a code of `bits` in steps of which `per_unit` make a unit.
#[inline]
pub(crate) fn code(coordinate: f32, per_unit: f32, bits: CodeBits) -> i8 {
    let largest = bits.largest() as f32;
    round((coordinate * per_unit).clamp(-largest, largest)) as i8
}

/// To the nearest integer, halves upward; faster than `f32::round` where there is no instruction
/// for that, and the same everywhere. For values below 2^15 either way; of others, which only a
/// damaged file brings about, some number comes out.
#[inline]
fn round(value: f32) -> i32 {
    (value + (MAX_VALUE as f32 + 1.5)) as i32 - (MAX_VALUE + 1)
}

/// A query in the axes' frame: 15 bits a value, or the 8 of a vector of the index itself, in the
/// forms that the paths of [`super::simd`] take.
#[derive(Clone, Debug, Default)]
pub(crate) struct QuantisedQuery {
    /// The values in units of `step`, zeros up to a multiple of 8.
    pub(crate) values: Vec<i16>,
    /// The values as bytes, `HALF * high + low`: the high ones, signed.
    pub(crate) high: Vec<u8>,
    /// The low ones.
    pub(crate) low: Vec<u8>,
    /// Its values were codes of 8 bits, so that all low bytes are 0.
    pub(crate) is_of_codes: bool,
    /// The sum of the values.
    sum: i32,
    /// The length of a unit.
    pub(crate) step: f32,
}

impl QuantisedQuery {
    /// Takes the coordinates of a query.
    pub(crate) fn set(&mut self, coordinates: &[f32]) {
        // Sixteen side by side: one need not wait for the one before it.
        let mut lanes = [0.0f32; LANES];
        let (sixteens, rest) = coordinates.as_chunks::<LANES>();
        for coordinates in sixteens {
            for (largest, value) in lanes.iter_mut().zip(coordinates) {
                *largest = largest.max(value.abs());
            }
        }
        let largest = lanes.iter().chain(rest).fold(0.0f32, |largest, value| largest.max(value.abs()));
        let largest = largest.max(f32::MIN_POSITIVE * 1e6);
        let step = largest / MAX_VALUE as f32;
        let per_step = 1.0 / step;
        self.is_of_codes = false;
        self.set_values(coordinates.iter().map(|value| round(value * per_step) as i16), step);
    }

    /// Takes codes: a vector of the index as a query.
    pub(crate) fn set_codes(&mut self, codes: &[i8], step: f32) {
        self.is_of_codes = true;
        self.set_values(codes.iter().map(|&code| i16::from(code) * HALF as i16), step / HALF as f32);
    }

    fn set_values(&mut self, values: impl Iterator<Item = i16>, step: f32) {
        self.step = step;
        self.values.clear();
        self.values.extend(values);
        self.values.resize(self.values.len().next_multiple_of(8), 0);
        self.high.clear();
        self.high.extend(self.values.iter().map(|value| (value >> 7) as u8));
        self.low.clear();
        self.low.extend(self.values.iter().map(|value| (value & 127) as u8));
        self.sum = self.values.iter().map(|&value| i32::from(value)).sum();
    }

    /// What [`CodeBits::zero`] adds to every dot product with codes.
    pub(crate) fn bias(&self, bits: CodeBits) -> i32 {
        bits.zero() * self.sum
    }
}
