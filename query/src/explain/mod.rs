//! One PNG that shows how an answer came about: the input, its mask, the hand image, the descriptor as the paper's
//! Figure 4 and the nearest neighbours as its Figure 5.

mod canvas;

use std::io::{Cursor, Write as _};
use std::path::Path;

use grasp_index::{AtomicFile, Index};
use image::{ImageError, RgbImage};

use crate::output::record::Answer;
use crate::recognise::Recognition;
use canvas::{Canvas, LINE, colour};

const WIDTH: u32 = 980;
const MARGIN: u32 = 12;
/// Side of the three large pictures at the top.
const LARGE: u32 = 300;
/// Side of a picture in the lower rows.
const SMALL: u32 = 148;
/// Neighbours in a row.
const ACROSS: usize = 6;
/// Neighbours that are drawn, however many vote.
const MOST_NEIGHBOURS: usize = 4 * ACROSS;

/// Draws an answer.
pub fn draw(found: &Recognition, answer: &Answer, index: &Index) -> RgbImage {
    let levels = index.catalogue().descriptor.levels.max(1);
    let rows = found.best.neighbours.len().min(MOST_NEIGHBOURS).div_ceil(ACROSS) as u32;
    let head = MARGIN + 2 * LINE + MARGIN;
    let figure_4 = head + LINE + LARGE + MARGIN;
    let figure_5 = figure_4 + 2 * LINE + SMALL + MARGIN;
    let row_height = SMALL + 4 * LINE + MARGIN;
    let mut canvas = Canvas::new(WIDTH, figure_5 + LINE + rows * row_height + MARGIN);

    headline(&mut canvas, answer);
    inputs(&mut canvas, head, found);
    descriptor(&mut canvas, figure_4, found, index, levels);
    neighbours(&mut canvas, figure_5, row_height, found, answer, index);
    canvas.into_image()
}

/// A drawing as the bytes of a PNG.
///
/// # Errors
/// Where it cannot be encoded.
pub fn png(image: &RgbImage) -> Result<Vec<u8>, ImageError> {
    let mut png = Vec::new();
    image.write_to(&mut Cursor::new(&mut png), image::ImageFormat::Png)?;
    Ok(png)
}

/// Writes a drawing as PNG: the whole of it, or nothing.
///
/// # Errors
/// Where the file cannot be written.
pub fn save(image: &RgbImage, path: &Path) -> anyhow::Result<()> {
    let png = png(image)?;
    let mut file = AtomicFile::create(path)?;
    file.write_all(&png)?;
    file.commit()?;
    Ok(())
}

fn headline(canvas: &mut Canvas, answer: &Answer) {
    let first = format!(
        "{} (Cutkosky {}), {:.2}   {} hand, camera sees {}, fingers point {} (+- {:.0} deg)",
        answer.grasp,
        answer.cutkosky.map_or_else(|| "-".to_owned(), |cutkosky| cutkosky.to_string()),
        answer.probability,
        answer.hand,
        answer.orientation.camera_sees,
        answer.orientation.fingers_point,
        answer.orientation.spread_deg,
    );
    canvas.text((MARGIN, MARGIN), WIDTH - 2 * MARGIN, &first, colour::INK);
    canvas.text((MARGIN, MARGIN + LINE), WIDTH - 2 * MARGIN, &answer.file, colour::FAINT);
}

fn inputs(canvas: &mut Canvas, top: u32, found: &Recognition) {
    let (picture, mask, hand) = (&found.prepared.picture, &found.prepared.mask, &found.best.image);
    let size = (picture.width(), picture.height());
    let colour_at = |x: usize, y: usize| picture.rgb().get(y * size.0 + x).copied().unwrap_or_default();
    let column = |n: u32| MARGIN + n * (LARGE + MARGIN);
    let mut titled = |n: u32, title: &str| {
        canvas.text((column(n), top), LARGE, title, colour::FAINT);
    };
    titled(0, "input");
    titled(1, "mask (red: forearm, cut off)");
    let turned = if found.best.roll_deg == 0.0 {
        String::new()
    } else {
        format!(", turned {:.0} deg", found.best.roll_deg)
    };
    let flipped = if found.best.side == crate::recognise::Side::Left { ", flipped" } else { "" };
    titled(2, &format!("hand image{flipped}{turned}"));
    let top = top + LINE;
    canvas.picture((column(0), top), LARGE, size, colour_at);
    canvas.picture((column(1), top), LARGE, size, |x, y| {
        let [r, g, b] = colour_at(x, y);
        if mask.get(x, y) {
            [r / 2, g / 2 + 127, b / 2]
        } else if found.prepared.skin.as_ref().is_some_and(|skin| skin.get(x, y)) {
            [r / 2 + 127, g / 2, b / 2]
        } else {
            [r / 3, g / 3, b / 3]
        }
    });
    let hand_size = (hand.width(), hand.height());
    canvas.picture((column(2), top), LARGE, hand_size, |x, y| {
        [hand.pixels().get(y * hand_size.0 + x).copied().unwrap_or(0); 3]
    });
}

