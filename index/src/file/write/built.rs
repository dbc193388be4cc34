//! What is made of the descriptors once all are in: sigma, the hash and its tables.

use super::columns::Columns;
use crate::file::catalogue::Originals;
use crate::file::input::{BuildError, IndexParams, Phase};
use crate::file::sections::SectionKind;
use crate::search::build::{self, HashParams, RandomParams, Step};
use crate::search::{Neighbour, Rows, Source};
use crate::vote::{
    Calibration, Example, MOST_VOTERS, Sigma, calibrate, measure_sigma, noise_of_the_farthest,
    noise_of_the_vote,
};
use std::ops::ControlFlow;

/// All that follows from the descriptors.
pub(super) struct Built {
    pub(super) sigma: Sigma,
    pub(super) calibration: Calibration,
    pub(super) search: build::Built,
}

impl Built {
    /// Measures, chooses and hashes the rows of `source`, the descriptors of the entries in `columns`.
    pub(super) fn new(
        source: Source<'_>,
        columns: &Columns,
        params: &IndexParams,
        progress: &dyn Fn(Phase, f64) -> ControlFlow<()>,
    ) -> Result<Self, BuildError> {
        let step = |phase, share| match progress(phase, share) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(BuildError::Stopped),
        };
        let rows = source.rows;
        let tables = match params.hash {
            HashParams::Random(RandomParams::Fixed { t, .. }) => u64::from(t),
            HashParams::Random(RandomParams::Auto) | HashParams::Learned => 1,
        };
        if u32::try_from(tables * rows.len() as u64).is_err() {
            return Err(BuildError::TooMany("the entries"));
        }
        step(Phase::Sigma, 0.0)?;
        let sigma = measure_sigma(rows.values, rows.dim, &columns.labels, params.classes.len());
        let held_out = Rows { values: &params.held_out, dim: rows.dim };
        let search_step = |at, share| {
            let phase = match at {
                Step::Tune => Phase::Tune,
                Step::Fill => Phase::Tables,
                Step::Measure => Phase::Measure,
            };
            step(phase, share)
        };
        let spread = sigma.mean_distance;
        let keeps_descriptors = params.originals != Originals::None;
        let search = build::build(
            source,
            keeps_descriptors,
            held_out,
            params.hash,
            spread,
            params.seed,
            &search_step,
        )?;
        let mut calibration = params.calibration;
        if !params.held_out_classes.is_empty() {
            step(Phase::Calibrate, 0.0)?;
            let asked = |noise, k| search.ask(source, held_out, k, noise, sigma.mean_distance, params.seed);
            let hands = params.hand_shapes.len();
            let class = |row: u32| params.held_out_classes.get(row as usize).copied();
            let vote =
                |near: &Neighbour| Some((*columns.labels.get(near.id as usize)?, f64::from(near.distance)));
            let example = |(row, neighbours): (u32, Vec<Neighbour>)| {
                let voters = neighbours.iter().filter_map(vote).collect();
                Some(Example { group: row, class: class(row)?, voters })
            };
            let noise = noise_of_the_vote(hands);
            let examples: Vec<Example> = asked(noise, MOST_VOTERS).into_iter().filter_map(example).collect();
            let far = asked(noise_of_the_farthest(hands), 1).into_iter();
            let far = far.filter_map(|(_, neighbours)| Some(f64::from(neighbours.first()?.distance)));
            calibration =
                calibrate(&examples, far, params.classes.len(), sigma.mean_distance, noise, calibration);
        }
        Ok(Self { sigma, calibration, search })
    }

    /// The bytes of one of the hash's sections; none for other sections.
    pub(super) fn section(&self, kind: SectionKind) -> &[u8] {
        self.search.section(kind)
    }
}
