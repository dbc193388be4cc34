//! What is learned of an index's descriptors once all are in: sigma, the hash, and what the vote is
//! worth.

use crate::phase::Phase;
use crate::search::Originals;
use crate::search::build::{BuiltHash, HashParams, build};
use crate::search::queries::{HeldOut, NOISE};
use crate::search::{Neighbour, Rows, Source};
use crate::vote::{
    Calibration, Example, MOST_VOTERS, Sigma, calibrate, measure_sigma, noise_of_the_farthest,
    noise_of_the_vote,
};

/// What to learn, and from what besides the descriptors.
pub(crate) struct ModelParams<'a> {
    pub(crate) hash: HashParams,
    /// In what form a search will have the descriptors to measure distances by.
    pub(crate) originals: Originals,
    /// The class of each descriptor; nothing where that is not known.
    pub(crate) labels: &'a [u16],
    /// How many classes there are.
    pub(crate) classes: usize,
    /// How many hand shapes there are.
    pub(crate) hand_shapes: usize,
    /// Descriptors from outside the index, and the class of each, where that is known.
    pub(crate) held_out: &'a [f32],
    pub(crate) held_out_classes: &'a [u16],
    /// What stands where the vote cannot be calibrated.
    pub(crate) calibration: Calibration,
    pub(crate) seed: u64,
}

/// What was learned.
pub(crate) struct Model {
    pub(crate) sigma: Sigma,
    pub(crate) calibration: Calibration,
    pub(crate) search: BuiltHash,
}

impl Model {
    /// Learns from the descriptors of `source`. `progress` stops the work by returning an error.
    pub(crate) fn fit<E: Send>(
        source: Source<'_>,
        params: &ModelParams<'_>,
        progress: &dyn Fn(Phase, f64) -> Result<(), E>,
    ) -> Result<Self, E> {
        let rows = source.rows;
        progress(Phase::Sigma, 0.0)?;
        let sigma = measure_sigma(rows.values, rows.dim, params.labels, params.classes);
        let held_out = Rows { values: params.held_out, dim: rows.dim };
        // Of what class they are is known of renders alone, which lie nearer than pictures do.
        // Others are what will be searched for.
        let noise = if params.held_out_classes.is_empty() { [0.0; 2] } else { NOISE };
        let outside = HeldOut { rows: held_out, noise };
        let mean = sigma.mean_distance;
        let search = build(source, params.originals, outside, params.hash, mean, params.seed, progress)?;
        let mut model = Self { sigma, calibration: params.calibration, search };
        if !params.held_out_classes.is_empty() {
            progress(Phase::Calibrate, 0.0)?;
            model.calibration = model.calibrated(source, held_out, params);
        }
        Ok(model)
    }

    /// The vote calibrated by the neighbours of the held-out descriptors.
    fn calibrated(&self, source: Source<'_>, held_out: Rows<'_>, params: &ModelParams<'_>) -> Calibration {
        let sigma = self.sigma.mean_distance;
        let neighbours =
            |noise, k| self.search.neighbours_of_held_out(source, held_out, k, noise, sigma, params.seed);
        let class = |row: u32| params.held_out_classes.get(row as usize).copied();
        let voter =
            |near: &Neighbour| Some((*params.labels.get(near.id as usize)?, f64::from(near.distance)));
        let example = |(row, neighbours): (u32, Vec<Neighbour>)| {
            let voters = neighbours.iter().filter_map(voter).collect();
            Some(Example { group: row, class: class(row)?, voters })
        };
        let noise = noise_of_the_vote(params.hand_shapes);
        let examples: Vec<Example> = neighbours(noise, MOST_VOTERS).into_iter().filter_map(example).collect();
        let nearest = neighbours(noise_of_the_farthest(params.hand_shapes), 1).into_iter();
        let nearest = nearest.filter_map(|(_, neighbours)| Some(f64::from(neighbours.first()?.distance)));
        calibrate(&examples, nearest, params.classes, sigma, noise, params.calibration)
    }
}
