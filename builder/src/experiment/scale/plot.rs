//! The results as a picture: six panels over the number of entries, as SVG.

use grasp_index::EPS;
use grasp_plot::{Axis, COLOURS, Colour, GREY, Page, WIDTH, draw};
use std::collections::BTreeSet;

use super::fit::power_law;
use super::table::Row;

/// The exponent of N that the paper promises for its eps: 1 / (1 + eps).
pub const PAPER_EXPONENT: f64 = 1.0 / (1.0 + EPS);

const HEIGHT: f64 = 700.0;
/// Above the panels: title and legend.
const HEAD: f64 = 88.0;
const COLUMNS: usize = 3;
const PANEL: [f64; 2] = [WIDTH / COLUMNS as f64, (HEIGHT - HEAD) / 2.0];
/// From a panel's edges to its axes: left, top, right, bottom.
const MARGIN: [f64; 4] = [62.0, 34.0, 22.0, 42.0];
/// More labels than that run into each other.
const MOST_TICKS: usize = 6;

/// A panel's curve: what it shows of a row.
type Value = fn(&Row) -> f64;

struct Panel {
    title: &'static str,
    value: Value,
    /// Logarithmic, or linear up to 1.
    logarithmic: bool,
}

const PANELS: [Panel; 6] = [
    Panel { title: "candidates a query", value: |row| row.candidates, logarithmic: true },
    Panel { title: "microseconds a query, one core", value: |row| row.ns_per_query / 1e3, logarithmic: true },
    Panel { title: "seconds to build", value: |row| row.build_s, logarithmic: true },
    Panel { title: "recall@10", value: |row| row.recall_at_10, logarithmic: false },
    Panel { title: "found within 1.05 of the nearest", value: |row| row.eps_success, logarithmic: false },
    Panel { title: "megabytes of the file", value: |row| row.file_bytes as f64 / 1e6, logarithmic: true },
];

/// The names of the hashes that were measured, in order.
#[must_use]
pub fn hashes(rows: &[Row]) -> Vec<&str> {
    rows.iter().map(|row| row.hash.as_str()).collect::<BTreeSet<_>>().into_iter().collect()
}

/// A hash's colour.
fn colour(hash: &str) -> Colour {
    COLOURS[usize::from(hash == "random")]
}

/// A measured value over the number of entries, of one hash.
pub fn points(rows: &[Row], hash: &str, value: impl Fn(&Row) -> f64) -> Vec<(f64, f64)> {
    let own = rows.iter().filter(|row| row.hash == hash);
    let mut points: Vec<(f64, f64)> = own.map(|row| (row.entries as f64, value(row))).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}

/// The picture; one without measurements says so.
pub fn svg(rows: &[Row]) -> String {
    let data = rows.first().map_or("nothing measured yet", |row| row.data.as_str());
    let below = format!("{data} · for 95 % of the queries, a neighbour within 1.05 of the nearest is wanted");
    draw(HEIGHT, "How the search grows with the index", &below, |page| {
        legend(page, rows);
        for (at, panel) in PANELS.iter().enumerate() {
            draw_panel(page, rows, at, panel);
        }
    })
}

fn legend(page: &Page<'_>, rows: &[Row]) {
    let mut x = 20.0;
    for hash in hashes(rows) {
        let law = power_law(&points(rows, hash, |row| row.candidates));
        let law = law.map(|law| format!(": candidates ~ N^{:.2}", law.exponent)).unwrap_or_default();
        x = page.key([x, 68.0], colour(hash), false, &format!("{hash} hash{law}"));
    }
    if !rows.is_empty() {
        page.key([x, 68.0], GREY, true, &format!("the paper's promise: ~ N^{PAPER_EXPONENT:.3}"));
    }
}

fn draw_panel(page: &Page<'_>, rows: &[Row], at: usize, panel: &Panel) {
    let range = |value: Value| {
        let values = rows.iter().map(value).filter(|value| value.is_finite());
        values.fold((f64::INFINITY, 0.0f64), |(low, high), value| (low.min(value), high.max(value)))
    };
    let (fewest, most) = range(|row| row.entries as f64);
    let promise = promise(rows).filter(|_| at == 0);
    let (low, high) = range(panel.value);
    let high = promise.map_or(high, |[_, (_, candidates)]| high.max(candidates));
    if rows.is_empty() || low <= 0.0 || high <= 0.0 {
        return;
    }
    let [left, top] = [(at % COLUMNS) as f64 * PANEL[0], HEAD + (at / COLUMNS) as f64 * PANEL[1]];
    let y = if panel.logarithmic {
        logarithmic([low / 1.6, high * 1.6])
    } else {
        // Shares: up to 1, and from a twentieth below the least.
        shares((low * 20.0 - 0.5).floor().max(0.0) / 20.0)
    };
    let chart = page.chart(
        [left + MARGIN[0], left + PANEL[0] - MARGIN[2]],
        [top + PANEL[1] - MARGIN[3], top + MARGIN[1]],
        panel.title,
        "entries",
        [logarithmic([fewest / 1.25, most * 1.25]), y],
    );
    if let Some(promise) = promise {
        chart.dashes(&promise, GREY);
    }
    for hash in hashes(rows) {
        let points = points(rows, hash, panel.value).into_iter().filter(|(_, y)| *y > 0.0);
        chart.curve(&points.collect::<Vec<_>>(), colour(hash));
    }
}

