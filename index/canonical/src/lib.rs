//! Values as canonical bytes: what persistent keys and seeds are hashes of.
//!
//! A key must not change because a field was renamed or because a library prints numbers in another
//! way, so that nothing here goes through text. The encoding:
//!
//! - it begins with the byte [`ENCODING_VERSION`];
//! - a struct is its fields in the order in which `encode` lists them, without names or padding;
//! - an integer is little-endian in the width of its method, a length or a count is a `u64`;
//! - a floating-point number is its IEEE 754 bits, little-endian; -0.0 is normalised to 0.0 and any
//!   NaN to one quiet NaN, so that values that compare equal have the same bytes;
//! - a string is its length in bytes, then UTF-8; a sequence is its length, then its elements; an
//!   array of fixed length is its elements alone;
//! - an enum is one byte, a number that a variant keeps for ever, then the variant's fields;
//! - an option is the byte 0, or the byte 1 and the value.
//!
//! Every `encode` takes its struct apart without `..`, so that a new field does not compile until
//! somebody has decided where it stands. A change of the encoding raises [`ENCODING_VERSION`].

use nalgebra::{UnitQuaternion, Vector3};
use xxhash_rust::xxh3::xxh3_64;

/// The first byte of every encoding; rises when the same value gives other bytes than before.
pub const ENCODING_VERSION: u8 = 1;

/// A value that has a canonical encoding.
pub trait Canonical {
    /// Appends the value's bytes.
    fn encode(&self, to: &mut Encoder);
}

/// Collects the bytes of values, one after the other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Encoder {
    bytes: Vec<u8>,
}

impl Default for Encoder {
    fn default() -> Encoder {
        Encoder { bytes: vec![ENCODING_VERSION] }
    }
}

impl Encoder {
    /// An encoding of nothing but its version.
    pub fn new() -> Encoder {
        Encoder::default()
    }

    /// The bytes so far.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The XXH3 hash of the bytes so far.
    pub fn hash(&self) -> u64 {
        xxh3_64(&self.bytes)
    }

    /// Appends a byte; also an enum's number.
    pub fn u8(&mut self, value: u8) -> &mut Encoder {
        self.bytes.push(value);
        self
    }

    /// Appends an integer of 32 bits.
    pub fn u32(&mut self, value: u32) -> &mut Encoder {
        self.bytes.extend(value.to_le_bytes());
        self
    }

    /// Appends an integer of 64 bits.
    pub fn u64(&mut self, value: u64) -> &mut Encoder {
        self.bytes.extend(value.to_le_bytes());
        self
    }

    /// Appends a length or a count.
    pub fn count(&mut self, value: usize) -> &mut Encoder {
        self.u64(value as u64)
    }

    /// Appends a number.
    pub fn f64(&mut self, value: f64) -> &mut Encoder {
        // The sum turns -0.0 into 0.0.
        let value = if value.is_nan() { f64::NAN.copysign(1.0) } else { value + 0.0 };
        self.u64(value.to_bits())
    }

    /// Appends an array of fixed length, without its length.
    pub fn f64s(&mut self, values: &[f64]) -> &mut Encoder {
        values.iter().for_each(|&value| {
            self.f64(value);
        });
        self
    }

    /// Appends a string.
    pub fn text(&mut self, value: &str) -> &mut Encoder {
        self.count(value.len());
        self.bytes.extend(value.as_bytes());
        self
    }

    /// Appends a value.
    pub fn value(&mut self, value: &impl Canonical) -> &mut Encoder {
        value.encode(self);
        self
    }

    /// Appends values of which there may be any number.
    pub fn values(&mut self, values: &[impl Canonical]) -> &mut Encoder {
        self.count(values.len());
        values.iter().for_each(|value| value.encode(self));
        self
    }

    /// Appends a value that may be missing.
    pub fn option(&mut self, value: Option<&impl Canonical>) -> &mut Encoder {
        match value {
            None => self.u8(0),
            Some(value) => self.u8(1).value(value),
        }
    }
}

impl Canonical for f64 {
    fn encode(&self, to: &mut Encoder) {
        to.f64(*self);
    }
}

impl Canonical for Vector3<f64> {
    /// x, y, z.
    fn encode(&self, to: &mut Encoder) {
        to.f64s(&[self.x, self.y, self.z]);
    }
}

impl Canonical for UnitQuaternion<f64> {
    /// x, y, z, w.
    fn encode(&self, to: &mut Encoder) {
        to.f64s(&[self.i, self.j, self.k, self.w]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An enum's number.
    struct Variant(u8);

    impl Canonical for Variant {
        fn encode(&self, to: &mut Encoder) {
            to.u8(self.0);
        }
    }

    #[test]
    fn bytes_are_those_of_the_description() {
        let mut to = Encoder::new();
        to.u8(7).u32(1).count(2).f64(-0.0).f64(1.0).text("é").values(&[Variant(3)]).option(None::<&Variant>);
        to.option(Some(&Variant(2)));
        let expected = [
            &[ENCODING_VERSION, 7, 1, 0, 0, 0][..],
            &[2, 0, 0, 0, 0, 0, 0, 0],
            &[0; 8],
            &[0, 0, 0, 0, 0, 0, 0xf0, 0x3f],
            &[2, 0, 0, 0, 0, 0, 0, 0, 0xc3, 0xa9],
            &[1, 0, 0, 0, 0, 0, 0, 0, 3],
            &[0, 1, 2],
        ]
        .concat();
        assert_eq!(to.bytes(), expected);
        let nan = |value: f64| Encoder::new().f64(value).hash();
        assert_eq!(nan(f64::NAN), nan(-f64::NAN));
    }
}
