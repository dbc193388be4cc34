//! The page that everything is drawn on.

use plotters::coord::Shift;
use plotters::element::{DashedPathElement, PathElement, Rectangle};
use plotters::prelude::{Color as _, DrawingArea, FontStyle, IntoDrawingArea as _, RGBColor, SVGBackend};
use plotters::style::text_anchor::HPos;

use crate::axis::Axis;
use crate::chart::{Chart, chart};
use crate::look::{DASH, FAINT, FINE, GAP, INK, WHITE, letters, pixels, stroke, words};
use crate::sure::sure;

/// How wide every page is, in units.
pub const WIDTH: f64 = 1080.0;

/// A page; places on it are `[x, y]` in units, from its upper left corner.
pub struct Page<'b> {
    area: DrawingArea<SVGBackend<'b>, Shift>,
}

/// An SVG of [`WIDTH`] by `height` with a title, a line below it, and what `content` draws.
pub fn draw(height: f64, title: &str, below: &str, content: impl FnOnce(&Page<'_>)) -> String {
    let mut svg = String::new();
    let size = [WIDTH, height].map(|units| pixels(units).unsigned_abs());
    let page = Page { area: SVGBackend::with_string(&mut svg, size.into()).into_drawing_area() };
    sure(page.area.fill(&WHITE));
    let large = letters(INK, 17.0, HPos::Left, FontStyle::Normal);
    sure(page.area.draw_text(title, &large, place([20.0, 22.0])));
    page.text([20.0, 43.0], HPos::Left, FAINT, below);
    content(&page);
    sure(page.area.present());
    drop(page);
    // Finely drawn, and shown at its size.
    let fine = format!("width=\"{}\" height=\"{}\"", size[0], size[1]);
    svg.replacen(&fine, &format!("width=\"{WIDTH}\" height=\"{height}\""), 1)
}

impl<'b> Page<'b> {
    /// A line of text, fastened at the middle of its height.
    pub fn text(&self, at: [f64; 2], anchor: HPos, colour: RGBColor, text: &str) {
        sure(self.area.draw_text(text, &words(colour, anchor), place(at)));
    }

    /// A line of bold text, beginning there.
    pub fn heading(&self, at: [f64; 2], text: &str) {
        let bold = letters(INK, 12.0, HPos::Left, FontStyle::Bold);
        sure(self.area.draw_text(text, &bold, place(at)));
    }

    /// A rectangle from its upper left corner, so broad and so high.
    pub fn rectangle(&self, [x, y]: [f64; 2], [breadth, height]: [f64; 2], colour: RGBColor) {
        let corners = [place([x, y]), place([x + breadth, y + height])];
        sure(self.area.draw(&Rectangle::new(corners, colour.filled())));
    }

    /// A short line and what it stands for; returns where the next may begin.
    pub fn key(&self, [x, y]: [f64; 2], colour: RGBColor, is_dashed: bool, text: &str) -> f64 {
        let (line, style) = ([place([x, y]), place([x + 26.0, y])], stroke(colour, 2.0));
        sure(match is_dashed {
            true => self.area.draw(&DashedPathElement::new(line, pixels(DASH), pixels(GAP), style)),
            false => self.area.draw(&PathElement::new(line, style)),
        });
        self.text([x + 32.0, y], HPos::Left, INK, text);
        x + 60.0 + 6.2 * text.chars().count() as f64
    }

    /// A chart with its title above and the name of the x axis below; its values lie between
    /// `[left, right]` and `[bottom, top]`.
    pub fn chart<'a>(
        &'a self,
        horizontal: [f64; 2],
        vertical: [f64; 2],
        title: &str,
        below: &str,
        axes: [Axis; 2],
    ) -> Chart<'a, 'b> {
        self.heading([horizontal[0], vertical[1] - 18.0], title);
        let height = f64::from(self.area.dim_in_pixel().1) / FINE;
        let margins = [horizontal[0], vertical[1], WIDTH - horizontal[1], height - vertical[0]];
        chart(&self.area, margins, below, axes)
    }
}

fn place(at: [f64; 2]) -> (i32, i32) {
    at.map(pixels).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_from_outside_are_escaped() {
        let svg = draw(100.0, "a < b", "c & d", |_| {});
        assert!(svg.contains("a &lt; b") && svg.contains("c &amp; d"), "{svg}");
        assert!(svg.starts_with("<svg width=\"1080\" height=\"100\" viewBox=\"0 0 10800 1000\""), "{svg}");
        assert!(svg.ends_with("</svg>\n"));
    }
}
