//! The hash, and how well it finds.

use grasp_index::{EPS_GRID, EffortPoint, Measured};
use serde::Serialize;

/// The hash behind the buckets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
#[non_exhaustive]
pub enum HashInfo {
    /// Tables of random hyperplanes.
    Random {
        /// How many tables.
        tables: u32,
        /// Hyperplanes of each.
        planes: u32,
        /// Buckets of each.
        buckets: u32,
    },
    /// One tree of hyperplanes that were fitted to the entries.
    Learned {
        /// Always 1.
        tables: u32,
        /// Hyperplanes.
        planes: u32,
        /// Principal axes that entries are scanned along.
        axes: u32,
        /// Groups that the buckets' centres are ranked by.
        groups: u32,
    },
}

impl HashInfo {
    /// `None` for a kind that this version does not know.
    pub fn from_hash(hash: &grasp_index::HashInfo) -> Option<Self> {
        match *hash {
            grasp_index::HashInfo::Random(hash) => {
                Some(Self::Random { tables: hash.tables, planes: hash.planes, buckets: hash.buckets })
            }
            grasp_index::HashInfo::Learned(hash) => {
                Some(Self::Learned { tables: 1, planes: hash.planes, axes: hash.axes, groups: hash.groups })
            }
            _ => None,
        }
    }

    /// `random` or `learned`.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Random { .. } => "random",
            Self::Learned { .. } => "learned",
        }
    }
}

/// What so many probes find.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema), schema(as = EffortRecord))]
pub struct EffortInfo {
    /// Buckets that are looked into, in each table.
    pub probes: u32,
    /// The share of the true 10 nearest that is found.
    pub recall_at_10: f64,
    /// The share of queries whose nearest found is within `1 + eps` of the true nearest, for each
    /// `eps`.
    pub eps_success: [f64; EPS_GRID.len()],
    /// The share of the index that is looked at.
    pub share_of_database: f64,
}

impl From<&EffortPoint> for EffortInfo {
    fn from(point: &EffortPoint) -> Self {
        let EffortPoint { probes, recall_at_10, eps_success, share_of_database } = *point;
        Self { probes, recall_at_10, eps_success, share_of_database }
    }
}

/// How well the hash does on queries that it has not seen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeasuredInfo {
    /// How many queries.
    pub queries: u32,
    /// Whether they came from outside the index.
    pub held_out: bool,
    /// How far they were moved, in units of sigma: least and most.
    pub noise: [f64; 2],
    /// The values that `eps_success` is given for.
    pub eps: [f64; EPS_GRID.len()],
    /// From little effort to much.
    pub curve: Vec<EffortInfo>,
}

impl From<&Measured> for MeasuredInfo {
    fn from(measured: &Measured) -> Self {
        let Measured { queries, held_out, noise, ref curve } = *measured;
        Self { queries, held_out, noise, eps: EPS_GRID, curve: curve.iter().map(EffortInfo::from).collect() }
    }
}
