//! A descriptor, drawn. A pyramid is the paper's Figure 4: for each direction of edges, how much of
//! it each cell holds. An embedding is a row of shades.

use grasp_index::{DescriptorKind, DescriptorParams};

use super::measures::{GAP, MARGIN, WIDTH};
use crate::canvas::{Canvas, LINE, colour};
use crate::lettering::Font;

/// Side of a panel's finest level in pixels.
const FINE: u32 = 168;
/// Values of an embedding in a row, and the side of each in pixels.
const SHADES: u32 = 64;
const SHADE: u32 = 14;
/// Directions in a row.
const ACROSS: u32 = 4;

/// How edges lie that a bin counts: from `0.0` (level) counter-clockwise to below 180 degrees (90
/// is upright).
///
/// Where bins are soft it is their centre; the paper's hard bins begin at 0, and it is their
/// middle.
pub fn edge_deg(params: &DescriptorParams, bin: u32) -> f64 {
    let width = 180.0 / f64::from(params.bins.max(1));
    match params.kind {
        DescriptorKind::Paper => width * (f64::from(bin) + 0.5),
        _ => width * f64::from(bin),
    }
}

/// How the drawing is to be read.
pub(super) fn legend(params: &DescriptorParams) -> String {
    if params.is_learned() {
        return "What a network makes of picture 3; hands that are held and seen alike have about the \
                same numbers. Black the smallest, white the largest."
            .to_owned();
    }
    let finest = 1 << params.levels.saturating_sub(1);
    format!(
        "For each direction of edges, how much of it each cell of picture 3 holds: black none, white \
         most. Large: {finest} × {finest} cells; beside it, coarser."
    )
}

/// Pixels that [`draw`] needs from its top.
pub(super) fn height(params: &DescriptorParams) -> u32 {
    if params.is_learned() {
        return (params.dim() as u32).div_ceil(SHADES) * SHADE + GAP;
    }
    params.bins.div_ceil(ACROSS) * (LINE + FINE + GAP)
}

/// Draws the panels below `top`: a direction each, its coarser levels beside its finest one.
pub(super) fn draw(canvas: &mut Canvas, top: u32, params: &DescriptorParams, descriptor: &[f32]) {
    if params.is_learned() {
        return draw_embedding(canvas, top, descriptor);
    }
    let step = (WIDTH - 2 * MARGIN + GAP) / ACROSS;
    let place = |bin: u32| (MARGIN + bin % ACROSS * step, top + bin / ACROSS * (LINE + FINE + GAP));
    for bin in 0..params.bins {
        let (x, y) = place(bin);
        let degrees = edge_deg(params, bin);
        let (sin, cos) = degrees.to_radians().sin_cos();
        let (centre, reach) = ([f64::from(x) + 9.0, f64::from(y) + 8.0], 8.0);
        let end = |sign: f64| [centre[0] + sign * reach * cos, centre[1] - sign * reach * sin];
        canvas.line(end(-1.0), end(1.0), 3.0, colour::INK);
        let lie = match degrees {
            0.0 => " (level)",
            90.0 => " (upright)",
            _ => "",
        };
        let title = format!("edges at {}°{lie}", (10.0 * degrees).round() / 10.0);
        canvas.text((x + 26, y), step - 26, Font::BODY, &title, colour::INK);
    }
    let largest_of = |level: u32| {
        let cells = params.cells(descriptor).filter(|cell| cell.level == level);
        cells.flat_map(|cell| cell.histogram.iter().copied()).fold(f32::MIN_POSITIVE, f32::max)
    };
    let largest: Vec<f32> = (1..=params.levels).map(largest_of).collect();
    for cell in params.cells(descriptor) {
        // Each coarser level is drawn at half the side, to the right of the finest and below the
        // one before.
        let side = FINE >> (cell.level - 1).min(7);
        let (shift, drop) = match cell.level {
            1 => (0, 0),
            _ => (FINE + GAP / 2, FINE - (side << 1).min(FINE)),
        };
        let cell_side = (side / cell.cells_a_side.max(1) as u32).max(2);
        let scale = largest.get(cell.level as usize - 1).copied().unwrap_or(1.0);
        for (bin, &value) in (0u32..).zip(cell.histogram) {
            let shade = (255.0 * (value / scale).clamp(0.0, 1.0)) as u8;
            let (left, upper) = place(bin);
            let x = left + shift + cell.column as u32 * cell_side;
            let y = upper + LINE + drop + cell.row as u32 * cell_side;
            canvas.fill((x, y), (cell_side - 1, cell_side - 1), [shade; 3]);
        }
    }
}

/// Draws all values in rows, between the smallest and the largest.
fn draw_embedding(canvas: &mut Canvas, top: u32, descriptor: &[f32]) {
    let smallest = descriptor.iter().copied().fold(f32::INFINITY, f32::min);
    let largest = descriptor.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    for (at, &value) in (0u32..).zip(descriptor) {
        let share = (value - smallest) / (largest - smallest).max(f32::MIN_POSITIVE);
        let place = (MARGIN + at % SHADES * SHADE, top + at / SHADES * SHADE);
        canvas.fill(place, (SHADE - 1, SHADE - 1), [(255.0 * share) as u8; 3]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn soft_bins_are_named_by_their_centre_and_hard_ones_by_their_middle() {
        let degrees = |params: DescriptorParams| (0..4).map(|bin| edge_deg(&params, bin)).collect::<Vec<_>>();
        assert_eq!(degrees(DescriptorParams::default()), [0.0, 45.0, 90.0, 135.0]);
        assert_eq!(degrees(DescriptorParams::paper()), [22.5, 67.5, 112.5, 157.5]);
    }
}
