//! Drawings of results as SVG, in one look for both programs: white ground, thin grey axes, and
//! colours that the colour-blind tell apart. No font is needed until somebody looks at one.

mod axis;
mod chart;
mod look;
mod page;
mod sure;

pub use axis::Axis;
pub use chart::Chart;
pub use look::{COLOURS, FAINT, GREY, INK, WHITE};
pub use page::{Page, WIDTH, draw};
pub use plotters::style::RGBColor as Colour;
pub use plotters::style::text_anchor::HPos as Anchor;
