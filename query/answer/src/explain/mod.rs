//! One sheet that shows how an answer came about, for somebody who has read nothing else: the
//! picture, the hand in it, the hand image, the vote, the descriptor as the paper's Figure 4 and
//! the nearest neighbours as its Figure 5.

mod descriptor;
mod file;
mod measures;

use grasp_index::Index;
use grasp_terminal::text::counted;
use image::{Rgb, RgbImage};

use crate::canvas::{Canvas, HEADLINE, LINE, colour};
use crate::drawn::{axes, in_words, legend, whole_percent};
use crate::lettering::Font;
use crate::record::Answer;
pub use descriptor::edge_deg;
pub use file::{Format, SaveError, save};
use grasp_recognise::{Context, Recognition, Side};
use measures::{GAP, LARGE, MARGIN, WIDTH};

/// Pixels of a hand's axis in the picture.
const AXIS: f64 = 80.0;
/// Above a part's title.
const APART: u32 = 22;
/// Width of a line of text.
const TEXT: u32 = WIDTH - 2 * MARGIN;
/// Neighbours in a row.
const ACROSS: u32 = 8;
/// Side of a neighbour's picture.
const SMALL: u32 = (TEXT - (ACROSS - 1) * GAP) / ACROSS;
/// From one row of neighbours to the next: a picture and four lines.
const ROW: u32 = SMALL + 4 * LINE + GAP;
/// Neighbours that are drawn, however many vote.
const MOST_NEIGHBOURS: usize = 3 * ACROSS as usize;
/// Classes that are drawn, however many there are.
const MOST_CLASSES: usize = 10;

/// Draws an answer.
pub fn draw(found: &Recognition, answer: &Answer, index: &Index) -> RgbImage {
    let params = &index.catalogue().descriptor;
    let head = Head::new(answer);
    let inputs_at = MARGIN + head.height() + APART;
    let descriptor_at = inputs_at + LINE + LARGE + 2 * LINE + APART;
    let neighbours_at = descriptor_at + 2 * LINE + descriptor::height(params) + APART;
    let rows = (answer.neighbours.len().min(MOST_NEIGHBOURS) as u32).div_ceil(ACROSS);
    let mut canvas = Canvas::new(WIDTH, neighbours_at + 2 * LINE + rows * ROW + MARGIN);

    head.draw(&mut canvas);
    inputs(&mut canvas, inputs_at, found);
    vote(&mut canvas, (column(3), inputs_at), found, answer);
    let title = format!("5  The hand as the {} numbers that are compared", found.best.descriptor.len());
    titled(&mut canvas, (MARGIN, descriptor_at), &title, &descriptor::legend(params));
    descriptor::draw(&mut canvas, descriptor_at + 2 * LINE, params, &found.best.descriptor);
    neighbours(&mut canvas, neighbours_at, found, answer, index);
    canvas.into_image()
}

/// What is said above all pictures.
struct Head {
    verdict: String,
    lines: Vec<(String, [u8; 3])>,
}

impl Head {
    fn new(answer: &Answer) -> Self {
        let verdict = match answer.cutkosky {
            Some(cutkosky) => {
                let name = in_words(&answer.grasp);
                format!("{name}, {}   (Cutkosky's grasp {cutkosky})", whole_percent(answer.probability))
            }
            None => in_words(&answer.grasp),
        };
        let orientation = &answer.orientation;
        let pose = format!(
            "A {} hand. The camera sees {}, the fingers point {}, give or take {:.0}°.",
            answer.hand, orientation.camera_sees, orientation.fingers_point, orientation.spread_deg,
        );
        let mut lines = vec![(pose, colour::INK)];
        for notice in notices(answer) {
            let wrapped = Font::BODY.wrap(&notice, TEXT);
            lines.extend(wrapped.into_iter().map(|line| (line, colour::OTHER)));
        }
        let frame = answer.frame.map(|frame| format!(", frame {frame}")).unwrap_or_default();
        lines.push((format!("{}{frame}", answer.file), colour::FAINT));
        Self { verdict: capitalised(&verdict), lines }
    }

    fn height(&self) -> u32 {
        HEADLINE + self.lines.len() as u32 * LINE
    }

    fn draw(&self, canvas: &mut Canvas) {
        canvas.text((MARGIN, MARGIN), TEXT, Font::HEADLINE, &self.verdict, colour::INK);
        for (line, (text, ink)) in (0u32..).zip(&self.lines) {
            canvas.text((MARGIN, MARGIN + HEADLINE + line * LINE), TEXT, Font::BODY, text, *ink);
        }
    }
}

/// What speaks against the answer.
fn notices(answer: &Answer) -> Vec<String> {
    let unknown = answer.reason.iter().map(|reason| format!("Unknown: {reason}."));
    unknown.chain(answer.warnings.iter().map(|warning| format!("Beware: {}.", warning.message))).collect()
}

