//! Where the sections lie, and how long each must be.

use super::align::align;
use super::catalogue::Catalogue;
use super::corruption::Corruption;
use super::error::OpenError;
use super::header;
use super::sections::SectionKind;
use crate::search::Originals;
use crate::search::blocks::{LANES, MAX_AXES, centre_stride, entry_stride};
use crate::search::effort::{EffortPoint, Measured};
use crate::search::hash::HashInfo;
use crate::search::learned::LearnedHash;
use crate::search::random::{MAX_PLANES, RandomHash};
use std::ops::Range;

impl SectionKind {
    /// How many elements the section must have, by the rest of the catalogue. Outer `None`: more
    /// than a `u64` counts; inner `None`: text, of any length.
    fn elements(self, catalogue: &Catalogue) -> Option<Option<u64>> {
        let n = catalogue.entries;
        let dim = u64::from(catalogue.dim);
        let kept = &catalogue.kept;
        let is_kept = match self {
            Self::Descriptors => catalogue.originals != Originals::None,
            Self::Labels | Self::Stages | Self::HandShapes => kept.labels,
            Self::Objects | Self::ObjectOffsets | Self::ObjectText => kept.labels,
            Self::Orientations => kept.orientations,
            Self::Views => kept.views,
            Self::FileOffsets | Self::FileText => kept.files,
            Self::SourceHashes => kept.sources,
            _ => true,
        };
        if !is_kept {
            return Some(Some(0));
        }
        let count = match self {
            Self::Descriptors => n.checked_mul(dim)?,
            Self::Labels | Self::Stages | Self::HandShapes | Self::SourceHashes | Self::Objects => n,
            Self::Orientations => n.checked_mul(4)?,
            Self::Views => n.checked_mul(3)?,
            Self::FileOffsets => n.checked_add(1)?,
            Self::ObjectOffsets => u64::from(catalogue.objects) + 1,
            Self::FileText | Self::ObjectText | Self::Network => return Some(None),
            Self::Thumbnails => n.checked_mul(u64::from(catalogue.thumbnail_side).pow(2))?,
            _ => match catalogue.hash {
                HashInfo::Random(hash) => self.elements_of_random(hash, n, dim)?,
                HashInfo::Learned(hash) => self.elements_of_learned(hash, dim)?,
            },
        };
        Some(Some(count))
    }

    fn elements_of_random(self, hash: RandomHash, n: u64, dim: u64) -> Option<u64> {
        let (tables, planes) = (u64::from(hash.tables), u64::from(hash.planes));
        Some(match self {
            Self::PlaneNormals => tables.checked_mul(planes)?.checked_mul(dim)?,
            Self::PlaneOffsets => tables.checked_mul(planes)?,
            Self::BucketDirectory => tables.checked_mul(u64::from(hash.buckets))?.checked_add(1)?,
            Self::BucketIds => tables.checked_mul(n)?,
            _ => 0,
        })
    }

    fn elements_of_learned(self, hash: LearnedHash, dim: u64) -> Option<u64> {
        let axes = hash.axes as usize;
        let (groups, centre_blocks) = (u64::from(hash.groups), u64::from(hash.centre_blocks));
        Some(match self {
            Self::Axes => dim.checked_add(1)?.checked_mul(u64::from(hash.axes))?,
            Self::GroupCentres => groups.div_ceil(LANES as u64).checked_mul(centre_stride(axes) as u64)?,
            Self::GroupDirectory => groups + 1,
            Self::BucketCentres => centre_blocks.checked_mul(centre_stride(axes) as u64)?,
            Self::BucketDirectory => centre_blocks.checked_mul(LANES as u64)?.checked_add(1)?,
            Self::EntryBlocks => {
                u64::from(hash.entry_blocks).checked_mul(entry_stride(axes, hash.code_bits) as u64)?
            }
            _ => 0,
        })
    }
}

/// Where the sections of an opened file lie: every range is inside the file and fits its section's
/// element type.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    ranges: [Range<usize>; SectionKind::ALL.len()],
}

impl Layout {
    /// The section's bytes in the file.
    pub(crate) fn range(&self, kind: SectionKind) -> Range<usize> {
        self.ranges[kind as usize].clone()
    }

