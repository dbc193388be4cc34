//! Whether probabilities come true and how far rotations are off, as SVG.

use grasp_plot::{Anchor, Axis, COLOURS, Colour, FAINT, GREY, Page, draw};

use super::findings::Findings;
use crate::evaluate::confusion::Share;

const HEIGHT: f64 = 440.0;
/// Where the panels begin and end, left and right.
const PANELS: [[f64; 2]; 2] = [[64.0, 520.0], [620.0, 1056.0]];
/// Where both end and begin, from the top.
const VERTICAL: [f64; 2] = [HEIGHT - 52.0, 122.0];

/// Both panels; the right one is empty where no rotation is labelled.
pub(super) fn svg(findings: &Findings) -> String {
    let title = "What an answer's figures are worth";
    let below = "left: bars are 95 % confidence, numbers count answers; right: how many answered rotations lie within an error";
    draw(HEIGHT, title, below, |page| {
        calibration(page, findings);
        if !findings.orientation_errors_deg.is_empty() {
            rotation(page, findings);
        }
    })
}

fn calibration(page: &Page<'_>, findings: &Findings) {
    let axes = [(); 2].map(|()| Axis::from_zero(100.0, 20.0, " %"));
    page.key([PANELS[0][0], 74.0], GREY, true, "probabilities that come true");
    let chart = page.chart(PANELS[0], VERTICAL, "Share that is right", "probability that is stated", axes);
    chart.dashes(&[(0.0, 0.0), (100.0, 100.0)], GREY);
    for bin in &findings.report.calibration.reliability {
        let n = bin.n as usize;
        let share = Share { n, right: (bin.right * f64::from(bin.n)).round() as usize };
        let (stated, right) = (100.0 * bin.probability, 100.0 * bin.right);
        chart.interval(stated, share.interval().map(|bound| 100.0 * bound), COLOURS[0]);
        chart.dot((stated, right), COLOURS[0]);
        // To the left of the bar, where a bar at the right end has room as well.
        chart.text((stated - 1.5, right), 8.0, Anchor::Right, FAINT, &n.to_string());
    }
}

fn rotation(page: &Page<'_>, findings: &Findings) {
    let curves: [(&str, &[f64], Colour); 2] = [
        ("all", &findings.orientation_errors_deg, COLOURS[0]),
        ("rightly classed", &findings.orientation_errors_deg_right_class, COLOURS[1]),
    ];
    let mut x = PANELS[1][0];
    for (name, errors, colour) in curves {
        x = page.key([x, 74.0], colour, false, &format!("{name}, {}", errors.len()));
    }
    let axes = [Axis::from_zero(180.0, 30.0, "°"), Axis::from_zero(100.0, 20.0, " %")];
    let chart = page.chart(PANELS[1], VERTICAL, "Share within an error", "error of the rotation", axes);
    for (_, errors, colour) in curves {
        chart.shares(errors, 180.0, colour);
    }
}
