//! The results as a picture: six panels over the number of entries, as SVG.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use grasp_index::EPS;

use super::fit::power_law;
use super::table::Row;

/// The exponent of N that the paper promises for its eps: 1 / (1 + eps).
pub const PAPER_EXPONENT: f64 = 1.0 / (1.0 + EPS);

const WIDTH: f64 = 1080.0;
const HEIGHT: f64 = 700.0;
/// Above the panels: title and legend.
const HEAD: f64 = 88.0;
const COLUMNS: usize = 3;
const PANEL: [f64; 2] = [WIDTH / COLUMNS as f64, (HEIGHT - HEAD) / 2.0];
/// From a panel's edges to its axes: left, top, right, bottom.
const MARGIN: [f64; 4] = [62.0, 34.0, 22.0, 42.0];
const GREY: &str = "#888";
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

/// A hash's colour; the colour-blind tell them apart as well.
fn colour(hash: &str) -> &'static str {
    if hash == "random" { "#d55e00" } else { "#0072b2" }
}

/// A measured value over the number of entries, of one hash.
pub fn points(rows: &[Row], hash: &str, value: impl Fn(&Row) -> f64) -> Vec<(f64, f64)> {
    let own = rows.iter().filter(|row| row.hash == hash);
    let mut points: Vec<(f64, f64)> = own.map(|row| (row.entries as f64, value(row))).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}

/// The picture; one without measurements says so.
#[must_use]
pub fn svg(rows: &[Row]) -> String {
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{HEIGHT}\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
         font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\" fill=\"#222\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    head(&mut out, rows);
    let range = |value: Value| {
        let values = rows.iter().map(value).filter(|value| value.is_finite());
        values.fold((f64::INFINITY, 0.0f64), |(low, high), value| (low.min(value), high.max(value)))
    };
    let (fewest, most) = range(|row| row.entries as f64);
    for (at, panel) in PANELS.iter().enumerate() {
        let promise = promise(rows).filter(|_| at == 0);
        let (low, high) = range(panel.value);
        let high = promise.map_or(high, |[_, (_, candidates)]| high.max(candidates));
        if rows.is_empty() || low <= 0.0 || high <= 0.0 {
            continue;
        }
        let corner = [(at % COLUMNS) as f64 * PANEL[0], HEAD + (at / COLUMNS) as f64 * PANEL[1]];
        let axes = Axes {
            x: Axis {
                low: fewest / 1.25,
                high: most * 1.25,
                logarithmic: true,
                from: corner[0] + MARGIN[0],
                to: corner[0] + PANEL[0] - MARGIN[2],
            },
            y: Axis {
                // Linear panels show shares: up to 1, and from a twentieth below the least.
                low: if panel.logarithmic { low / 1.6 } else { (low * 20.0 - 0.5).floor().max(0.0) / 20.0 },
                high: if panel.logarithmic { high * 1.6 } else { 1.0 },
                logarithmic: panel.logarithmic,
                from: corner[1] + PANEL[1] - MARGIN[3],
                to: corner[1] + MARGIN[1],
            },
        };
        axes.draw(&mut out, panel.title);
        if let Some(promise) = promise {
            draw_promise(&mut out, &axes, promise);
        }
        for hash in hashes(rows) {
            let points = points(rows, hash, panel.value);
            curve(&mut out, &axes, &points, colour(hash));
        }
    }
    out.push_str("</svg>\n");
    out
}

/// Title and legend.
fn head(out: &mut String, rows: &[Row]) {
    let data = rows.first().map_or("nothing measured yet", |row| row.data.as_str());
    let _ =
        writeln!(out, "<text x=\"20\" y=\"28\" font-size=\"17\">How the search grows with the index</text>");
    let _ = writeln!(
        out,
        "<text x=\"20\" y=\"47\" fill=\"#555\">{} · for 95 % of the queries, a neighbour within 1.05 of the nearest is wanted</text>",
        escaped(data)
    );
    let mut x = 20.0;
    for hash in hashes(rows) {
        let law = power_law(&points(rows, hash, |row| row.candidates));
        let law = law.map(|law| format!(": candidates ~ N^{:.2}", law.exponent)).unwrap_or_default();
        let text = format!("{} hash{law}", escaped(hash));
        key(out, x, colour(hash), "", &text);
        x += 60.0 + 6.6 * text.len() as f64;
    }
    if !rows.is_empty() {
        key(out, x, GREY, "5 4", &format!("the paper's promise: ~ N^{PAPER_EXPONENT:.3}"));
    }
}

