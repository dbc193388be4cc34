//! What becomes of indexes that other versions of this crate have written.

use grasp_index::{Index, OpenError};
use insta::assert_snapshot;
use std::path::PathBuf;

fn fixture(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "tests", "fixtures", name].iter().collect()
}

/// No release wrote version 1.
#[test]
fn version_1_is_refused() {
    for refused in [Index::open(fixture("v1.idx")), Index::read(fixture("v1.idx"))] {
        let refused = refused.expect_err("version 1 is not read");
        assert!(matches!(refused, OpenError::TooOld { wrote: 1, oldest: 2 }));
        insta::allow_duplicates!(
            assert_snapshot!(refused, @"built by an older version of grasp-builder (format 1; this reads 2 and later): build it again")
        );
    }
}
