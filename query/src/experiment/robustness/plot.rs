//! Heat maps of the trials, as SVG.

use super::super::svg::{Anchor, FAINT, Svg, WIDTH};
use super::sweep::{ENGINE, Robustness, Tolerance};
use super::table::Row;

/// Above the panels, a panel's height and breadth, and how large its map is.
const HEAD: f64 = 92.0;
const ROW: f64 = 330.0;
const PANELS: usize = 4;
const MAP: f64 = 200.0;
/// Held, lifted but lost, not lifted: told apart by the colour-blind.
const HELD: &str = "#0072b2";
const LOST: &str = "#e69f00";
const MISSED: &str = "#dddddd";

/// The picture.
pub(super) fn svg(robustness: &Robustness) -> String {
    let rows = robustness.tolerances.len().div_ceil(PANELS);
    let mut svg = Svg::new(
        HEAD + ROW * rows as f64,
        &format!("How far the hand may be off ({})", robustness.robot),
        &format!(
            "a cell is a trial by {ENGINE}: the object lies beside where the hand takes it to be, or (strip) the hand is turned"
        ),
    );
    let mut x = 20.0;
    for (colour, text) in [(HELD, "lifted and held"), (LOST, "lifted, but slipped"), (MISSED, "not lifted")] {
        square(&mut svg, [x, 62.0], 12.0, colour);
        svg.text([x + 18.0, 72.0], Anchor::Start, "#222", text);
        x += 150.0;
    }
    let breadth = (WIDTH - 40.0) / PANELS as f64;
    for (at, tolerance) in robustness.tolerances.iter().enumerate() {
        let left = 50.0 + breadth * (at % PANELS) as f64;
        let top = HEAD + ROW * (at / PANELS) as f64 + 30.0;
        panel(&mut svg, [left, top], tolerance, &robustness.rows);
    }
    svg.finish()
}

fn panel(svg: &mut Svg, [left, top]: [f64; 2], tolerance: &Tolerance, rows: &[Row]) {
    svg.heading([left, top - 10.0], &format!("{}: {}", tolerance.object, tolerance.grasp));
    let own = || rows.iter().filter(|row| row.object == tolerance.object);
    let grid: Vec<&Row> = own().filter(|row| row.yaw_deg == 0).collect();
    let places = sorted(grid.iter().map(|row| row.x_mm));
    let cell = MAP / places.len().max(1) as f64;
    for row in &grid {
        let place = |mm: i32| places.iter().position(|other| *other == mm).unwrap_or_default() as f64;
        let at = [left + cell * place(row.x_mm), top + MAP - cell * (place(row.y_mm) + 1.0)];
        square(svg, at, cell - 1.0, colour(row));
    }
    if let (Some(least), Some(most)) = (places.first(), places.last()) {
        svg.text([left, top + MAP + 14.0], Anchor::Start, FAINT, &format!("x {least} mm"));
        svg.text([left + MAP, top + MAP + 14.0], Anchor::End, FAINT, &format!("{most} mm"));
        svg.text([left - 4.0, top + 10.0], Anchor::End, FAINT, "y");
    }
    let line: Vec<&Row> = own().filter(|row| row.x_mm == 0 && row.y_mm == 0).collect();
    let yaws = sorted(line.iter().map(|row| row.yaw_deg));
    let cell = MAP / yaws.len().max(1) as f64;
    for row in &line {
        let place = yaws.iter().position(|yaw| *yaw == row.yaw_deg).unwrap_or_default() as f64;
        let (x, y) = (left + cell * place, top + MAP + 26.0);
        let (breadth, colour) = (cell - 1.0, colour(row));
        svg.element(format_args!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{breadth:.1}\" height=\"14\" fill=\"{colour}\"/>"
        ));
    }
    if let (Some(least), Some(most)) = (yaws.first(), yaws.last()) {
        svg.text([left, top + MAP + 54.0], Anchor::Start, FAINT, &format!("yaw {least}°"));
        svg.text([left + MAP, top + MAP + 54.0], Anchor::End, FAINT, &format!("{most}°"));
    }
    let window = |most: Option<i32>, unit: &str| most.map_or("none".into(), |most| format!("±{most}{unit}"));
    let windows =
        format!("window {}, yaw {}", window(tolerance.position_mm, " mm"), window(tolerance.yaw_deg, "°"));
    svg.text([left, top + MAP + 72.0], Anchor::Start, "#222", &windows);
}

fn sorted(values: impl Iterator<Item = i32>) -> Vec<i32> {
    let mut values: Vec<i32> = values.collect();
    values.sort_unstable();
    values.dedup();
    values
}

fn colour(row: &Row) -> &'static str {
    match (row.success, row.lifted) {
        (true, _) => HELD,
        (false, true) => LOST,
        (false, false) => MISSED,
    }
}

fn square(svg: &mut Svg, [x, y]: [f64; 2], side: f64, colour: &str) {
    svg.element(format_args!(
        "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{side:.1}\" height=\"{side:.1}\" fill=\"{colour}\"/>"
    ));
}
