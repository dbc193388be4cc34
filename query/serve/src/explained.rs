//! How an answer came about, as data for a page to draw: pictures as `data:` addresses, the
//! descriptor as numbers.

use std::io::Cursor;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use grasp_index::Index;
use image::{ExtendedColorType, ImageEncoder as _, ImageError, codecs::png::PngEncoder};
use serde::Serialize;
use utoipa::ToSchema;

use grasp_answer::explain::edge_deg;
use grasp_recognise::Recognition;

/// Transparent where the hand is, red where a forearm was cut off, dark elsewhere: to be laid over
/// the picture.
const HAND: [u8; 4] = [0, 0, 0, 0];
const FOREARM: [u8; 4] = [190, 40, 30, 150];
const ELSEWHERE: [u8; 4] = [0, 0, 0, 170];

/// What a drawing of an answer needs besides the record.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct Explained {
    /// Pixels in a row of the picture as it was segmented.
    width: usize,
    /// Its rows.
    height: usize,
    /// A PNG of that size to lay over the picture: dark where no hand is, red where a forearm was
    /// cut off.
    mask: String,
    /// The hand image H as a PNG, as it was described: flipped for a left hand, turned where that
    /// was asked for.
    hand_image: String,
    /// Values of the descriptor.
    dim: usize,
    /// Bins of orientation in each cell, 0 where there are none.
    bins: u32,
    /// How the edges lie that each bin counts, in degrees counter-clockwise: 0 is level, 90
    /// upright.
    edges_deg: Vec<f64>,
    /// The descriptor's values, where a network computed them and they have no directions or cells.
    values: Vec<f32>,
    /// The descriptor's cells, level by level.
    cells: Vec<CellRecord>,
    /// Which index answered: the neighbours' thumbnails are asked for with it.
    generation: u64,
}

/// A cell of the pyramid.
#[derive(Debug, Serialize, ToSchema)]
struct CellRecord {
    /// The level, from 1, the finest.
    level: u32,
    /// The level has so many cells in a row.
    cells_a_side: usize,
    row: usize,
    column: usize,
    /// One value a bin.
    histogram: Vec<f32>,
}

impl Explained {
    pub(super) fn new(found: &Recognition, index: &Index, generation: u64) -> Result<Self, ImageError> {
        let (picture, mask) = (&found.prepared.picture, &found.prepared.mask);
        let hand = &found.best.described_image(&found.hand_image);
        let (width, height) = (picture.width(), picture.height());
        let skin = found.prepared.skin.as_ref();
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let overlay: Vec<u8> = places
            .flat_map(|(x, y)| {
                if mask.get(x, y) {
                    HAND
                } else if skin.is_some_and(|skin| skin.get(x, y)) {
                    FOREARM
                } else {
                    ELSEWHERE
                }
            })
            .collect();
        let params = &index.catalogue().descriptor;
        let cells = params.cells(&found.best.descriptor).map(|cell| CellRecord {
            level: cell.level,
            cells_a_side: cell.cells_a_side,
            row: cell.row,
            column: cell.column,
            histogram: cell.histogram.to_vec(),
        });
        let bins = if params.is_learned() { 0 } else { params.bins };
        Ok(Self {
            width,
            height,
            mask: address(&overlay, (width, height), ExtendedColorType::Rgba8)?,
            hand_image: address(hand.pixels(), (hand.width(), hand.height()), ExtendedColorType::L8)?,
            dim: found.best.descriptor.len(),
            bins,
            values: if params.is_learned() { found.best.descriptor.clone() } else { Vec::new() },
            edges_deg: (0..bins).map(|bin| edge_deg(params, bin)).collect(),
            cells: cells.collect(),
            generation,
        })
    }
}

fn address(pixels: &[u8], size: (usize, usize), colour: ExtendedColorType) -> Result<String, ImageError> {
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(png(pixels, size, colour)?)))
}

/// Pixels as a PNG.
pub(super) fn png(
    pixels: &[u8],
    (width, height): (usize, usize),
    colour: ExtendedColorType,
) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Cursor::new(Vec::new());
    PngEncoder::new(&mut bytes).write_image(pixels, width as u32, height as u32, colour)?;
    Ok(bytes.into_inner())
}