/// The paper's Figure 4: for each orientation bin, how much each cell holds of it. All levels lie side by side.
fn descriptor(canvas: &mut Canvas, top: u32, found: &Recognition, index: &Index, levels: u32) {
    let params = &index.catalogue().descriptor;
    let bins = params.bins.max(1);
    let title = format!(
        "descriptor: {bins} orientations, each on {levels} levels (level 1 large; coarser ones beside it), {} values",
        found.best.descriptor.len()
    );
    canvas.text((MARGIN, top), WIDTH - 2 * MARGIN, &title, colour::FAINT);
    let top = top + LINE;
    let step = (WIDTH - MARGIN) / bins;
    let largest_of = |level: u32| {
        let cells = params.cells(&found.best.descriptor).filter(|cell| cell.level == level);
        cells.flat_map(|cell| cell.histogram.iter().copied()).fold(f32::MIN_POSITIVE, f32::max)
    };
    let largest: Vec<f32> = (1..=levels).map(largest_of).collect();
    for cell in params.cells(&found.best.descriptor) {
        // Each coarser level is drawn at half the side, to the right of the one before and below its top.
        let side = SMALL >> (cell.level - 1).min(7);
        let below = SMALL - (side << 1).min(SMALL);
        let (shift, drop) = if cell.level == 1 { (0, 0) } else { (SMALL + 4, below) };
        let cell_side = side / cell.cells_a_side.max(1) as u32;
        let scale = largest.get(cell.level as usize - 1).copied().unwrap_or(1.0);
        for (bin, &value) in (0u32..).zip(cell.histogram) {
            let shade = (255.0 * (value / scale).clamp(0.0, 1.0)) as u8;
            let x = MARGIN + bin * step + shift + cell.column as u32 * cell_side;
            let y = top + drop + cell.row as u32 * cell_side;
            canvas.fill((x, y), (cell_side.max(2) - 1, cell_side.max(2) - 1), [shade; 3]);
        }
    }
    for bin in 0..bins {
        let at = (MARGIN + bin * step, top + SMALL);
        canvas.text(at, step - MARGIN, &format!("bin {}", bin + 1), colour::FAINT);
    }
}

/// The paper's Figure 5: the nearest entries with their class, distance and view.
fn neighbours(
    canvas: &mut Canvas,
    top: u32,
    row_height: u32,
    found: &Recognition,
    answer: &Answer,
    index: &Index,
) {
    let title = format!("nearest of {} entries", index.len());
    canvas.text((MARGIN, top), WIDTH - 2 * MARGIN, &title, colour::FAINT);
    let side = index.catalogue().thumbnail_side as usize;
    for (place, neighbour) in answer.neighbours.iter().take(MOST_NEIGHBOURS).enumerate() {
        let (column, row) = ((place % ACROSS) as u32, (place / ACROSS) as u32);
        let x = MARGIN + column * (SMALL + MARGIN);
        let y = top + LINE + row * row_height;
        let thumbnail = index.thumbnail(neighbour.id).unwrap_or_default();
        canvas.picture((x, y), SMALL, (side, side), |tx, ty| {
            [thumbnail.get(ty * side + tx).copied().unwrap_or(0); 3]
        });
        let agrees = neighbour.grasp == answer.grasp;
        let ink = if agrees { colour::GOOD } else { colour::OTHER };
        canvas.text((x, y + SMALL + 2), SMALL, &neighbour.grasp, ink);
        canvas.text((x, y + SMALL + LINE), SMALL, &format!("d = {:.3}", neighbour.distance), colour::INK);
        let entry = found.best.neighbours.get(place).and_then(|n| index.entry(n.id).ok());
        if let Some([azimuth, elevation, _]) = entry.and_then(|entry| entry.view_deg) {
            let view = format!("az {azimuth:.0} el {elevation:.0}");
            canvas.text((x, y + SMALL + 2 * LINE), SMALL, &view, colour::INK);
        }
        canvas.text((x, y + SMALL + 3 * LINE), SMALL, &neighbour.stage, colour::FAINT);
    }
}
