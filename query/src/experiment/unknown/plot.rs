//! Known hands kept over others kept, as SVG.

use super::super::svg::{Axes, Axis, COLOURS, GREY, Svg};
use super::figures::Unknown;

const HEIGHT: f64 = 620.0;

/// The picture: a curve for each measure.
pub(super) fn svg(unknown: &Unknown) -> String {
    let below = format!("{} hands in one of the grasps, {} others", unknown.known, unknown.others);
    let mut svg = Svg::new(HEIGHT, "Known hands told from others", &below);
    let mut x = 20.0;
    for (curve, colour) in unknown.curves.iter().zip(COLOURS) {
        let area = curve.area.map_or_else(String::new, |area| format!(" (area {area:.3})"));
        x = svg.key([x, 68.0], colour, None, &format!("{}{area}", curve.measure));
    }
    svg.key([x, 68.0], GREY, Some("5 4"), "by chance");
    let percent = |places| Axis::from_zero(100.0, 20.0, " %", places);
    let axes = Axes { x: percent([64.0, 520.0]), y: percent([HEIGHT - 52.0, 112.0]) };
    axes.draw(&mut svg, "known hands kept", "others taken for known");
    let place = |x: f64, y: f64| [axes.x.place(100.0 * x), axes.y.place(100.0 * y)];
    svg.line([place(0.0, 0.0), place(1.0, 1.0)], GREY, Some("5 4"));
    for (curve, colour) in unknown.curves.iter().zip(COLOURS) {
        let points = curve.points.iter().map(|point| place(point.others_kept, point.known_kept));
        svg.line([place(0.0, 0.0)].into_iter().chain(points), colour, None);
    }
    if let Some(at) = &unknown.at_limits {
        let [x, y] = place(1.0 - at.others_told, 1.0 - at.known_lost);
        svg.element(format_args!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{GREY}\" stroke=\"white\"/>"
        ));
    }
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::super::super::svg::tests::assert_inside;
    use super::super::figures::{AtLimits, Curve};
    use super::*;

    #[test]
    fn curves_and_the_indexs_own_limits_are_drawn() {
        let curve = |measure| Curve::new(measure, vec![0.1, 0.2], vec![0.2, 0.4], 1.0);
        let at_limits = AtLimits {
            farthest: 0.3,
            least_probability: 0.2,
            least_trust: 0.05,
            known_lost: 0.0,
            right_lost: 0.0,
            others_told: 0.5,
        };
        let unknown = Unknown {
            labels: "labels.csv".into(),
            known: 2,
            right: 1,
            others: 2,
            no_hand: 0,
            at_limits: Some(at_limits),
            curves: vec![curve("nearest"), curve("probability")],
            errors: Vec::new(),
        };
        let drawn = svg(&unknown);
        assert_inside(&drawn);
        assert!(drawn.contains("area 0.875") && drawn.matches("<circle").count() == 1, "{drawn}");
    }
}
