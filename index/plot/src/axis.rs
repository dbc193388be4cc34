//! An axis: which values it shows, and what is written beside it.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

/// One axis of a chart. Values outside it are drawn at its end.
#[derive(Clone, Debug)]
pub struct Axis {
    /// The values at its ends.
    pub ends: [f64; 2],
    /// Whether equal factors take equal room.
    pub logarithmic: bool,
    /// The values that are written beside it, and how.
    pub ticks: Vec<(f64, String)>,
}

impl Axis {
    /// A linear axis from 0 with a tick at every `step`, written with `unit`.
    #[must_use]
    pub fn from_zero(high: f64, step: f64, unit: &str) -> Self {
        let count = (high / step + 1e-9).floor() as u32;
        let ticks = (0..=count).map(|n| f64::from(n) * step).map(|tick| (tick, format!("{tick}{unit}")));
        Self { ends: [0.0, high], logarithmic: false, ticks: ticks.collect() }
    }

    /// How far a value lies from the first end to the second.
    fn share(&self, value: f64) -> f64 {
        let scale =
            |value: f64| if self.logarithmic { libm::log(value.max(f64::MIN_POSITIVE)) } else { value };
        let [low, high] = self.ends.map(scale);
        if high > low { ((scale(value) - low) / (high - low)).clamp(0.0, 1.0) } else { 0.5 }
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        from + (self.share(*value) * f64::from(to - from)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        let ticks = if hint.weight().allow_light_points() { &[] } else { self.ticks.as_slice() };
        ticks.iter().map(|(tick, _)| *tick).collect()
    }

    fn range(&self) -> Range<f64> {
        self.ends[0]..self.ends[1]
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        let tick = self.ticks.iter().find(|(tick, _)| tick == value);
        tick.map(|(_, text)| text.clone()).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_lie_between_the_ends() {
        let axis = Axis::from_zero(180.0, 30.0, "°");
        assert_eq!([0.0, 90.0, 180.0, 400.0].map(|value| axis.map(&value, (10, 110))), [10, 60, 110, 110]);
        assert_eq!((axis.ticks.len(), axis.format_ext(&30.0).as_str()), (7, "30°"));
        let decades = Axis { ends: [1.0, 100.0], logarithmic: true, ticks: Vec::new() };
        assert_eq!(decades.map(&10.0, (0, 200)), 100);
        assert_eq!(Axis { ends: [3.0, 3.0], ..decades }.map(&3.0, (0, 200)), 100);
    }
}
