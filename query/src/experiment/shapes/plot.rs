//! Accuracy and orientation error over the number of hand shapes, as SVG.

use super::super::KINDS;
use super::super::svg::{Axes, Axis, COLOURS, GREY, Svg};
use super::figures::{Point, STAGES, Shapes};
use crate::evaluate::labels::Kind;

/// Above the panels: title, the line below it, and a legend.
const HEAD: f64 = 88.0;
/// A row of panels.
const ROW: f64 = 320.0;
/// Where a row's panels begin and end, left and right.
const PANELS: [[f64; 2]; 2] = [[64.0, 520.0], [604.0, 1060.0]];

/// The picture; one without points has no panels.
pub(super) fn svg(shapes: &Shapes) -> String {
    let of = |kind: Kind| shapes.points.iter().filter(move |point| point.kind == kind);
    let kinds: Vec<Kind> = KINDS.into_iter().filter(|kind| of(*kind).next().is_some()).collect();
    let mut svg = Svg::new(
        HEAD + ROW * kinds.len() as f64,
        "What more hand shapes in the index are worth",
        "the same labelled pictures, recognised by indexes of ever more hand shapes; thin lines: 95 % confidence",
    );
    let mut x = 20.0;
    for (stage, colour) in STAGES.into_iter().zip(COLOURS) {
        let pictures = shapes.points.iter().find(|point| point.stage == stage).map(|point| point.n);
        if let Some(n) = pictures {
            x = svg.key([x, 68.0], colour, None, &format!("{stage} ({n} pictures)"));
        }
    }
    svg.key([x, 68.0], GREY, Some("5 4"), "by chance");
    let horizontal = |places: [f64; 2]| horizontal(&shapes.points, places);
    for (row, kind) in kinds.into_iter().enumerate() {
        let top = HEAD + ROW * row as f64;
        let vertical = [top + ROW - 52.0, top + 40.0];
        let points: Vec<&Point> = of(kind).collect();

        let axes = Axes { x: horizontal(PANELS[0]), y: Axis::from_zero(100.0, 20.0, " %", vertical) };
        axes.draw(&mut svg, &format!("{kind} pictures: classed rightly"), "hand shapes");
        let chance = axes.y.place(100.0 / shapes.classes.max(1) as f64);
        svg.line(axes.x.places.map(|x| [x, chance]), GREY, Some("5 4"));
        curves(&mut svg, &axes, &points, |point| Some(100.0 * point.top1));
        for point in &points {
            let x = axes.x.place(point.hand_shapes as f64);
            let [low, high] = [point.top1_low, point.top1_high].map(|share| axes.y.place(100.0 * share));
            svg.element(format_args!(
                "<line x1=\"{x:.1}\" y1=\"{low:.1}\" x2=\"{x:.1}\" y2=\"{high:.1}\" stroke=\"{}\" stroke-opacity=\"0.5\"/>",
                colour(point.stage)
            ));
        }

        let most = points.iter().filter_map(|point| point.orientation_median_deg).fold(0.0, f64::max);
        let step = [2.0, 5.0, 10.0, 20.0].into_iter().find(|step| most < 6.0 * step).unwrap_or(30.0);
        let high = (most / step + 0.3).ceil() * step;
        let axes = Axes { x: horizontal(PANELS[1]), y: Axis::from_zero(high, step, "°", vertical) };
        axes.draw(&mut svg, &format!("{kind} pictures: median error of the orientation"), "hand shapes");
        curves(&mut svg, &axes, &points, |point| point.orientation_median_deg);
    }
    svg.finish()
}

/// Logarithmic, with a tick at every number of hand shapes that was measured.
fn horizontal(points: &[Point], places: [f64; 2]) -> Axis {
    let mut counts: Vec<usize> = points.iter().map(|point| point.hand_shapes).collect();
    counts.sort_unstable();
    counts.dedup();
    let ends = [counts.first(), counts.last()].map(|end| end.map_or(1.0, |&count| count.max(1) as f64));
    let ticks = counts.into_iter().map(|count| (count as f64, count.to_string())).collect();
    Axis { values: [ends[0] / 1.3, ends[1] * 1.3], places, logarithmic: true, ticks }
}

fn colour(stage: &str) -> &'static str {
    STAGES.iter().zip(COLOURS).find(|(name, _)| **name == stage).map_or(GREY, |(_, colour)| colour)
}

fn curves(svg: &mut Svg, axes: &Axes, points: &[&Point], value: impl Fn(&Point) -> Option<f64>) {
    for stage in STAGES {
        let own = points.iter().filter(|point| point.stage == stage);
        let places: Vec<[f64; 2]> = own
            .filter_map(|point| Some([axes.x.place(point.hand_shapes as f64), axes.y.place(value(point)?)]))
            .collect();
        if places.is_empty() {
            continue;
        }
        svg.line(places.iter().copied(), colour(stage), None);
        for [x, y] in places {
            svg.element(format_args!(
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.5\" fill=\"{}\" stroke=\"white\"/>",
                colour(stage)
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::svg::tests::assert_inside;
    use super::*;

    #[test]
    fn every_score_is_drawn_twice() {
        let point = |kind, stage, hand_shapes| Point {
            kind,
            stage,
            hand_shapes,
            entries: 5400,
            n: 12,
            top1: 0.5,
            top1_low: 0.25,
            top1_high: 0.75,
            orientation_median_deg: Some(12.0),
            orientation_mean_deg: Some(20.0),
            index: "a.idx".into(),
        };
        let points: Vec<Point> = [1, 3, 100]
            .into_iter()
            .flat_map(|count| [point(Kind::Segmented, "grasp", count), point(Kind::Camera, "reach", count)])
            .collect();
        let shapes = Shapes { labels: "labels.csv".into(), classes: 6, points, errors: Vec::new() };
        let drawn = svg(&shapes);
        assert_inside(&drawn);
        assert_eq!(drawn.matches("<circle").count(), 2 * shapes.points.len());
        assert_inside(&svg(&Shapes { points: Vec::new(), ..shapes }));
    }
}