fn key(out: &mut String, x: f64, colour: &str, dashes: &str, text: &str) {
    let _ = writeln!(
        out,
        "<line x1=\"{x}\" y1=\"68\" x2=\"{}\" y2=\"68\" stroke=\"{colour}\" stroke-width=\"2\" stroke-dasharray=\"{dashes}\"/>\
         <text x=\"{}\" y=\"72\">{text}</text>",
        x + 26.0,
        x + 32.0
    );
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

fn draw_promise(out: &mut String, axes: &Axes, [from, to]: [(f64, f64); 2]) {
    let _ = writeln!(
        out,
        "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{GREY}\" stroke-width=\"1.5\" stroke-dasharray=\"5 4\"/>",
        axes.x.place(from.0),
        axes.y.place(from.1),
        axes.x.place(to.0),
        axes.y.place(to.1),
    );
}

fn curve(out: &mut String, axes: &Axes, points: &[(f64, f64)], colour: &str) {
    let places: Vec<(f64, f64)> =
        points.iter().filter(|(_, y)| *y > 0.0).map(|(x, y)| (axes.x.place(*x), axes.y.place(*y))).collect();
    let line: Vec<String> = places.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    let _ = writeln!(
        out,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>",
        line.join(" ")
    );
    for (x, y) in places {
        let _ = writeln!(
            out,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.5\" fill=\"{colour}\" stroke=\"white\"/>"
        );
    }
}

struct Axes {
    x: Axis,
    y: Axis,
}

struct Axis {
    low: f64,
    high: f64,
    logarithmic: bool,
    /// Where `low` lies in the picture, and where `high` does.
    from: f64,
    to: f64,
}

impl Axis {
    fn place(&self, value: f64) -> f64 {
        let scale = |value: f64| if self.logarithmic { value.max(f64::MIN_POSITIVE).ln() } else { value };
        let share = (scale(value) - scale(self.low)) / (scale(self.high) - scale(self.low));
        self.from + share * (self.to - self.from)
    }

    /// Round numbers within the axis: decades, and what fits between them.
    fn ticks(&self) -> Vec<f64> {
        if !self.logarithmic {
            let step = if self.high - self.low > 0.3 { 0.1 } else { 0.05 };
            let first = (self.low / step).round() as i32;
            let last = (self.high / step).round() as i32;
            return (first..=last).map(|tick| f64::from(tick) * step).collect();
        }
        let decades = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
        let ticks = |steps: &[f64]| -> Vec<f64> {
            let all =
                decades.clone().flat_map(|decade| steps.iter().map(move |step| step * 10f64.powi(decade)));
            all.filter(|tick| (self.low..=self.high).contains(tick)).collect()
        };
        let dense = [ticks(&[1.0, 2.0, 5.0]), ticks(&[1.0, 3.0])];
        dense.into_iter().find(|ticks| ticks.len() <= MOST_TICKS).unwrap_or_else(|| ticks(&[1.0]))
    }
}

impl Axes {
    fn draw(&self, out: &mut String, title: &str) {
        let (left, right, bottom, top) = (self.x.from, self.x.to, self.y.from, self.y.to);
        let _ = writeln!(
            out,
            "<text x=\"{left:.1}\" y=\"{:.1}\" font-weight=\"bold\">{title}</text>",
            top - 12.0
        );
        for tick in self.y.ticks() {
            let y = self.y.place(tick);
            let _ = writeln!(
                out,
                "<line x1=\"{left:.1}\" y1=\"{y:.1}\" x2=\"{right:.1}\" y2=\"{y:.1}\" stroke=\"#e4e4e4\"/>\
                 <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"#555\">{}</text>",
                left - 7.0,
                y + 4.0,
                number(tick)
            );
        }
        for tick in self.x.ticks() {
            let x = self.x.place(tick);
            let _ = writeln!(
                out,
                "<line x1=\"{x:.1}\" y1=\"{bottom:.1}\" x2=\"{x:.1}\" y2=\"{:.1}\" stroke=\"#555\"/>\
                 <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#555\">{}</text>",
                bottom + 4.0,
                bottom + 17.0,
                number(tick)
            );
        }
        let _ = writeln!(
            out,
            "<path d=\"M{left:.1},{top:.1}V{bottom:.1}H{right:.1}\" fill=\"none\" stroke=\"#555\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#555\">entries</text>",
            (left + right) / 2.0,
            bottom + 32.0
        );
    }
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

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
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
        assert_eq!(svg.matches("<circle").count(), PANELS.len() * 3);
        assert!(svg.contains("a &lt; b &amp; c") && svg.ends_with("</svg>\n"));
        assert!(svg.contains("random hash: candidates ~ N^0.82") && svg.contains("N^0.952"));
        for (mark, most) in [("cx=\"", WIDTH), ("cy=\"", HEIGHT), ("x2=\"", WIDTH), ("y2=\"", HEIGHT)] {
            for place in svg.split(mark).skip(1) {
                let place: f64 = place.split('"').next().unwrap().parse().unwrap();
                assert!((0.0..=most).contains(&place), "{mark}{place}");
            }
        }
    }

    #[test]
    fn nothing_measured_is_no_error() {
        assert!(svg(&[]).contains("nothing measured yet"));
    }

    #[test]
    fn ticks_are_round() {
        let axis = |low, high, logarithmic| Axis { low, high, logarithmic, from: 0.0, to: 1.0 };
        assert_eq!(axis(4e3, 2e6, true).ticks(), [1e4, 3e4, 1e5, 3e5, 1e6]);
        assert_eq!(axis(4e3, 2e9, true).ticks(), [1e4, 1e5, 1e6, 1e7, 1e8, 1e9]);
        assert_eq!(axis(4e3, 6e4, true).ticks(), [5e3, 1e4, 2e4, 5e4]);
        assert_eq!(axis(0.85, 1.0, false).ticks().len(), 4);
        assert_eq!([2e4, 5e6, 0.05, 1.0].map(number), ["20 k", "5 M", "0.05", "1"]);
    }
}
