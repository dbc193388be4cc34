//! A program that was built without Parquet.

use std::path::Path;

use anyhow::bail;
use grasp_index::Index;

use crate::shard::PartReader;

/// Reports that this program cannot.
///
/// # Errors
/// Always.
pub fn index_as_parquet(_: &Index, _: &Path, _: &dyn Fn(u64)) -> anyhow::Result<()> {
    bail!("this grasp-builder was built without Parquet: build it with --features parquet")
}

/// Reports that this program cannot.
pub(crate) fn part_as_parquet(_: PartReader, _: &Path, _: &dyn Fn(u64)) -> anyhow::Result<u64> {
    bail!("this grasp-builder was built without Parquet: build it with --features parquet")
}
