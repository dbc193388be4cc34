//! Values between two axes.

use plotters::chart::{ChartBuilder, ChartContext};
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::element::{Circle, DashedPathElement, EmptyElement, PathElement, Rectangle, Text};
use plotters::prelude::{Color as _, DrawingArea, RGBColor, SVGBackend, TRANSPARENT};
use plotters::style::text_anchor::HPos;

use crate::axis::Axis;
use crate::look::{DASH, FAINT, GAP, PALE, WHITE, pixels, stroke, words};
use crate::sure::sure;

/// Beside and below a chart: the numbers of its axes, and the name of one.
const NUMBERS: [f64; 2] = [60.0, 37.0];

/// A chart; points in it are values of its axes.
pub struct Chart<'a, 'b> {
    inner: ChartContext<'a, SVGBackend<'b>, Cartesian2d<Axis, Axis>>,
}

/// A chart so far from the area's left, top, right and bottom.
pub(crate) fn chart<'a, 'b>(
    area: &'a DrawingArea<SVGBackend<'b>, Shift>,
    [left, top, right, bottom]: [f64; 4],
    below: &str,
    [x, y]: [Axis; 2],
) -> Chart<'a, 'b> {
    let mut builder = ChartBuilder::on(area);
    builder
        .margin_left(pixels(left - NUMBERS[0]))
        .margin_top(pixels(top))
        .margin_right(pixels(right))
        .margin_bottom(pixels(bottom - NUMBERS[1]))
        .y_label_area_size(pixels(NUMBERS[0]))
        .x_label_area_size(pixels(NUMBERS[1]));
    let mut inner = sure(builder.build_cartesian_2d(x, y));
    let mut mesh = inner.configure_mesh();
    mesh.disable_x_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(stroke(PALE, 1.0))
        .axis_style(stroke(FAINT, 1.0))
        .set_all_tick_mark_size(pixels(4.0))
        .label_style(words(FAINT, HPos::Center))
        .axis_desc_style(words(FAINT, HPos::Center))
        .x_desc(below);
    sure(mesh.draw());
    drop(mesh);
    Chart { inner }
}

impl Chart<'_, '_> {
    /// A line through points.
    pub fn line(&self, points: &[(f64, f64)], colour: RGBColor) {
        sure(self.inner.plotting_area().draw(&PathElement::new(points, stroke(colour, 2.0))));
    }

    /// The share of values, in percent, that are at most so large: a step at each of `values`,
    /// which ascend, and on to `end`.
    pub fn shares(&self, values: &[f64], end: f64, colour: RGBColor) {
        let mut share = 0.0;
        let mut points = vec![(0.0, 0.0)];
        for (n, value) in values.iter().enumerate() {
            points.push((*value, share));
            share = 100.0 * (n + 1) as f64 / values.len() as f64;
            points.push((*value, share));
        }
        points.push((end, share));
        self.line(&points, colour);
    }

    /// A line through points, and a dot at each.
    pub fn curve(&self, points: &[(f64, f64)], colour: RGBColor) {
        self.line(points, colour);
        for point in points {
            self.dot(*point, colour);
        }
    }

    /// A thin line from one value of y to another.
    pub fn interval(&self, x: f64, ends: [f64; 2], colour: RGBColor) {
        let style = colour.mix(0.5).stroke_width(pixels(1.0).unsigned_abs());
        sure(self.inner.plotting_area().draw(&PathElement::new(ends.map(|y| (x, y)), style)));
    }

    /// A dashed line through points.
    pub fn dashes(&self, points: &[(f64, f64)], colour: RGBColor) {
        let line = DashedPathElement::new(points.to_vec(), pixels(DASH), pixels(GAP), stroke(colour, 1.5));
        sure(self.inner.plotting_area().draw(&line));
    }

    /// A dot at a point.
    pub fn dot(&self, point: (f64, f64), colour: RGBColor) {
        for (radius, colour) in [(4.0, WHITE), (3.0, colour)] {
            sure(self.inner.plotting_area().draw(&Circle::new(point, pixels(radius), colour.filled())));
        }
    }

    /// A bar from 0 to `high`, between two values of x.
    pub fn bar(&self, [from, to]: [f64; 2], high: f64, colour: RGBColor) {
        let corners = [(from, high), (to, 0.0)];
        sure(self.inner.plotting_area().draw(&Rectangle::new(corners, colour.filled())));
    }

    /// A line of text, the middle of its height `above` units above a point.
    pub fn text(&self, point: (f64, f64), above: f64, anchor: HPos, colour: RGBColor, text: &str) {
        let text = Text::new(text.to_owned(), (0, pixels(-above)), words(colour, anchor));
        sure(self.inner.plotting_area().draw(&(EmptyElement::at(point) + text)));
    }
}
