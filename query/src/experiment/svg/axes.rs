//! A panel's axes.

use super::drawing::{Anchor, FAINT, Svg};

/// The axes of a panel.
#[derive(Debug)]
pub(in crate::experiment) struct Axes {
    pub(in crate::experiment) x: Axis,
    pub(in crate::experiment) y: Axis,
}

/// One axis: its values, and where they lie in the drawing.
#[derive(Debug)]
pub(in crate::experiment) struct Axis {
    /// The values at its ends.
    pub(in crate::experiment) values: [f64; 2],
    /// Where these lie, in the drawing's units.
    pub(in crate::experiment) places: [f64; 2],
    /// Whether equal factors take equal room.
    pub(in crate::experiment) logarithmic: bool,
    /// The values that are written beside it, and how.
    pub(in crate::experiment) ticks: Vec<(f64, String)>,
}

impl Axis {
    /// Where a value lies; one outside the axis, at its end.
    pub(in crate::experiment) fn place(&self, value: f64) -> f64 {
        let scale = |value: f64| if self.logarithmic { value.max(f64::MIN_POSITIVE).ln() } else { value };
        let [low, high] = self.values.map(scale);
        let share = if high > low { (scale(value) - low) / (high - low) } else { 0.5 };
        let [from, to] = self.places;
        from + share.clamp(0.0, 1.0) * (to - from)
    }

    /// A linear axis from 0 with a tick at every `step`, written with `unit`.
    pub(in crate::experiment) fn from_zero(high: f64, step: f64, unit: &str, places: [f64; 2]) -> Self {
        let count = (high / step + 1e-9).floor() as u32;
        let ticks = (0..=count).map(|n| f64::from(n) * step).map(|tick| (tick, format!("{tick}{unit}")));
        Self { values: [0.0, high], places, logarithmic: false, ticks: ticks.collect() }
    }
}

impl Axes {
    /// Draws lines, ticks, the panel's title above and the name of the x axis below.
    pub(in crate::experiment) fn draw(&self, svg: &mut Svg, title: &str, below: &str) {
        let ([left, right], [bottom, top]) = (self.x.places, self.y.places);
        svg.heading([left, top - 14.0], title);
        for (tick, text) in &self.y.ticks {
            let y = self.y.place(*tick);
            svg.element(format_args!(
                "<line x1=\"{left:.1}\" y1=\"{y:.1}\" x2=\"{right:.1}\" y2=\"{y:.1}\" stroke=\"#e4e4e4\"/>"
            ));
            svg.text([left - 7.0, y + 4.0], Anchor::End, FAINT, text);
        }
        for (tick, text) in &self.x.ticks {
            let x = self.x.place(*tick);
            svg.element(format_args!(
                "<line x1=\"{x:.1}\" y1=\"{bottom:.1}\" x2=\"{x:.1}\" y2=\"{:.1}\" stroke=\"{FAINT}\"/>",
                bottom + 4.0
            ));
            svg.text([x, bottom + 17.0], Anchor::Middle, FAINT, text);
        }
        svg.element(format_args!(
            "<path d=\"M{left:.1},{top:.1}V{bottom:.1}H{right:.1}\" fill=\"none\" stroke=\"{FAINT}\"/>"
        ));
        svg.text([(left + right) / 2.0, bottom + 34.0], Anchor::Middle, FAINT, below);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_lie_between_the_ends() {
        let axis = Axis::from_zero(180.0, 30.0, "°", [10.0, 110.0]);
        assert_eq!([0.0, 90.0, 180.0, 400.0].map(|value| axis.place(value)), [10.0, 60.0, 110.0, 110.0]);
        assert_eq!((axis.ticks.len(), axis.ticks[1].1.as_str()), (7, "30°"));
        let decades = Axis { values: [1.0, 100.0], places: [0.0, 2.0], logarithmic: true, ticks: Vec::new() };
        assert!((decades.place(10.0) - 1.0).abs() < 1e-9);
        assert_eq!(Axis { values: [3.0, 3.0], ..decades }.place(3.0), 1.0);
    }
}
