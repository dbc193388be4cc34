//! Answers drawn into the frames of a video: the hand's outline and its axes, what it does, where
//! a robot would come from, and below the frame how probable each grasp was in the frames before.

mod strip;

use grasp_index::Index;
use grasp_recognise::Recognition;
use grasp_recognise::picture::Picture;
use grasp_recognise::segment::Mask;
use image::RgbImage;
use nalgebra::Vector3;

use crate::canvas::{Canvas, HEADLINE, LINE, colour};
use crate::drawn::{axes, in_words, whole_percent};
use crate::lettering::Font;
use crate::record::Answer;
use strip::Strip;

/// A frame is drawn at most so large, in pixels a side; larger ones are averaged down.
const MOST_SIDE: usize = 1280;
/// A frame is drawn on a canvas that is at least as wide: the strip's key needs that.
const LEAST_WIDTH: u32 = 400;
/// Left of text.
const INDENT: u32 = 8;
/// The hand's axes, as a share of the frame's height.
const AXIS: f64 = 0.16;
/// Of the robot's approach, in lengths of the hand's axes: how long its arrow is, and how far from
/// the hand's middle that ends.
const APPROACH: f64 = 1.6;
const APPROACH_ENDS: f64 = 0.25;

/// What is seen in a frame.
#[derive(Clone, Copy, Debug)]
pub enum FrameContent<'a> {
    /// A hand, and what is believed of it.
    Hand {
        /// What was found.
        found: &'a Recognition,
        /// The same as a record.
        answer: &'a Answer,
        /// The direction in which a robot's palm comes, in the camera's frame, where there is a
        /// strategy.
        approach: Option<Vector3<f64>>,
    },
    /// None, and why.
    Nothing(&'a str),
}

/// Draws the frames of a video, one after the other. All drawings have the size of the first, which
/// is that of the first picture, even in width and height, as video encoders want it.
#[derive(Debug)]
pub struct Annotator {
    strip: Strip,
    /// Width and height of the room that frames are drawn in.
    room: Option<[u32; 2]>,
    /// The frame before.
    last: Option<RgbImage>,
}

impl Annotator {
    /// Of answers by this index.
    pub fn new(index: &Index) -> Self {
        Self { strip: Strip::new(index.catalogue().class_names()), room: None, last: None }
    }

    /// Draws the next frame, the `number`-th of its source. One that cannot be decoded has no
    /// picture: the one before it stands still; `None` where there was none yet.
    pub fn draw(
        &mut self,
        number: u64,
        picture: Option<Picture>,
        seen: FrameContent<'_>,
    ) -> Option<RgbImage> {
        let shown = picture.map(image_of).or_else(|| self.last.take())?;
        let size = [shown.width(), shown.height()];
        let room =
            *self.room.get_or_insert([size[0].max(LEAST_WIDTH), size[1]].map(|v| v.next_multiple_of(2)));
        let mut canvas = Canvas::new(room[0], room[1] + Strip::HEIGHT);
        let scale = (0..2).map(|i| f64::from(room[i]) / f64::from(size[i].max(1))).fold(1.0, f64::min);
        let drawn = size.map(|v| (f64::from(v) * scale).round().max(1.0) as u32);
        let [left, top] = [0, 1].map(|i| (room[i].saturating_sub(drawn[i])) / 2);
        canvas.put_sized((left, top), drawn, &shown);
        self.last = Some(shown);

        let place = [f64::from(left), f64::from(top)];
        match seen {
            FrameContent::Hand { found, answer, approach } => {
                self.strip.add(Some(&answer.classes));
                let mask = &found.prepared.mask;
                let scale = f64::from(drawn[0]) / mask.width().max(1) as f64;
                outline(&mut canvas, (place, scale), mask);
                hand(&mut canvas, (place, scale), AXIS * f64::from(room[1]), found, approach);
                says(&mut canvas, room[0], answer);
            }
            FrameContent::Nothing(why) => {
                self.strip.add(None);
                let (first, rest) = why.split_once(": ").unwrap_or((why, ""));
                canvas.darken((0, 0), (room[0], HEADLINE + LINE));
                headed(&mut canvas, room[0], first, colour::FAINT);
                let width = room[0].saturating_sub(2 * INDENT);
                canvas.line_of((INDENT, HEADLINE), width, Font::BODY, rest, colour::FAINT);
            }
        }
        let number = format!("frame {number}");
        let width = Font::BODY.width_of(&number);
        canvas.text((room[0].saturating_sub(width + INDENT), 6), width, Font::BODY, &number, colour::FAINT);
        self.strip.draw(
            &mut canvas,
            room[1],
            room[0],
            matches!(seen, FrameContent::Hand { approach: Some(_), .. }),
        );
        Some(canvas.into_image())
    }
}

