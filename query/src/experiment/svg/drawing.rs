//! A drawing that grows by lines and texts.

use std::fmt::{self, Write as _};

/// How wide every drawing is.
pub(in crate::experiment) const WIDTH: f64 = 1080.0;
/// What the paper says.
pub(in crate::experiment) const GREY: &str = "#888";
/// Words beside the data.
pub(in crate::experiment) const FAINT: &str = "#555";
/// Three curves.
pub(in crate::experiment) const COLOURS: [&str; 3] = ["#0072b2", "#d55e00", "#009e73"];

/// A drawing that grows.
#[derive(Debug)]
pub(in crate::experiment) struct Svg {
    text: String,
}

/// Where a text is fastened.
#[derive(Clone, Copy, Debug)]
pub(in crate::experiment) enum Anchor {
    Start,
    Middle,
    End,
}

impl Svg {
    /// A drawing of [`WIDTH`] by `height` with a title and a line below it.
    pub(in crate::experiment) fn new(height: f64, title: &str, below: &str) -> Self {
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" viewBox=\"0 0 {WIDTH} {height}\" \
             font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\" fill=\"#222\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
        );
        let mut svg = Self { text };
        svg.element(format_args!("<text x=\"20\" y=\"28\" font-size=\"17\">{}</text>", escaped(title)));
        svg.text([20.0, 47.0], Anchor::Start, FAINT, below);
        svg
    }

    /// The whole drawing.
    pub(in crate::experiment) fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }

    /// An element as it is written.
    pub(in crate::experiment) fn element(&mut self, element: fmt::Arguments<'_>) {
        // Writing to a String cannot fail.
        let _ = self.text.write_fmt(element);
        self.text.push('\n');
    }

    /// A line of text.
    pub(in crate::experiment) fn text(&mut self, [x, y]: [f64; 2], anchor: Anchor, colour: &str, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let text = escaped(text);
        self.element(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{colour}\">{text}</text>"
        ));
    }

    /// A line of bold text.
    pub(in crate::experiment) fn heading(&mut self, [x, y]: [f64; 2], text: &str) {
        let text = escaped(text);
        self.element(format_args!("<text x=\"{x:.1}\" y=\"{y:.1}\" font-weight=\"bold\">{text}</text>"));
    }

    /// A line through points, dashed where `dashes` are given.
    pub(in crate::experiment) fn line(
        &mut self,
        points: impl IntoIterator<Item = [f64; 2]>,
        colour: &str,
        dashes: Option<&str>,
    ) {
        let points: Vec<String> = points.into_iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        let dashes = dashes.map(|dashes| format!(" stroke-dasharray=\"{dashes}\"")).unwrap_or_default();
        self.element(format_args!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"{dashes}/>",
            points.join(" ")
        ));
    }

    /// A short line and what it stands for; returns where the next may begin.
    pub(in crate::experiment) fn key(
        &mut self,
        [x, y]: [f64; 2],
        colour: &str,
        dashes: Option<&str>,
        text: &str,
    ) -> f64 {
        self.line([[x, y], [x + 26.0, y]], colour, dashes);
        self.text([x + 32.0, y + 4.0], Anchor::Start, "#222", text);
        x + 60.0 + 6.2 * text.chars().count() as f64
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

#[cfg(test)]
pub(in crate::experiment) mod tests {
    use super::*;

    /// Whether every coordinate lies within the drawing's width and its own stated height.
    pub(in crate::experiment) fn assert_inside(svg: &str) {
        let number = |text: &str| text.split('"').next().unwrap().parse::<f64>().unwrap();
        let height = number(svg.split("height=\"").nth(1).unwrap());
        let marks = [(" x=\"", WIDTH), (" cx=\"", WIDTH), (" y=\"", height), (" cy=\"", height)];
        for (mark, most) in marks {
            for place in svg.split(mark).skip(1).map(number) {
                assert!((0.0..=most).contains(&place), "{mark}{place}");
            }
        }
        for points in svg.split("points=\"").skip(1).filter_map(|text| text.split('"').next()) {
            for [x, y] in points.split_whitespace().map(|point| {
                let (x, y) = point.split_once(',').unwrap();
                [number(x), number(y)]
            }) {
                assert!((0.0..=WIDTH).contains(&x) && (0.0..=height).contains(&y), "{x},{y}");
            }
        }
        assert!(svg.ends_with("</svg>\n"));
    }

    #[test]
    fn names_from_outside_are_escaped() {
        let svg = Svg::new(100.0, "a < b", "c & d").finish();
        assert!(svg.contains("a &lt; b") && svg.contains("c &amp; d"));
        assert_inside(&svg);
    }
}
