//! Sound bytes that are changed, as fuzzing changes them.

use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;
use proptest::sample::Index as Place;

/// One of the seeds, changed here and there, with a piece of another in it, cut; or noise.
pub(super) fn mutated(seeds: &[Vec<u8>]) -> impl Strategy<Value = Vec<u8>> {
    let edits = vec((any::<Place>(), any::<u8>()), 0..8);
    let places = (option::of(any::<Place>()), option::of(any::<Place>()));
    let changed = (any::<Place>(), edits, places).prop_map(|(seed, edits, (other, cut))| {
        let mut bytes = seed.get(seeds).clone();
        for (at, value) in edits {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Some(other) = other {
            let at = other.index(bytes.len());
            bytes.splice(at..at, other.get(seeds).iter().copied());
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len() + 1));
        }
        bytes
    });
    prop_oneof![7 => changed, 1 => vec(any::<u8>(), 0..4096)]
}
