//! Colours, letters, and how units become the whole numbers that plotters has for places.

use plotters::prelude::{Color as _, FontStyle, IntoFont as _, RGBColor, ShapeStyle, TextStyle};
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// The ground.
pub const WHITE: RGBColor = RGBColor(255, 255, 255);
/// What stands beside the data.
pub const GREY: RGBColor = RGBColor(0x88, 0x88, 0x88);
/// Words beside the data, and the axes.
pub const FAINT: RGBColor = RGBColor(0x55, 0x55, 0x55);
/// Other words.
pub const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
/// Four curves, which colour-blind people tell apart as well (Okabe and Ito 2008).
pub const COLOURS: [RGBColor; 4] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
];
/// The lines behind the data.
pub(crate) const PALE: RGBColor = RGBColor(0xe4, 0xe4, 0xe4);

/// How long a dash is, in units.
pub(crate) const DASH: f64 = 5.0;
/// How long the gap after it.
pub(crate) const GAP: f64 = 4.0;

/// How many of plotters' pixels are a unit.
pub(crate) const FINE: f64 = 10.0;
/// plotters' SVG divides the sizes of letters by that.
const SHRINKS: f64 = 1.24;

/// Units as pixels.
pub(crate) fn pixels(units: f64) -> i32 {
    (units * FINE).round() as i32
}

/// A line of this width in units.
pub(crate) fn stroke(colour: RGBColor, units: f64) -> ShapeStyle {
    colour.stroke_width(pixels(units).unsigned_abs())
}

/// Letters of a size in units, fastened at the middle of their height.
pub(crate) fn letters(colour: RGBColor, size: f64, anchor: HPos, style: FontStyle) -> TextStyle<'static> {
    let font = ("Helvetica, Arial, sans-serif", size * SHRINKS * FINE).into_font().style(style);
    TextStyle { font, color: colour.to_backend_color(), pos: Pos::new(anchor, VPos::Center) }
}

/// Letters of the usual size.
pub(crate) fn words(colour: RGBColor, anchor: HPos) -> TextStyle<'static> {
    letters(colour, 12.0, anchor, FontStyle::Normal)
}