/// What the paper promises, from where the curve of the most candidates begins to the largest
/// index.
fn promise(rows: &[Row]) -> Option<[(f64, f64); 2]> {
    let firsts =
        hashes(rows).into_iter().filter_map(|hash| points(rows, hash, |row| row.candidates).first().copied());
    let (n, candidates) = firsts.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let most = rows.iter().map(|row| row.entries as f64).fold(n, f64::max);
    Some([(n, candidates), (most, candidates * (most / n).powf(PAPER_EXPONENT))])
}

/// An axis of decades, and of what fits between them.
fn logarithmic([low, high]: [f64; 2]) -> Axis {
    let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
    let ticks = |steps: &[f64]| -> Vec<f64> {
        let all = decades.clone().flat_map(|decade| steps.iter().map(move |step| step * 10f64.powi(decade)));
        all.filter(|tick| (low..=high).contains(tick)).collect()
    };
    let dense = [ticks(&[1.0, 2.0, 5.0]), ticks(&[1.0, 3.0])];
    let ticks = dense.into_iter().find(|ticks| ticks.len() <= MOST_TICKS).unwrap_or_else(|| ticks(&[1.0]));
    Axis { ends: [low, high], logarithmic: true, ticks: written(ticks) }
}

/// An axis of shares up to 1.
fn shares(low: f64) -> Axis {
    let step = if 1.0 - low > 0.3 { 0.1 } else { 0.05 };
    let ticks = (low / step).round() as i32..=(1.0 / step).round() as i32;
    let ticks = ticks.map(|tick| f64::from(tick) * step).collect();
    Axis { ends: [low, 1.0], logarithmic: false, ticks: written(ticks) }
}

fn written(ticks: Vec<f64>) -> Vec<(f64, String)> {
    ticks.into_iter().map(|tick| (tick, number(tick))).collect()
}

/// `20 k`, `3 M`, `0.05`.
fn number(value: f64) -> String {
    let (value, unit) = match value {
        millions if millions >= 1e6 => (millions / 1e6, " M"),
        thousands if thousands >= 1e3 => (thousands / 1e3, " k"),
        other => (other, ""),
    };
    // Two digits behind the point are enough for any tick; no trailing zeros.
    format!("{}{unit}", (value * 100.0).round() / 100.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows() -> Vec<Row> {
        let row = |hash: &str, entries: u64, candidates: f64| Row {
            hash: hash.into(),
            entries,
            candidates,
            build_s: 0.2,
            ns_per_query: 2e4,
            file_bytes: 400 * entries,
            recall_at_10: 0.93,
            eps_success: 0.96,
            data: "a < b & c".into(),
            ..Row::default()
        };
        vec![row("random", 5000, 900.0), row("random", 50_000, 6000.0), row("learned", 5000, 300.0)]
    }

    #[test]
    fn every_measurement_is_drawn_within_the_picture() {
        let svg = svg(&rows());
        assert_eq!(svg.matches("<circle").count(), 2 * PANELS.len() * 3);
        assert!(svg.contains("a &lt; b &amp; c"));
        assert!(svg.contains("random hash: candidates ~ N^0.82") && svg.contains("N^0.952"));
    }

    #[test]
    fn nothing_measured_is_no_error() {
        assert!(svg(&[]).contains("nothing measured yet"));
    }

    #[test]
    fn ticks_are_round() {
        let ticks = |axis: Axis| axis.ticks.into_iter().map(|(_, text)| text).collect::<Vec<_>>();
        assert_eq!(ticks(logarithmic([4e3, 2e6])), ["10 k", "30 k", "100 k", "300 k", "1 M"]);
        assert_eq!(ticks(logarithmic([4e3, 2e9])), ["10 k", "100 k", "1 M", "10 M", "100 M", "1000 M"]);
        assert_eq!(ticks(logarithmic([4e3, 6e4])), ["5 k", "10 k", "20 k", "50 k"]);
        assert_eq!(ticks(shares(0.85)), ["0.85", "0.9", "0.95", "1"]);
        assert_eq!([2e4, 5e6, 0.05, 1.0].map(number), ["20 k", "5 M", "0.05", "1"]);
    }
}