/// A picture's pixels, not too many of them.
fn image_of(picture: Picture) -> RgbImage {
    let picture = picture.shrunk_to(MOST_SIDE);
    let (width, height) = (picture.width() as u32, picture.height() as u32);
    RgbImage::from_raw(width, height, picture.rgb().as_flattened().to_vec()).unwrap_or_default()
}

/// The border of a mask, on a picture that was drawn at a place and scaled by so much.
fn outline(canvas: &mut Canvas, ([left, top], scale): ([f64; 2], f64), mask: &Mask) {
    let thick = (scale.ceil() as u32).max(2);
    for y in 0..mask.height() {
        for x in 0..mask.width() {
            let is_inside =
                |dx: usize, dy: usize| mask.get((x + dx).wrapping_sub(1), (y + dy).wrapping_sub(1));
            let is_border = is_inside(1, 1)
                && !(is_inside(0, 1) && is_inside(2, 1) && is_inside(1, 0) && is_inside(1, 2));
            if is_border {
                let at = ((left + scale * x as f64) as u32, (top + scale * y as f64) as u32);
                canvas.fill(at, (thick, thick), colour::GOOD);
            }
        }
    }
}

/// The hand's axes, and from where a robot's palm comes to it.
fn hand(
    canvas: &mut Canvas,
    placed: ([f64; 2], f64),
    length: f64,
    found: &Recognition,
    approach: Option<Vector3<f64>>,
) {
    let Some(middle) = axes(canvas, placed, length, found) else { return };
    if let Some(along) = approach {
        let at =
            |lengths: f64| [middle[0] - lengths * length * along.x, middle[1] - lengths * length * along.y];
        canvas.arrow(at(APPROACH_ENDS + APPROACH), at(APPROACH_ENDS), colour::ROBOT);
    }
}

/// What is believed, in words.
fn says(canvas: &mut Canvas, width: u32, answer: &Answer) {
    let orientation = &answer.orientation;
    let mut lines = vec![(
        format!(
            "{} hand, seen from {}, give or take {:.0}°",
            answer.hand, orientation.camera_sees, orientation.spread_deg
        ),
        colour::INK,
    )];
    let unknown = answer.reason.iter().map(|reason| (reason.clone(), colour::OTHER));
    let refused = answer.error.iter().map(|error| (format!("no strategy: {}", error.message), colour::OTHER));
    let robot = answer.strategy.iter().map(|strategy| match strategy.problems.first() {
        None => (format!("{}: {}", strategy.robot, in_words(&strategy.grasp)), colour::ROBOT),
        Some(problem) => (format!("{}: {}", strategy.robot, problem.message), colour::OTHER),
    });
    lines.extend(unknown.chain(refused).chain(robot));
    canvas.darken((0, 0), (width, HEADLINE + LINE * lines.len() as u32));
    let (verdict, ink) = match answer.cutkosky {
        Some(_) => {
            (format!("{}, {}", in_words(&answer.grasp), whole_percent(answer.probability)), colour::GOOD)
        }
        None => (in_words(&answer.grasp), colour::OTHER),
    };
    headed(canvas, width, &verdict, ink);
    for (line, (text, ink)) in (0u32..).zip(lines) {
        canvas.line_of(
            (INDENT, HEADLINE + LINE * line),
            width.saturating_sub(2 * INDENT),
            Font::BODY,
            &text,
            ink,
        );
    }
}

/// The first line.
fn headed(canvas: &mut Canvas, width: u32, text: &str, ink: [u8; 3]) {
    // The frame's number stands at the right.
    let room = width.saturating_sub(2 * INDENT + Font::BODY.width_of("frame 1234567"));
    canvas.line_of((INDENT, 4), room, Font::HEADLINE, text, ink);
}
