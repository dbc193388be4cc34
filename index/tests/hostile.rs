//! Files made to deceive: anything may stand in them, and every hash that opening checks is right.
//! Opening and using one may fail, and may answer nonsense, but never panics, hangs or takes memory
//! without bound.
//!
//! `PROPTEST_CASES=100000 cargo test --release -p grasp-index --test hostile` looks for longer.

#[path = "support/hostile.rs"]
mod hostile;
mod support;

use std::cell::Cell;
use std::sync::OnceLock;

use grasp_index::Index;
use proptest::prelude::*;
use proptest::sample::Index as Place;
use proptest::test_runner::TestRunner;

use hostile::{catalogue_offset, sign, use_all};

fn sound() -> &'static [Vec<u8>; 2] {
    static SOUND: OnceLock<[Vec<u8>; 2]> = OnceLock::new();
    SOUND.get_or_init(|| {
        let random = support::small().finish_bytes();
        let learned = support::writer(support::small_learned_params(), 4, 3).finish_bytes();
        [random.expect("an index"), learned.expect("an index")]
    })
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
        let catalogue = catalogue_offset(bytes).map_or(0, |offset| offset as usize).min(bytes.len());
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

/// Of files that are opened at all, most of the code that follows is reached; a test of files that
/// are all rejected at the door would show nothing.
const LEAST_OPENED_PERCENT: u32 = 20;

#[test]
fn a_deceitful_file_does_no_harm() {
    let (tried, opened) = (Cell::new(0u32), Cell::new(0u32));
    let files = (0usize..2, changes(), proptest::bool::weighted(0.9));
    let mut runner = TestRunner::new(ProptestConfig::with_source_file(file!()));
    let outcome = runner.run(&files, |(which, changes, is_signed)| {
        let mut bytes = sound()[which].clone();
        apply(&mut bytes, &changes);
        if is_signed {
            sign(&mut bytes);
        }
        tried.set(tried.get() + 1);
        if let Ok(index) = Index::from_bytes(&bytes) {
            opened.set(opened.get() + 1);
            use_all(&index);
        }
        Ok(())
    });
    outcome.unwrap_or_else(|failure| panic!("{failure}"));
    let (tried, opened) = (tried.get(), opened.get());
    assert!(100 * opened >= LEAST_OPENED_PERCENT * tried, "{opened} of {tried} files were opened");
    assert!(opened < tried, "all {tried} files were opened: nothing was changed that matters");
}

proptest! {
    #[test]
    fn noise_is_no_index(bytes in proptest::collection::vec(any::<u8>(), 0..2048)) {
        prop_assert!(Index::from_bytes(&bytes).is_err());
    }
}
