//! What the person is shown: hand images, in an order that a seed gives.

use std::collections::HashSet;
use std::io::Cursor;
use std::path::Path;

use grasp_index::HandImage;
use image::{ExtendedColorType, ImageEncoder as _, codecs::png::PngEncoder};
use rayon::prelude::*;
use xxhash_rust::xxh3::xxh3_64_with_seed;

use crate::evaluate::labels::Label;
use crate::evaluate::{Miss, hand_image, score};
use grasp_recognise::Recogniser;
use grasp_recognise::segment::SegmentParams;

/// A picture of the quiz.
#[derive(Clone, Debug)]
pub struct Shown {
    /// Its name in the table of labels.
    pub file: String,
    /// What it shows.
    pub labelled: String,
    /// How far the grasp is closed; may be empty.
    pub stage: String,
    /// The hand image.
    pub png: Vec<u8>,
    /// What the program says to it, where it was asked; `Some(None)` where it rejects the picture.
    pub machine: Option<Option<String>>,
}

/// At most `limit` of the labels, in the order that `seed` gives; a file that is listed twice comes
/// once.
pub fn shuffled(mut labels: Vec<Label>, seed: u64, limit: usize) -> Vec<Label> {
    let mut seen = HashSet::new();
    labels.retain(|label| seen.insert(label.file.clone()));
    // The order of a hash is as good as a shuffle, and pictures that are added later do not change
    // that of the others.
    labels.sort_by_cached_key(|label| xxh3_64_with_seed(label.file.as_bytes(), seed));
    labels.truncate(limit);
    labels
}

/// Cuts the hands out, in parallel, and asks the program about each where there is one. In the
/// order of the labels; what cannot be shown is told in its place.
pub fn make(
    labels: &[Label],
    folder: &Path,
    labelled_masks: bool,
    segment: &SegmentParams,
    machine: Option<&Recogniser<'_>>,
) -> Vec<Result<Shown, (String, Miss)>> {
    let make = |label: &Label| -> Result<Shown, Miss> {
        let png = png(&hand_image(folder, label, labelled_masks, segment)?)?;
        let machine = machine.map(|recogniser| {
            let outcome = score(recogniser, folder, label.clone(), labelled_masks);
            outcome.result.ok().map(|guess| guess.grasp)
        });
        let (file, labelled) = (label.file.clone(), label.grasp.clone());
        Ok(Shown { file, labelled, stage: label.stage.clone(), png, machine })
    };
    labels.par_iter().map(|label| make(label).map_err(|miss| (label.file.clone(), miss))).collect()
}

/// Nothing but the pixels: a PNG could carry a name.
fn png(hand: &HandImage) -> Result<Vec<u8>, Miss> {
    let mut bytes = Cursor::new(Vec::new());
    let (width, height) = (hand.width() as u32, hand.height() as u32);
    PngEncoder::new(&mut bytes)
        .write_image(hand.pixels(), width, height, ExtendedColorType::L8)
        .map_err(|error| Miss { is_rejection: false, message: error.to_string() })?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::labels::Kind;

    fn label(file: String) -> Label {
        Label {
            line: 2,
            file,
            mask: None,
            kind: Kind::Segmented,
            grasp: "pinch".into(),
            stage: String::new(),
            hand: None,
            orientation: None,
            columns: [].into(),
        }
    }

    fn order(files: impl Iterator<Item = usize>, seed: u64) -> Vec<String> {
        let labels = files.map(|n| label(format!("{n}.png"))).collect();
        shuffled(labels, seed, usize::MAX).into_iter().map(|label| label.file).collect()
    }

    #[test]
    fn the_order_is_the_seeds_and_not_the_tables() {
        let first = order(0..100, 7);
        assert_eq!(first, order((0..100).rev().chain(0..3), 7));
        assert_ne!(first, order(0..100, 8));
        assert!(!first.is_sorted());
        let among_more: Vec<String> = order(0..200, 7).into_iter().filter(|f| first.contains(f)).collect();
        assert_eq!(first, among_more);
    }
}
