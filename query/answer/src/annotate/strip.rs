//! How probable each grasp was over the last frames, below a frame.

use std::collections::VecDeque;

use crate::canvas::{Canvas, LINE, colour};
use crate::drawn::{in_words, legend, whole_percent};
use crate::lettering::Font;
use crate::record::ClassRecord;

/// Classes that are drawn.
const MOST: usize = 6;
/// Their colours, which people who see colours differently tell apart, too (M. Okabe and K. Ito,
/// "Color Universal Design", 2008).
const COLOURS: [[u8; 3]; MOST] =
    [[230, 159, 0], [86, 180, 233], [0, 178, 130], [240, 228, 66], [233, 104, 20], [214, 131, 177]];
/// Pixels from one frame to the next.
const STEP: u32 = 2;
/// Around everything, in pixels.
const MARGIN: u32 = 8;
/// Width of a class's name and its probability.
const KEY: u32 = 216;
/// The most frames that are remembered: those of the widest drawing.
const MOST_FRAMES: usize = 1280 / STEP as usize;

/// The last frames' probabilities.
#[derive(Debug)]
pub(super) struct Strip {
    /// The classes' names.
    classes: Vec<String>,
    /// The probability of each class in each frame, the newest last; none in a frame without an
    /// answer.
    frames: VecDeque<Option<Vec<f64>>>,
}

impl Strip {
    /// In pixels.
    pub(super) const HEIGHT: u32 = 2 * MARGIN + (MOST as u32 + 1) * LINE;

    pub(super) fn new(classes: Vec<String>) -> Self {
        Self { classes, frames: VecDeque::new() }
    }

    /// Adds the newest frame's probabilities.
    pub(super) fn add(&mut self, classes: Option<&[ClassRecord]>) {
        let of = |name: &String, classes: &[ClassRecord]| {
            classes.iter().find(|class| class.grasp == *name).map_or(0.0, |class| class.probability)
        };
        let frame = classes.map(|classes| self.classes.iter().map(|name| of(name, classes)).collect());
        self.frames.push_back(frame);
        while self.frames.len() > MOST_FRAMES {
            self.frames.pop_front();
        }
    }

    /// Draws the strip over the canvas's width, from `top` down. `has_robot`: a robot's approach is
    /// drawn above.
    pub(super) fn draw(&self, canvas: &mut Canvas, top: u32, width: u32, has_robot: bool) {
        let shown = self.shown();
        let chart = (width.saturating_sub(KEY + 3 * MARGIN), MOST as u32 * LINE);
        let (x, y) = (MARGIN, top + MARGIN);
        for share in 0..=2 {
            canvas.fill((x, y + share * (chart.1 - 1) / 2), (chart.0, 1), colour::FRAME);
        }
        let columns = (chart.0 / STEP) as usize;
        let first = self.frames.len().saturating_sub(columns);
        let frames: Vec<&Option<Vec<f64>>> = self.frames.iter().skip(first).collect();
        let height = |probability: f64| f64::from(y) + (1.0 - probability) * f64::from(chart.1 - 2) + 1.0;
        for (ink, &class) in COLOURS.iter().zip(&shown) {
            for (at, pair) in frames.windows(2).enumerate() {
                let [Some(from), Some(to)] = pair else { continue };
                let column = |at: usize| f64::from(x) + (at as u32 * STEP) as f64;
                let place =
                    |at: usize, of: &[f64]| [column(at), height(of.get(class).copied().unwrap_or(0.0))];
                canvas.line(place(at, from), place(at + 1, to), 2.0, *ink);
            }
        }
        self.key(canvas, (width.saturating_sub(KEY + MARGIN), y), &shown);
        let mut marks = vec![
            (colour::GOOD, "the hand"),
            (colour::FINGERS, "fingers"),
            (colour::BACK, "back of the hand"),
        ];
        if has_robot {
            marks.push((colour::ROBOT, "robot's approach"));
        }
        legend(canvas, (MARGIN, y + chart.1 + 4), &marks);
    }

    /// The classes that are drawn, by their numbers: where there are more than can be, those that
    /// were the most probable.
    fn shown(&self) -> Vec<usize> {
        let mut classes: Vec<usize> = (0..self.classes.len()).collect();
        if classes.len() > MOST {
            let sum = |class: &usize| -> f64 {
                self.frames.iter().flatten().filter_map(|frame| frame.get(*class)).sum()
            };
            classes.sort_by(|a, b| sum(b).total_cmp(&sum(a)));
            classes.truncate(MOST);
            classes.sort_unstable();
        }
        classes
    }

    /// Each class's colour, its name and its probability now.
    fn key(&self, canvas: &mut Canvas, (x, y): (u32, u32), shown: &[usize]) {
        let now = self.frames.back().and_then(Option::as_ref);
        let most = now.and_then(|now| now.iter().copied().reduce(f64::max));
        for (row, (ink, &class)) in (0u32..).zip(COLOURS.iter().zip(shown)) {
            let y = y + row * LINE;
            let probability = now.and_then(|now| now.get(class)).copied();
            let is_first = probability.is_some() && probability == most;
            let (font, paper) =
                if is_first { (Font::STRONG, colour::INK) } else { (Font::BODY, colour::FAINT) };
            canvas.fill((x, y + 4), (12, 8), *ink);
            let share = probability.map_or_else(|| "-".to_owned(), whole_percent);
            let of_share = font.width_of(&share);
            let name = self.classes.get(class).map(|name| in_words(name)).unwrap_or_default();
            canvas.line_of((x + 20, y), KEY.saturating_sub(28 + of_share), font, &name, paper);
            canvas.text((x + KEY - of_share, y), of_share, font, &share, paper);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn classes(probabilities: &[(&str, f64)]) -> Vec<ClassRecord> {
        let record = |&(grasp, probability): &(&str, f64)| ClassRecord {
            grasp: grasp.to_owned(),
            cutkosky: 0,
            probability,
        };
        probabilities.iter().map(record).collect()
    }

    #[test]
    fn of_many_classes_the_most_probable_are_drawn_in_their_order() {
        let names: Vec<String> = (0..9).map(|class| format!("class-{class}")).collect();
        let mut strip = Strip::new(names);
        strip.add(Some(&classes(&[("class-7", 0.6), ("class-0", 0.1), ("class-8", 0.3)])));
        strip.add(None);
        assert_eq!(strip.shown(), [0, 1, 2, 3, 7, 8]);
    }

    #[test]
    fn only_what_can_be_drawn_is_remembered() {
        let mut strip = Strip::new(vec!["pinch".into()]);
        (0..2 * MOST_FRAMES).for_each(|_| strip.add(Some(&classes(&[("pinch", 1.0)]))));
        assert_eq!(strip.frames.len(), MOST_FRAMES);
        // Narrower than its key: drawn as far as it fits.
        strip.draw(&mut Canvas::new(40, Strip::HEIGHT), 0, 40, true);
    }
}