/// A part's title and the line below that says how to read it.
fn titled(canvas: &mut Canvas, (x, y): (u32, u32), title: &str, legend: &str) {
    canvas.text((x, y), WIDTH - MARGIN - x, Font::STRONG, title, colour::INK);
    canvas.text((x, y + LINE), WIDTH - MARGIN - x, Font::BODY, legend, colour::FAINT);
}

/// Where a column of large pictures begins.
fn column(n: u32) -> u32 {
    MARGIN + n * (LARGE + GAP)
}

/// The picture, the hand in it and the hand alone, side by side.
fn inputs(canvas: &mut Canvas, top: u32, found: &Recognition) {
    let (picture, mask) = (&found.prepared.picture, &found.prepared.mask);
    let hand = &found.best.described_image(&found.hand_image);
    let (width, height) = (picture.width(), picture.height());
    let pixels = |colour_at: &dyn Fn(usize, usize) -> [u8; 3]| {
        RgbImage::from_fn(width as u32, height as u32, |x, y| Rgb(colour_at(x as usize, y as usize)))
    };
    let seen = |x: usize, y: usize| picture.rgb().get(y * width + x).copied().unwrap_or_default();
    let forearm = |x: usize, y: usize| found.prepared.skin.as_ref().is_some_and(|skin| skin.get(x, y));
    let masked = |x: usize, y: usize| {
        let [r, g, b] = seen(x, y);
        match (mask.get(x, y), forearm(x, y)) {
            (true, _) => [r / 2, g / 2 + 110, b / 2],
            (false, true) => [r / 2 + 127, g / 2, b / 2],
            (false, false) => [r / 3, g / 3, b / 3],
        }
    };
    let has_forearm = (0..height).any(|y| (0..width).any(|x| forearm(x, y) && !mask.get(x, y)));
    let below = top + LINE + LARGE + 4;
    let title = |canvas: &mut Canvas, n: u32, text: &str| {
        canvas.text((column(n), top), LARGE, Font::STRONG, text, colour::INK);
    };
    let note = |canvas: &mut Canvas, n: u32, text: &str| {
        for (line, text) in (0u32..).zip(Font::BODY.wrap(text, LARGE)) {
            canvas.text((column(n), below + line * LINE), LARGE, Font::BODY, &text, colour::FAINT);
        }
    };

    title(canvas, 0, "1  The picture");
    canvas.picture((column(0), top + LINE), LARGE, &pixels(&seen), colour::PAPER);
    note(canvas, 0, &format!("at the size that is looked at, {width} × {height}"));

    title(canvas, 1, "2  The hand in it");
    let placed = canvas.picture((column(1), top + LINE), LARGE, &pixels(&masked), colour::PAPER);
    axes(canvas, placed, AXIS, found);
    let mut swatches = vec![([70, 190, 70], "hand")];
    if has_forearm {
        swatches.push(([200, 60, 60], "forearm, cut off"));
    }
    legend(canvas, (column(1), below), &swatches);
    let arrows = [(colour::FINGERS, "fingers"), (colour::BACK, "back of the hand")];
    legend(canvas, (column(1), below + LINE), &arrows);

    title(canvas, 2, "3  The hand alone");
    let size = (hand.width() as u32, hand.height() as u32);
    let alone = RgbImage::from_fn(size.0, size.1, |x, y| {
        let at = y as usize * hand.width() + x as usize;
        Rgb([hand.pixels().get(at).copied().unwrap_or(0); 3])
    });
    canvas.picture((column(2), top + LINE), LARGE, &alone, [0; 3]);
    let mut how = "in grey, as it is compared".to_owned();
    if found.best.side == Side::Left {
        how.push_str(", flipped to a right hand");
    }
    how.push_str(&turned(found.best.roll_deg));
    note(canvas, 2, &how);
}

/// The classes' probabilities as bars.
fn vote(canvas: &mut Canvas, (x, top): (u32, u32), found: &Recognition, answer: &Answer) {
    canvas.text((x, top), LARGE, Font::STRONG, "4  The vote", colour::INK);
    let shown = answer.classes.len().min(MOST_CLASSES);
    let step = LARGE / (shown.max(6) as u32);
    for (place, class) in (0u32..).zip(answer.classes.iter().take(shown)) {
        let y = top + LINE + place * step;
        let is_answer = class.grasp == answer.grasp;
        let (font, ink) = if is_answer { (Font::STRONG, colour::GOOD) } else { (Font::BODY, colour::FAINT) };
        let share = whole_percent(class.probability);
        let room = LARGE - font.width_of(&share) - GAP;
        canvas.text((x, y), room, font, &in_words(&class.grasp), colour::INK);
        canvas.text((x + LARGE - font.width_of(&share), y), LARGE, font, &share, colour::INK);
        canvas.fill((x, y + LINE), (LARGE, 8), colour::FRAME);
        canvas.fill((x, y + LINE), ((f64::from(LARGE) * class.probability) as u32, 8), ink);
    }
    let below = top + LINE + LARGE + 4;
    // A learned descriptor's network says how far a grasp is closed, and the scene networks what
    // they see in a camera picture.
    let by = match answer.stages.is_some() || found.prepared.scene.is_some() {
        false => "how near the neighbours of part 6 are",
        true => "the neighbours of part 6 and what networks see",
    };
    let besides = match found.context {
        Context::Nothing => "",
        Context::Object => ", times the prior",
        Context::Frames => ", in all frames so far",
    };
    let note = format!("the probability of each grasp, by {by}{besides}");
    for (line, text) in (0u32..).zip(Font::BODY.wrap(&note, LARGE)) {
        canvas.text((x, below + line * LINE), LARGE, Font::BODY, &text, colour::FAINT);
    }
}

