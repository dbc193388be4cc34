//! Files made to deceive: anything may stand in them, and every hash that opening checks is right. Opening and using one may
//! fail, and may answer nonsense, but never panics, hangs or takes memory without bound.
//!
//! `PROPTEST_CASES=100000 cargo test --release -p grasp-index --test hostile` looks for longer.

mod support;

use std::sync::OnceLock;

use grasp_index::{Effort, Index, SearchOptions, VoteOptions};
use proptest::prelude::*;
use proptest::sample::Index as Place;
use xxhash_rust::xxh3::xxh3_64;

/// The header's length.
const HEADER: usize = 64;

fn sound() -> &'static [Vec<u8>; 2] {
    static SOUND: OnceLock<[Vec<u8>; 2]> = OnceLock::new();
    SOUND.get_or_init(|| {
        let random = support::small().finish_bytes();
        let learned = support::writer(support::small_learned_params(), 4, 3).finish_bytes();
        [random.expect("an index"), learned.expect("an index")]
    })
}

fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(bytes.get(at..at + 8)?.try_into().ok()?))
}

/// Makes length, catalogue and hashes agree with the bytes, as one does who wants the file to be believed.
fn sign(bytes: &mut [u8]) {
    let length = bytes.len() as u64;
    let Some(offset) = u64_at(bytes, 24).map(|offset| offset.min(length)) else { return };
    let hash = xxh3_64(&bytes[offset as usize..]);
    let fields = [(16, length), (24, offset), (32, length - offset), (40, hash)];
    for (at, value) in fields {
        bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
    }
    let hash = xxh3_64(&bytes[..56]);
    bytes[56..HEADER].copy_from_slice(&hash.to_le_bytes());
}

/// Where something is changed: anywhere, or in the catalogue, which a file's sense hangs on.
#[derive(Clone, Debug)]
enum Change {
    Byte(bool, Place, u8),
    Number(bool, Place, u32),
    Cut(Place),
}

fn changes() -> impl Strategy<Value = Vec<Change>> {
    let numbers = prop_oneof![any::<u32>(), Just(u32::MAX), Just(0), Just(i32::MAX as u32), 0u32..1000];
    let change = prop_oneof![
        8 => (any::<bool>(), any::<Place>(), any::<u8>()).prop_map(|(in_catalogue, at, to)| Change::Byte(in_catalogue, at, to)),
        8 => (any::<bool>(), any::<Place>(), numbers).prop_map(|(in_catalogue, at, to)| Change::Number(in_catalogue, at, to)),
        1 => any::<Place>().prop_map(Change::Cut),
    ];
    proptest::collection::vec(change, 1..6)
}

fn apply(bytes: &mut Vec<u8>, changes: &[Change]) {
    for change in changes {
        let catalogue = u64_at(bytes, 24).map_or(0, |offset| offset as usize).min(bytes.len());
        let place = |in_catalogue: bool, at: &Place, width: usize| {
            let start = if in_catalogue { catalogue } else { 0 };
            let room = bytes.len().checked_sub(start + width)?;
            Some(start + at.index(room + 1))
        };
        match change {
            Change::Byte(in_catalogue, at, to) => {
                if let Some(at) = place(*in_catalogue, at, 1) {
                    bytes[at] = *to;
                }
            }
            Change::Number(in_catalogue, at, to) => {
                // Archives keep their numbers at multiples of four.
                if let Some(at) = place(*in_catalogue, at, 8).map(|at| at & !3) {
                    bytes[at..at + 4].copy_from_slice(&to.to_le_bytes());
                }
            }
            Change::Cut(at) => bytes.truncate(at.index(bytes.len() + 1)),
        }
    }
}

/// Everything that a program does with an index.
fn use_all(index: &Index) {
    index.verify();
    let _ = index.check_recognises();
    // A hostile index may want many neighbours; a program that is careful bounds them, as the service does.
    let k = index.search_options().k.clamp(1, 100);
    let query = vec![0.1; index.dim()];
    for effort in [SearchOptions::default().effort, Effort::Probes(3), Effort::Exact] {
        if let Ok(found) = index.search(&query, &SearchOptions { k, effort }) {
            for euler_mean in [false, true] {
                index.vote(&found.neighbours, &VoteOptions { euler_mean, ..VoteOptions::default() });
            }
        }
    }
    for id in (0..=index.len() as u32).take(100).chain([u32::MAX]) {
        let _ = index.entry(id);
        let _ = index.thumbnail(id);
        let _ = index.descriptor(id);
    }
}

proptest! {
    #[test]
    fn a_deceitful_file_does_no_harm(which in 0usize..2, changes in changes(), is_signed in proptest::bool::weighted(0.9)) {
        let mut bytes = sound()[which].clone();
        apply(&mut bytes, &changes);
        if is_signed && bytes.len() >= HEADER {
            sign(&mut bytes);
        }
        if let Ok(index) = Index::from_bytes(&bytes) {
            use_all(&index);
        }
    }

    #[test]
    fn noise_is_no_index(bytes in proptest::collection::vec(any::<u8>(), 0..2048)) {
        prop_assert!(Index::from_bytes(&bytes).is_err());
    }
}
