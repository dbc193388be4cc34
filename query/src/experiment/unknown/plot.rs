//! Known hands kept over others kept, as SVG.

use grasp_plot::{Axis, COLOURS, GREY, INK, draw};

use super::figures::Unknown;

const HEIGHT: f64 = 620.0;

/// The picture: a curve for each measure.
pub(super) fn svg(unknown: &Unknown) -> String {
    let below = format!("{} hands in one of the grasps, {} others", unknown.known, unknown.others);
    draw(HEIGHT, "Known hands told from others", &below, |page| {
        let mut x = 20.0;
        for (curve, colour) in unknown.curves.iter().zip(COLOURS) {
            let area = curve.area.map_or_else(String::new, |area| format!(" (area {area:.3})"));
            x = page.key([x, 68.0], colour, false, &format!("{}{area}", curve.measure));
        }
        x = page.key([x, 68.0], GREY, true, "by chance");
        if unknown.at_limits.is_some() {
            page.key([x, 68.0], INK, false, "the program's limits (dot)");
        }
        let axes = [(); 2].map(|()| Axis::from_zero(100.0, 20.0, " %"));
        let (kept, taken) = ("known hands kept", "others taken for known");
        let chart = page.chart([64.0, 520.0], [HEIGHT - 52.0, 112.0], kept, taken, axes);
        chart.dashes(&[(0.0, 0.0), (100.0, 100.0)], GREY);
        for (curve, colour) in unknown.curves.iter().zip(COLOURS) {
            let points = curve.points.iter().map(|point| (point.others_kept, point.known_kept));
            let points = [(0.0, 0.0)].into_iter().chain(points).map(|(x, y)| (100.0 * x, 100.0 * y));
            chart.line(&points.collect::<Vec<_>>(), colour);
        }
        if let Some(at) = &unknown.at_limits {
            chart.dot((100.0 * (1.0 - at.others_told), 100.0 * (1.0 - at.known_lost)), INK);
        }
    })
}

#[cfg(test)]
mod tests {
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
        assert!(drawn.contains("area 0.875") && drawn.matches("<circle").count() == 2, "{drawn}");
    }
}
