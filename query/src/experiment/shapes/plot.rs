//! Accuracy and orientation error over the number of hand shapes, as SVG.

use grasp_plot::{Axis, COLOURS, Chart, Colour, GREY, Page, draw};

use super::super::KINDS;
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
    let height = HEAD + ROW * kinds.len() as f64;
    let title = "What more hand shapes in the index are worth";
    let below = "the same labelled pictures, recognised by indexes of ever more hand shapes; thin lines: 95 % confidence";
    draw(height, title, below, |page| {
        let mut x = 20.0;
        for (stage, colour) in STAGES.into_iter().zip(COLOURS) {
            // Of each row's kind, so many.
            let pictures = |kind: &Kind| {
                let point = of(*kind).find(|point| point.stage == stage);
                point.map(|point| point.n.to_string())
            };
            let counts: Vec<String> = kinds.iter().filter_map(pictures).collect();
            if !counts.is_empty() {
                let key = format!("{stage} ({} pictures)", counts.join(" and "));
                x = page.key([x, 68.0], colour, false, &key);
            }
        }
        page.key([x, 68.0], GREY, true, "by chance");
        for (row, kind) in kinds.into_iter().enumerate() {
            let top = HEAD + ROW * row as f64;
            draw_row(page, shapes, kind, [top + ROW - 52.0, top + 40.0]);
        }
    })
}

fn draw_row(page: &Page<'_>, shapes: &Shapes, kind: Kind, vertical: [f64; 2]) {
    let points: Vec<&Point> = shapes.points.iter().filter(|point| point.kind == kind).collect();
    let x = horizontal(&shapes.points);
    let ends = x.ends;

    let title = format!("{kind} pictures: classed rightly");
    let axes = [x.clone(), Axis::from_zero(100.0, 20.0, " %")];
    let chart = page.chart(PANELS[0], vertical, &title, "hand shapes", axes);
    let chance = 100.0 / shapes.classes.max(1) as f64;
    chart.dashes(&ends.map(|x| (x, chance)), GREY);
    curves(&chart, &points, |point| Some(100.0 * point.top1));
    for point in &points {
        let ends = [point.top1_low, point.top1_high].map(|share| 100.0 * share);
        chart.interval(point.hand_shapes as f64, ends, colour(point.stage));
    }

    let most = points.iter().filter_map(|point| point.orientation_median_deg).fold(0.0, f64::max);
    let step = [2.0, 5.0, 10.0, 20.0].into_iter().find(|step| most < 6.0 * step).unwrap_or(30.0);
    let title = format!("{kind} pictures: median error of the orientation");
    let axes = [x, Axis::from_zero((most / step + 0.3).ceil() * step, step, "°")];
    let chart = page.chart(PANELS[1], vertical, &title, "hand shapes", axes);
    curves(&chart, &points, |point| point.orientation_median_deg);
}

/// Logarithmic, with a tick at every number of hand shapes that was measured.
fn horizontal(points: &[Point]) -> Axis {
    let mut counts: Vec<usize> = points.iter().map(|point| point.hand_shapes).collect();
    counts.sort_unstable();
    counts.dedup();
    let ends = [counts.first(), counts.last()].map(|end| end.map_or(1.0, |&count| count.max(1) as f64));
    let ticks = counts.into_iter().map(|count| (count as f64, count.to_string())).collect();
    Axis { ends: [ends[0] / 1.3, ends[1] * 1.3], logarithmic: true, ticks }
}

fn colour(stage: &str) -> Colour {
    STAGES.iter().zip(COLOURS).find(|(name, _)| **name == stage).map_or(GREY, |(_, colour)| colour)
}

fn curves(chart: &Chart<'_, '_>, points: &[&Point], value: impl Fn(&Point) -> Option<f64>) {
    for stage in STAGES {
        let own = points.iter().filter(|point| point.stage == stage);
        let own: Vec<_> = own.filter_map(|point| Some((point.hand_shapes as f64, value(point)?))).collect();
        chart.curve(&own, colour(stage));
    }
}

#[cfg(test)]
mod tests {
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
        assert_eq!(drawn.matches("<circle").count(), 2 * 2 * shapes.points.len());
        assert!(!svg(&Shapes { points: Vec::new(), ..shapes }).contains("<circle"));
    }
}