    /// Checks the catalogue against itself and against the file: `sections_end` is where the
    /// catalogue starts.
    pub(crate) fn check(catalogue: &Catalogue, sections_end: u64) -> Result<Self, OpenError> {
        check_numbers(catalogue)?;
        let mut ranges = std::array::from_fn(|_| 0..0);
        let mut end = header::LENGTH as u64;
        let kinds = SectionKind::of(&catalogue.descriptor);
        if catalogue.sections.len() != kinds.len() {
            return Err(Corruption::Catalogue("lists another number of sections than there are").into());
        }
        for (section, kind) in catalogue.sections.iter().zip(kinds.iter().copied()) {
            let corrupt = |what| Corruption::Section { kind, what };
            let element = kind.element(catalogue.originals);
            if section.kind != kind || section.element != element {
                return Err(corrupt("is not where it should be").into());
            }
            // Sections follow each other: none overlaps another, and between them there is padding
            // alone.
            if align(end) != Some(section.offset) {
                return Err(corrupt("does not start where the one before ends").into());
            }
            let elements = kind.elements(catalogue).ok_or_else(|| corrupt("is too long"))?;
            let expected = elements.map(|count| count.checked_mul(element.size()));
            if expected.is_some_and(|expected| expected != Some(section.length)) {
                return Err(corrupt("has another length than the catalogue's numbers give").into());
            }
            end = section.offset.checked_add(section.length).ok_or_else(|| corrupt("is too long"))?;
            if end > sections_end {
                return Err(corrupt("reaches beyond the catalogue").into());
            }
            // Within the file, so within usize.
            ranges[kind as usize] = section.offset as usize..end as usize;
        }
        if align(end) != Some(sections_end) {
            return Err(Corruption::Catalogue("does not start where the last section ends").into());
        }
        Ok(Self { ranges })
    }
}

/// The most classes, hand shapes and stages: entries have their numbers as u16, u16 and u8.
pub(super) const MOST_NAMES: [usize; 3] = [1 << 16, 1 << 16, 1 << 8];

/// The catalogue's numbers against each other.
fn check_numbers(catalogue: &Catalogue) -> Result<(), OpenError> {
    let corrupt = |what| Err(Corruption::Catalogue(what).into());
    catalogue.descriptor.validate().map_err(Corruption::Descriptor)?;
    if catalogue.descriptor.dim() as u64 != u64::from(catalogue.dim) {
        return corrupt("states a descriptor length that its parameters do not give");
    }
    if catalogue.descriptor.fingerprint() != catalogue.descriptor_fingerprint {
        return Err(OpenError::OtherDescriptors);
    }
    if catalogue.entries == 0 || catalogue.entries > u64::from(u32::MAX) {
        return corrupt("states an impossible number of entries");
    }
    let unnamed =
        catalogue.classes.is_empty() || catalogue.hand_shapes.is_empty() || catalogue.stages.is_empty();
    if catalogue.kept.labels && unnamed {
        return corrupt("lacks classes, hand shapes or stages");
    }
    check_hash(catalogue)?;
    let names = [catalogue.classes.len(), catalogue.hand_shapes.len(), catalogue.stages.len()];
    if names.iter().zip(MOST_NAMES).any(|(count, most)| *count > most) {
        return corrupt("names more classes, hand shapes or stages than can be numbered");
    }
    check_measured(&catalogue.measured)?;
    let positive = |value: f64| value.is_finite() && value >= 0.0;
    if !positive(catalogue.sigma.mean_distance) || !positive(catalogue.sigma.literal) {
        return corrupt("states an impossible sigma");
    }
    if !catalogue.calibration.is_possible() {
        return corrupt("states an impossible calibration");
    }
    Ok(())
}

/// The hash must be one that can be searched.
fn check_hash(catalogue: &Catalogue) -> Result<(), OpenError> {
    let corrupt = |what| Err(Corruption::Catalogue(what).into());
    let needs_descriptors = matches!(catalogue.hash, HashInfo::Random(_));
    if needs_descriptors && catalogue.originals != Originals::F32 {
        return corrupt("states a hash that needs the descriptors, and that they are not kept");
    }
    let (is_possible, buckets) = match catalogue.hash {
        HashInfo::Random(hash) => (
            hash.tables > 0 && (1..=MAX_PLANES).contains(&hash.planes) && hash.buckets > 0,
            hash.tables.checked_mul(hash.buckets),
        ),
        HashInfo::Learned(hash) => (
            hash.groups > 0
                && hash.centre_blocks > 0
                && (4..=MAX_AXES as u32).contains(&hash.axes)
                && hash.axes % 4 == 0
                && [hash.centre_scale, hash.residual_scale]
                    .iter()
                    .all(|scale| scale.is_finite() && *scale > 0.0),
            hash.centre_blocks.checked_mul(LANES as u32),
        ),
    };
    if !is_possible {
        return corrupt("states an impossible hash");
    }
    if let HashInfo::Learned(hash) = catalogue.hash
        && catalogue.entries > u64::from(hash.entry_blocks) * LANES as u64
    {
        return corrupt("states more entries than its buckets hold");
    }
    // Bucket numbers are u32.
    if buckets.is_none() {
        return corrupt("states more buckets than can be numbered");
    }
    Ok(())
}

/// The curve must be one: numbers that a search may choose by.
fn check_measured(measured: &Measured) -> Result<(), OpenError> {
    let is_share = |share: &f64| (0.0..=1.0).contains(share);
    let is_sound = |point: &EffortPoint| {
        let shares = [point.recall_at_10, point.share_of_database];
        point.probes > 0 && shares.iter().chain(&point.eps_success).all(is_share)
    };
    if measured.curve.iter().all(is_sound) {
        Ok(())
    } else {
        Err(Corruption::Catalogue("states an impossible measurement").into())
    }
}

#[cfg(test)]
mod tests;
