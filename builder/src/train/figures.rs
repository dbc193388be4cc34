//! What courses measure.

use std::fmt;

use grasp_terminal::text::percent;

/// Something that was measured.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Figure {
    /// The name of its column; an interface: never renamed. Ends with `_deg` where it is an angle
    /// in degrees, and is a share otherwise.
    pub name: String,
    /// How much.
    pub value: f64,
}

impl Figure {
    /// A named value, to four decimals: more mean nothing.
    pub(super) fn new(name: &str, value: f64) -> Self {
        Self { name: name.to_owned(), value: (value * 1e4).round() / 1e4 }
    }
}

/// For a person.
impl fmt::Display for Figure {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, value } = self;
        match name.strip_suffix("_deg") {
            Some(name) => write!(formatter, "{} {value:.1} deg", name.replace('_', " ")),
            None => write!(formatter, "{} {}", name.replace('_', " "), percent(*value)),
        }
    }
}

/// The middle one of some errors in degrees, the higher of two; 180 of none.
pub(super) fn median_deg(errors: impl Iterator<Item = f64>) -> f64 {
    let mut errors: Vec<f64> = errors.collect();
    errors.sort_by(f64::total_cmp);
    errors.get(errors.len() / 2).copied().unwrap_or(180.0)
}

/// The place of the highest value; of several, the first.
pub(super) fn highest(values: &[f32]) -> usize {
    let mut best = 0;
    for (at, value) in values.iter().enumerate() {
        if *value > values[best] {
            best = at;
        }
    }
    best
}
