//! Heat maps of the trials, as SVG.

use grasp_plot::{Anchor, COLOURS, Colour, FAINT, INK, Page, WIDTH, draw};

use super::sweep::{ENGINE, Robustness, Tolerance};
use super::table::Row;

/// Above the panels, a panel's height and breadth, and how large its map is.
const HEAD: f64 = 92.0;
const ROW: f64 = 330.0;
const PANELS: usize = 4;
const MAP: f64 = 200.0;
/// Held, lifted but lost, not lifted: told apart by the colour-blind.
const HELD: Colour = COLOURS[0];
const LOST: Colour = Colour(0xe6, 0x9f, 0x00);
const MISSED: Colour = Colour(0xdd, 0xdd, 0xdd);

/// The picture.
pub(super) fn svg(robustness: &Robustness) -> String {
    let rows = robustness.tolerances.len().div_ceil(PANELS);
    let title = format!("How far the hand may be off ({})", robustness.robot);
    let below = format!(
        "a cell is a trial by {ENGINE}: the object lies beside where the hand takes it to be, or (strip) the hand is turned"
    );
    draw(HEAD + ROW * rows as f64, &title, &below, |page| {
        let mut x = 20.0;
        for (colour, text) in
            [(HELD, "lifted and held"), (LOST, "lifted, but slipped"), (MISSED, "not lifted")]
        {
            page.rectangle([x, 62.0], [12.0; 2], colour);
            page.text([x + 18.0, 68.0], Anchor::Left, INK, text);
            x += 150.0;
        }
        let breadth = (WIDTH - 40.0) / PANELS as f64;
        for (at, tolerance) in robustness.tolerances.iter().enumerate() {
            let left = 50.0 + breadth * (at % PANELS) as f64;
            let top = HEAD + ROW * (at / PANELS) as f64 + 30.0;
            panel(page, [left, top], tolerance, &robustness.rows);
        }
    })
}

fn panel(page: &Page<'_>, [left, top]: [f64; 2], tolerance: &Tolerance, rows: &[Row]) {
    page.heading([left, top - 14.0], &format!("{}: {}", tolerance.object, tolerance.grasp));
    let (right, bottom) = (left + MAP, top + MAP);
    let own = || rows.iter().filter(|row| row.object == tolerance.object);
    let grid: Vec<&Row> = own().filter(|row| row.yaw_deg == 0).collect();
    let places = sorted(grid.iter().map(|row| row.x_mm));
    let cell = MAP / places.len().max(1) as f64;
    for row in &grid {
        let place = |mm: i32| places.iter().position(|other| *other == mm).unwrap_or_default() as f64;
        let at = [left + cell * place(row.x_mm), bottom - cell * (place(row.y_mm) + 1.0)];
        page.rectangle(at, [cell - 1.0; 2], colour(row));
    }
    if let (Some(least), Some(most)) = (places.first(), places.last()) {
        page.text([left, bottom + 10.0], Anchor::Left, FAINT, &format!("x {least} mm"));
        page.text([right, bottom + 10.0], Anchor::Right, FAINT, &format!("{most} mm"));
        page.text([left - 4.0, top + 6.0], Anchor::Right, FAINT, "y");
    }
    let line: Vec<&Row> = own().filter(|row| row.x_mm == 0 && row.y_mm == 0).collect();
    let yaws = sorted(line.iter().map(|row| row.yaw_deg));
    let cell = MAP / yaws.len().max(1) as f64;
    for row in &line {
        let place = yaws.iter().position(|yaw| *yaw == row.yaw_deg).unwrap_or_default() as f64;
        page.rectangle([left + cell * place, bottom + 26.0], [cell - 1.0, 14.0], colour(row));
    }
    if let (Some(least), Some(most)) = (yaws.first(), yaws.last()) {
        page.text([left, bottom + 50.0], Anchor::Left, FAINT, &format!("yaw {least}°"));
        page.text([right, bottom + 50.0], Anchor::Right, FAINT, &format!("{most}°"));
    }
    let window = |most: Option<i32>, unit: &str| most.map_or("none".into(), |most| format!("±{most}{unit}"));
    let windows =
        format!("window {}, yaw {}", window(tolerance.position_mm, " mm"), window(tolerance.yaw_deg, "°"));
    page.text([left, bottom + 68.0], Anchor::Left, INK, &windows);
}

fn sorted(values: impl Iterator<Item = i32>) -> Vec<i32> {
    let mut values: Vec<i32> = values.collect();
    values.sort_unstable();
    values.dedup();
    values
}

fn colour(row: &Row) -> Colour {
    match (row.success, row.lifted) {
        (true, _) => HELD,
        (false, true) => LOST,
        (false, false) => MISSED,
    }
}