/// The paper's Figure 5: the nearest entries with their class, distance and view.
fn neighbours(canvas: &mut Canvas, top: u32, found: &Recognition, answer: &Answer, index: &Index) {
    let voted = answer.neighbours.len();
    let shown = voted.min(MOST_NEIGHBOURS);
    let first =
        if shown < voted { format!(": the first {shown} of {voted} that vote") } else { String::new() };
    let views = counted(index.len(), ["view", "views"]);
    let title = format!("6  The nearest of {views} that the index knows{first}");
    canvas.text((MARGIN, top), TEXT, Font::STRONG, &title, colour::INK);
    let how = "distance: 0 is the same hand image; round, up: where the camera stood; last: whose hand, how far closed";
    let colours = [(colour::GOOD, "the answer's grasp"), (colour::OTHER, "another grasp")];
    // An answer that is unknown has no grasp that a neighbour could share.
    let colours = if answer.cutkosky.is_some() { &colours[..] } else { &[] };
    let x = legend(canvas, (MARGIN, top + LINE), colours);
    canvas.text((x, top + LINE), TEXT - x, Font::BODY, how, colour::FAINT);
    let side = index.catalogue().thumbnail_side;
    for (place, neighbour) in (0u32..).zip(answer.neighbours.iter().take(MOST_NEIGHBOURS)) {
        let x = MARGIN + place % ACROSS * (SMALL + GAP);
        let y = top + 2 * LINE + 4 + place / ACROSS * ROW;
        let thumbnail = index.thumbnail(neighbour.id).unwrap_or_default();
        let picture = RgbImage::from_fn(side, side, |tx, ty| {
            Rgb([thumbnail.get((ty * side + tx) as usize).copied().unwrap_or(0); 3])
        });
        canvas.picture((x, y), SMALL, &picture, [0; 3]);
        let mut lines = vec![(format!("distance {:.3}", neighbour.distance), colour::INK)];
        let entry = found.best.neighbours.get(place as usize).and_then(|n| index.entry(n.id).ok());
        if let Some([azimuth, elevation, _]) = entry.and_then(|entry| entry.view_deg) {
            let (up, height) = if elevation < 0.0 { ("down", -elevation) } else { ("up", elevation) };
            lines.push((format!("{azimuth:.0}° round, {height:.0}° {up}"), colour::INK));
        }
        let of: Vec<&str> = [neighbour.hand_shape.as_str(), &neighbour.stage]
            .into_iter()
            .filter(|word| !word.is_empty())
            .collect();
        lines.push((of.join(", "), colour::FAINT));
        let ink = match answer.cutkosky {
            None => colour::INK,
            Some(_) if neighbour.grasp == answer.grasp => colour::GOOD,
            Some(_) => colour::OTHER,
        };
        canvas.text((x, y + SMALL + 2), SMALL, Font::BODY, &in_words(&neighbour.grasp), ink);
        for (line, (text, ink)) in (1u32..).zip(lines) {
            canvas.text((x, y + SMALL + 2 + line * LINE), SMALL, Font::BODY, &text, ink);
        }
    }
}

/// How far a picture was turned, in words; nothing where it was not.
fn turned(clockwise_deg: f64) -> String {
    let right = (clockwise_deg + 180.0).rem_euclid(360.0) - 180.0;
    match right.abs().round() {
        0.0 => String::new(),
        degrees => format!(", turned {degrees}° to the {}", if right > 0.0 { "right" } else { "left" }),
    }
}

fn capitalised(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map(|first| first.to_uppercase().chain(characters).collect()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_people_write_them() {
        let shares = [0.0, 0.001, 0.39, 0.997, 1.0].map(whole_percent);
        assert_eq!(shares, ["0 %", "< 1 %", "39 %", "> 99 %", "100 %"]);
        let turns = [0.0, 360.0, 48.0, 312.0].map(turned);
        assert_eq!(turns, ["", "", ", turned 48° to the right", ", turned 48° to the left"]);
    }
}
