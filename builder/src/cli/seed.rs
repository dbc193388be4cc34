//! The seed.

/// What all randomness comes from, unless a command names another; that of the shipped networks.
pub(super) const DEFAULT_SEED: u64 = 7;
