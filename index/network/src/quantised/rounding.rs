//! Rounding to integers, in vectors on every processor.

/// Floats of this size have no fraction bits: adding it rounds to the nearest integer, ties to
/// even, and leaves that, in two's complement, in the lowest bits.
const SIZE: f32 = 12_582_912.0;

/// The integer nearest to a value between -2^15 and 2^15.
#[inline(always)]
pub(super) fn nearest_word(value: f32) -> i16 {
    (value + SIZE).to_bits() as i16
}

/// The lowest byte of that integer, in two's complement.
#[inline(always)]
pub(super) fn nearest_byte(value: f32) -> u8 {
    (value + SIZE).to_bits() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_become_even() {
        for (value, integer) in
            [(0.0, 0), (0.49, 0), (0.5, 0), (1.5, 2), (2.5, 2), (126.51, 127), (254.5, 254)]
        {
            assert_eq!(nearest_word(value), integer);
            assert_eq!(nearest_byte(value), integer as u8);
            assert_eq!(nearest_word(-value), -integer);
            assert_eq!(nearest_byte(-value).cast_signed(), (-integer) as i8);
        }
    }
}
