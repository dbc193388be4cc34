//! What makes no index is refused before anything is written.

use crate::descriptor::{DescriptorKind, DescriptorModel, DescriptorParams, ParamsError};
use crate::file::input::{BuildError, EntryFault, IndexParams, NewEntry};
use crate::file::layout::MOST_NAMES;
use crate::search::Originals;
use crate::search::build::{HashParams, RandomParams};
use crate::search::distance::LARGEST_VALUE;
use crate::search::random::MAX_PLANES;
use half::f16;
use std::sync::Arc;

/// The most values of a vector for a learned hash: its axes are eigenvectors of a matrix of as many
/// rows and columns, 134 MB for this many.
const MOST_LEARNED: usize = 4096;

/// The pixels of a thumbnail.
pub(super) fn pixels(params: &IndexParams) -> usize {
    (params.thumbnail_side as usize).pow(2)
}

/// Checks the ranges of the parameters.
pub(super) fn check_params(params: &IndexParams) -> Result<(), BuildError> {
    params.descriptor.validate()?;
    if let DescriptorKind::Learned { network: named, .. } = params.descriptor.kind {
        match &params.network {
            Some(network) if DescriptorParams::learned(network) == params.descriptor => {
                DescriptorModel::learned(Arc::clone(network))?;
            }
            _ => return Err(ParamsError::Network(named).into()),
        }
    }
    let unnamed = params.classes.is_empty() || params.hand_shapes.is_empty() || params.stages.is_empty();
    if params.kept.labels && unnamed {
        return Err(BuildError::Params("an index needs at least one class, one hand shape and one stage"));
    }
    let names = [params.classes.len(), params.hand_shapes.len(), params.stages.len()];
    if names.iter().zip(MOST_NAMES).any(|(count, most)| *count > most) {
        return Err(BuildError::Params(
            "at most 65,536 classes, 65,536 hand shapes and 256 stages can be numbered",
        ));
    }
    if params.thumbnail_side > 1024 {
        return Err(BuildError::Params("a thumbnail has at most 1024 pixels a side"));
    }
    if !params.calibration.is_possible() {
        return Err(BuildError::Params(
            "a calibration needs at least one neighbour, positive factors, and a floor and thresholds of 0 or more",
        ));
    }
    check_held_out(&params.held_out, &params.held_out_classes, params)?;
    if params.originals != Originals::F32 && params.hash != HashParams::Learned {
        return Err(BuildError::Params("a random hash needs the original descriptors as they are (f32)"));
    }
    if params.hash == HashParams::Learned && params.descriptor.dim() > MOST_LEARNED {
        return Err(BuildError::Params(
            "a learned hash takes vectors of at most 4,096 values: reduce them first, or take a random hash",
        ));
    }
    if let HashParams::Random(RandomParams::Fixed { k, t, buckets }) = params.hash
        && !((1..=MAX_PLANES).contains(&k) && (1..=1024).contains(&t) && (1..=1 << 20).contains(&buckets))
    {
        return Err(BuildError::Params("K must be 1 to 64, T 1 to 1024, and H 1 to 1,048,576"));
    }
    Ok(())
}

/// Checks that held-out descriptors are rows of finite values, and that their classes, where they
/// are known, are the index's.
pub(super) fn check_held_out(
    held_out: &[f32],
    classes: &[u16],
    params: &IndexParams,
) -> Result<(), BuildError> {
    let dim = params.descriptor.dim().max(1);
    let rows = held_out.len() / dim;
    if !classes.is_empty() && (!params.kept.labels || classes.len() != rows) {
        return Err(BuildError::Params(
            "held-out classes need a held-out descriptor each, and an index with labels",
        ));
    }
    if classes.iter().any(|&class| usize::from(class) >= params.classes.len()) {
        return Err(BuildError::Params("the held-out descriptors must be of the index's classes"));
    }
    if !held_out.len().is_multiple_of(dim) {
        return Err(BuildError::Params("the held-out descriptors must be as long as the index's own"));
    }
    if !held_out.iter().all(|value| value.abs() <= LARGEST_VALUE) {
        return Err(BuildError::Params(
            "the held-out descriptors must be made of finite numbers, none beyond 1e15",
        ));
    }
    Ok(())
}

/// Checks an entry against them; says what does not fit.
pub(super) fn check_entry(params: &IndexParams, entry: &NewEntry) -> Result<(), EntryFault> {
    let dim = params.descriptor.dim();
    if entry.descriptor.len() != dim {
        return Err(EntryFault::Dimension { found: entry.descriptor.len(), expected: dim });
    }
    if let Some(at) = entry.descriptor.iter().position(|value| !value.is_finite()) {
        return Err(EntryFault::NotFinite { at });
    }
    if let Some(at) = entry.descriptor.iter().position(|value| value.abs() > LARGEST_VALUE) {
        return Err(EntryFault::Huge { at });
    }
    if params.originals == Originals::F16
        && let Some(at) = entry.descriptor.iter().position(|value| value.abs() > f16::MAX.to_f32())
    {
        return Err(EntryFault::TooLarge { at });
    }
    let views = [entry.azimuth_deg, entry.elevation_deg, entry.roll_deg];
    if !views.iter().all(|angle| angle.is_finite()) {
        return Err(EntryFault::View);
    }
    let is_unit = (entry.orientation.norm() - 1.0).abs() < 1e-4;
    if !is_unit {
        return Err(EntryFault::Orientation);
    }
    if !params.kept.labels {
        return check_thumbnail(params, entry);
    }
    for (what, number, count) in [
        ("class", usize::from(entry.class), params.classes.len()),
        ("stage", usize::from(entry.stage), params.stages.len()),
        ("hand shape", usize::from(entry.hand_shape), params.hand_shapes.len()),
    ] {
        if number >= count {
            return Err(EntryFault::Number { what, number, count });
        }
    }
    check_thumbnail(params, entry)
}

fn check_thumbnail(params: &IndexParams, entry: &NewEntry) -> Result<(), EntryFault> {
    match &entry.thumbnail {
        Some(thumbnail) if thumbnail.len() != pixels(params) => {
            Err(EntryFault::Thumbnail { found: thumbnail.len(), expected: pixels(params) })
        }
        _ => Ok(()),
    }
}
