//! Random numbers by counter: the same whatever thread asks, and in whatever order.

/// Mixes the bits of a number (the finaliser of SplitMix64, Steele et al. 2014).
fn mix(mut value: u64) -> u64 {
    value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    value ^ (value >> 31)
}

/// The key of one of a seed's streams.
pub(crate) fn key(seed: u64, stream: u64) -> u64 {
    mix(mix(seed.wrapping_add(0x9e37_79b9_7f4a_7c15)) ^ stream.wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

/// Number `index` of a stream.
pub(crate) fn bits(key: u64, index: u64) -> u64 {
    mix(key.wrapping_add(index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15)))
}

/// Number `index` of a stream, evenly distributed in [-1, 1).
pub(crate) fn symmetric(key: u64, index: u64) -> f32 {
    // The highest 24 bits are an integer that an f32 holds exactly.
    (bits(key, index) >> 40) as f32 / (1 << 23) as f32 - 1.0
}
