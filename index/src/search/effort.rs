//! How much effort finds how much: measured when the index is built, looked up when it is searched.

use super::options::Effort;

/// The values of eps at which success is measured.
pub const EPS_GRID: [f64; 6] = [0.0, 0.01, 0.02, 0.05, 0.1, 0.2];
/// The paper's eps.
pub const EPS: f64 = 0.05;
/// Of what is still missing to certainty, the part that is aimed at besides: what was measured on
/// some queries shall hold on others.
const MARGIN: f64 = 0.1;

/// What a search does and what it finds, on average, when it looks into `probes` buckets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffortPoint {
    /// Buckets that are looked into, in each table.
    pub probes: u32,
    /// The share of the true 10 nearest that is found.
    pub recall_at_10: f64,
    /// The share of queries whose nearest found is within `1 + eps` of the true nearest, for each
    /// eps of [`EPS_GRID`].
    pub eps_success: [f64; EPS_GRID.len()],
    /// The share of the index that the buckets hold.
    pub share_of_database: f64,
}

/// Neighbours that recall is measured over.
pub(crate) const RECALL_K: usize = 10;

/// How well the hash does on queries that it has not seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// How many queries were measured.
    pub queries: u32,
    /// Whether they were descriptors from outside the index; otherwise its own, each held out for
    /// its own query.
    pub held_out: bool,
    /// How far they were moved, in units of sigma: least and most.
    pub noise: [f64; 2],
    /// From little effort to much.
    pub curve: Vec<EffortPoint>,
}

impl Measured {
    /// The least effort that was measured to be enough, with a little to spare; `None` where no
    /// effort was.
    pub fn enough(&self, effort: Effort) -> Option<&EffortPoint> {
        let reaches = |found: f64, wanted: f64| found >= wanted + MARGIN * (1.0 - wanted);
        match effort {
            Effort::Recall(recall) => self.curve.iter().find(|point| reaches(point.recall_at_10, recall)),
            Effort::Success { eps, success } => {
                // Measured at a smaller eps, a success is one at this eps as well.
                let at = EPS_GRID.iter().rposition(|&measured| measured <= eps)?;
                self.curve.iter().find(|point| reaches(point.eps_success[at], success))
            }
            Effort::Probes(_) | Effort::Exact => None,
        }
    }

    /// The largest recall that any effort was measured to reach.
    pub fn best_recall(&self) -> f64 {
        self.curve.iter().map(|point| point.recall_at_10).fold(0.0, f64::max)
    }

    /// What was measured with exactly `probes` probes.
    pub(crate) fn at(&self, probes: u32) -> Option<&EffortPoint> {
        self.curve.iter().find(|point| point.probes == probes)
    }
}

impl EffortPoint {
    /// The share of queries whose nearest found is within `1 + EPS` of the true nearest, at the
    /// paper's eps.
    pub fn success(&self) -> f64 {
        EPS_GRID
            .iter()
            .zip(self.eps_success)
            .find(|(eps, _)| **eps == EPS)
            .map_or(0.0, |(_, success)| success)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured() -> Measured {
        let point = |probes: u32, recall_at_10: f64| EffortPoint {
            probes,
            recall_at_10,
            eps_success: [0.5, 0.6, 0.7, recall_at_10, 0.99, 1.0],
            share_of_database: 0.1,
        };
        let curve = vec![point(1, 0.8), point(2, 0.952), point(4, 0.97), point(8, 0.998)];
        Measured { queries: 100, held_out: true, noise: [0.1, 0.4], curve }
    }

    #[test]
    fn the_least_effort_that_is_enough_is_taken() {
        let measured = measured();
        let probes = |effort| measured.enough(effort).map(|point| point.probes);
        assert_eq!(probes(Effort::Recall(0.5)), Some(1));
        assert_eq!(probes(Effort::Recall(0.95)), Some(4), "0.952 leaves nothing to spare");
        assert_eq!(probes(Effort::Recall(0.99)), Some(8));
        assert_eq!(probes(Effort::Recall(1.0)), None);
        assert_eq!(probes(Effort::Success { eps: 0.05, success: 0.95 }), Some(4));
        assert_eq!(probes(Effort::Success { eps: 0.07, success: 0.95 }), Some(4), "as at 0.05");
        assert_eq!(probes(Effort::Success { eps: 5.0, success: 1.0 }), Some(1));
        assert_eq!(probes(Effort::Success { eps: 0.0, success: 0.95 }), None);
    }
}
