//! What is made of the descriptors once all are in: sigma, the hash and its tables.

use super::columns::Columns;
use crate::file::catalogue::HashInfo;
use crate::file::input::{BuildError, IndexParams, Phase};
use crate::file::sections::SectionKind;
use crate::search::Rows;
use crate::search::random::{self, RandomHash, RandomHyperplanes};
use crate::search::tables::Tables;
use crate::search::tune::{self, HashParams, Measured};
use crate::vote::{Sigma, measure_sigma};
use std::ops::ControlFlow;

/// All that follows from the descriptors.
pub(super) struct Built {
    pub(super) sigma: Sigma,
    pub(super) hash: HashInfo,
    pub(super) measured: Measured,
    normals: Vec<f32>,
    offsets: Vec<f32>,
    tables: Tables,
}

impl Built {
    /// Measures, chooses and hashes `rows`, the descriptors of the entries in `columns`.
    pub(super) fn new(
        rows: Rows<'_>,
        columns: &Columns,
        params: &IndexParams,
        progress: &dyn Fn(Phase, f64) -> ControlFlow<()>,
    ) -> Result<Self, BuildError> {
        let step = |phase| match progress(phase, 0.0) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(BuildError::Stopped),
        };
        let seed = params.seed;
        step(Phase::Sigma)?;
        let sigma = measure_sigma(rows.values, rows.dim, &columns.labels, params.classes.len());
        step(Phase::Tune)?;
        let size = match params.hash {
            HashParams::Auto => tune::choose(rows, sigma.mean_distance, seed),
            HashParams::Fixed { k, t, buckets } => RandomHash { planes: k, tables: t, buckets, probes: 1 },
        };
        let ids = u64::from(size.tables) * rows.len() as u64;
        if u32::try_from(rows.len()).is_err() || u32::try_from(ids).is_err() {
            return Err(BuildError::TooMany("the entries"));
        }
        step(Phase::Tables)?;
        let (normals, offsets) = random::draw(rows, size.tables, size.planes, seed);
        let hash = RandomHyperplanes { size, dim: rows.dim, normals: &normals, offsets: &offsets };
        let tables = Tables::build(rows, size.tables, size.buckets, |row, table| hash.home(row, table));
        step(Phase::Measure)?;
        let measured = tune::measure(rows, &hash, &tables, size.probes, sigma.mean_distance, seed);
        Ok(Self { sigma, hash: HashInfo::Random(size), measured, normals, offsets, tables })
    }

    /// The bytes of one of the hash's sections; none for other sections.
    pub(super) fn section(&self, kind: SectionKind) -> &[u8] {
        match kind {
            SectionKind::PlaneNormals => bytemuck::cast_slice(&self.normals),
            SectionKind::PlaneOffsets => bytemuck::cast_slice(&self.offsets),
            SectionKind::BucketDirectory => bytemuck::cast_slice(&self.tables.directory),
            SectionKind::BucketIds => bytemuck::cast_slice(&self.tables.ids),
            _ => &[],
        }
    }
}
