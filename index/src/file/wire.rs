//! The catalogue as it lies in the file: forms that never change, converted where a file is read or
//! written.
//!
//! A form has the fields of the domain's type in the order in which the file has them. Should the
//! domain change, the form stays, and the conversion makes up for the difference. An enum may get
//! more variants at its end, no larger than the others, for which [`least_reader`] names the
//! version; any other change is a new form beside the old one, and a new version.

use super::catalogue::{Catalogue, ClassInfo};
use super::kept::KeptFields;
use super::sections::{ElementType, Section, SectionKind};
use crate::descriptor::{DescriptorKind, DescriptorParams, Sampling, Tone};
use crate::search::Originals;
use crate::search::blocks::CodeBits;
use crate::search::effort::{EPS_GRID, EffortPoint, Measured};
use crate::search::hash::HashInfo;
use crate::search::learned::LearnedHash;
use crate::search::random::RandomHash;
use crate::vote::{Calibrated, Calibration, Reliability, ReliabilityBin, Sigma};
use grasp_network::{Arithmetic, Network};
use rkyv::rancor::Error;
use rkyv::util::AlignedVec;
use rkyv::{Archive, Deserialize, Serialize};

/// The least reader that understands an index: version 4 brought hands that are turned upright,
/// version 5 descriptors that a network makes, version 6 networks that are computed in integers,
/// version 7 codes of four bits.
pub(crate) fn least_reader(catalogue: &Catalogue, network: Option<&Network>) -> u32 {
    if matches!(catalogue.hash, HashInfo::Learned(LearnedHash { code_bits: CodeBits::Four, .. })) {
        return 7;
    }
    match (network.map(Network::arithmetic), catalogue.descriptor.sampling) {
        (Some(Arithmetic::Integers), _) => 6,
        (Some(Arithmetic::Floats), _) => 5,
        (None, Sampling::Upright { .. }) => 4,
        (None, Sampling::Native | Sampling::KeepAspect { .. }) => 3,
    }
}

/// The bytes of a catalogue.
pub(crate) fn write(catalogue: &Catalogue) -> Result<AlignedVec, Error> {
    rkyv::to_bytes::<Error>(&CatalogueForm::freeze(catalogue))
}

/// The catalogue that a file of version `version` holds; `None` where the bytes are of no such
/// form, or what they hold is no longer known. They are validated.
pub(crate) fn read(bytes: &[u8], version: u32) -> Option<Catalogue> {
    let mut catalogue = match version {
        2 => rkyv::from_bytes::<CatalogueForm2, Error>(bytes).ok()?.thaw(),
        _ => rkyv::from_bytes::<CatalogueForm, Error>(bytes).ok()?.thaw(),
    }?;
    if let DescriptorKind::Learned { network, .. } = &mut catalogue.descriptor.kind {
        *network = catalogue.sections.iter().find(|section| section.kind == SectionKind::Network)?.xxh3;
    }
    Some(catalogue)
}

/// A form in the file and what it stands for.
trait Frozen: Sized {
    type Domain;

    fn freeze(domain: &Self::Domain) -> Self;

    /// `None` where the domain no longer has such a value.
    fn thaw(self) -> Option<Self::Domain>;
}

/// Types that lie in the file as they are.
macro_rules! plain {
    ($($plain:ty),*) => {$(
        impl Frozen for $plain {
            type Domain = Self;

            fn freeze(domain: &Self) -> Self {
                domain.clone()
            }

            fn thaw(self) -> Option<Self> {
                Some(self)
            }
        }
    )*};
}

plain!(u8, u32, u64, f32, f64, bool, String, [f64; 2], [f64; EPS_GRID.len()], (String, String));

impl<F: Frozen> Frozen for Vec<F> {
    type Domain = Vec<F::Domain>;

    fn freeze(domain: &Self::Domain) -> Self {
        domain.iter().map(F::freeze).collect()
    }

    fn thaw(self) -> Option<Self::Domain> {
        self.into_iter().map(F::thaw).collect()
    }
}

impl<F: Frozen> Frozen for Option<F> {
    type Domain = Option<F::Domain>;

    fn freeze(domain: &Self::Domain) -> Self {
        domain.as_ref().map(F::freeze)
    }

    fn thaw(self) -> Option<Self::Domain> {
        match self {
            Some(form) => form.thaw().map(Some),
            None => Some(None),
        }
    }
}

/// Forms of structs, field by field.
macro_rules! structs {
    ($($form:ident of $domain:ident { $($field:ident: $type:ty),* $(,)? })*) => {$(
        #[derive(Archive, Serialize, Deserialize)]
        struct $form {
            $($field: $type),*
        }

        impl Frozen for $form {
            type Domain = $domain;

            fn freeze(domain: &$domain) -> Self {
                Self { $($field: <$type>::freeze(&domain.$field)),* }
            }

            fn thaw(self) -> Option<$domain> {
                Some($domain { $($field: self.$field.thaw()?),* })
            }
        }
    )*};
}

/// Forms of enums without values, in the order of their numbers.
macro_rules! enums {
    ($($form:ident of $domain:ident { $($variant:ident),* $(,)? })*) => {$(
        #[derive(Archive, Serialize, Deserialize)]
        enum $form {
            $($variant),*
        }

        impl Frozen for $form {
            type Domain = $domain;

            fn freeze(domain: &$domain) -> Self {
                match domain {
                    $($domain::$variant => Self::$variant),*
                }
            }

            fn thaw(self) -> Option<$domain> {
                Some(match self {
                    $(Self::$variant => $domain::$variant),*
                })
            }
        }
    )*};
}

structs! {
    CatalogueForm of Catalogue {
        entries: u64,
        dim: u32,
        descriptor: DescriptorParamsForm,
        descriptor_fingerprint: u64,
        classes: Vec<ClassInfoForm>,
        hand_shapes: Vec<String>,
        stages: Vec<String>,
        originals: OriginalsForm,
        kept: KeptForm,
        objects: u32,
        sigma: SigmaForm,
        calibration: CalibrationForm,
        seed: u64,
        hash: HashInfoForm,
        measured: MeasuredForm,
        thumbnail_side: u32,
        provenance: Vec<(String, String)>,
        sections: Vec<SectionForm>,
    }

    CatalogueForm2 of Catalogue {
        entries: u64,
        dim: u32,
        descriptor: DescriptorParamsForm,
        descriptor_fingerprint: u64,
        classes: Vec<ClassInfoForm>,
        hand_shapes: Vec<String>,
        stages: Vec<String>,
        originals: OriginalsForm,
        kept: KeptForm,
        objects: u32,
        sigma: SigmaForm,
        calibration: CalibrationForm2,
        seed: u64,
        hash: HashInfoForm,
        measured: MeasuredForm,
        thumbnail_side: u32,
        provenance: Vec<(String, String)>,
        sections: Vec<SectionForm>,
    }

    DescriptorParamsForm of DescriptorParams {
        kind: DescriptorKindForm,
        bins: u32,
        levels: u32,
        sampling: SamplingForm,
        tone: ToneForm,
    }

    ClassInfoForm of ClassInfo { name: String, cutkosky: u8 }

    KeptForm of KeptFields { labels: bool, orientations: bool, views: bool, files: bool, sources: bool }

    SigmaForm of Sigma { mean_distance: f64, literal: f64 }

    CalibrationForm of Calibration {
        k: u32,
        sigma_scale: f64,
        floor: f64,
        power: f64,
        farthest: Option<f64>,
        least_probability: f64,
        measured: Option<CalibratedForm>,
    }

    CalibratedForm of Calibrated { noise: [f64; 2], log_likelihood: f64, reliability: ReliabilityForm }

    ReliabilityBinForm of ReliabilityBin { n: u32, right: u32, probability: f64 }

    RandomHashForm of RandomHash { planes: u32, tables: u32, buckets: u32 }

    MeasuredForm of Measured { queries: u32, held_out: bool, noise: [f64; 2], curve: Vec<EffortPointForm> }

    EffortPointForm of EffortPoint {
        probes: u32,
        recall_at_10: f64,
        eps_success: [f64; EPS_GRID.len()],
        share_of_database: f64,
    }

    SectionForm of Section {
        kind: SectionKindForm,
        element: ElementTypeForm,
        offset: u64,
        length: u64,
        xxh3: u64,
    }
}

enums! {
    OriginalsForm of Originals { F32, F16, None }

    ElementTypeForm of ElementType { U8, U16, I16, U32, U64, F16, F32 }

    SectionKindForm of SectionKind {
        Descriptors, Labels, Stages, HandShapes, Orientations, Views, SourceHashes, FileOffsets, FileText, Objects,
        ObjectOffsets, ObjectText, Thumbnails, PlaneNormals, PlaneOffsets, BucketDirectory, BucketIds, Axes,
        GroupCentres, GroupDirectory, BucketCentres, EntryBlocks, Network,
    }
}

/// Version 2 has no calibration of the vote but these.
#[derive(Archive, Serialize, Deserialize)]
struct CalibrationForm2 {
    k: u32,
    sigma_scale: f64,
}

impl Frozen for CalibrationForm2 {
    type Domain = Calibration;

    fn freeze(&Calibration { k, sigma_scale, .. }: &Calibration) -> Self {
        Self { k, sigma_scale }
    }

    fn thaw(self) -> Option<Calibration> {
        Some(Calibration { k: self.k, sigma_scale: self.sigma_scale, ..Calibration::default() })
    }
}

#[derive(Archive, Serialize, Deserialize)]
struct ReliabilityForm {
    bins: [ReliabilityBinForm; 10],
}

impl Frozen for ReliabilityForm {
    type Domain = Reliability;

    fn freeze(domain: &Reliability) -> Self {
        Self { bins: domain.bins.each_ref().map(ReliabilityBinForm::freeze) }
    }

    fn thaw(self) -> Option<Reliability> {
        let bins: Option<Vec<ReliabilityBin>> = self.bins.into_iter().map(Frozen::thaw).collect();
        Some(Reliability { bins: bins?.try_into().ok()? })
    }
}

#[derive(Archive, Serialize, Deserialize)]
enum DescriptorKindForm {
    Paper,
    Default,
    Raw {
        dim: u32,
    },
    /// Its network's fingerprint is the hash of the section that holds it. No larger than the
    /// others: a larger variant would move what follows, in files of every version.
    Learned {
        dim: u32,
    },
}

impl Frozen for DescriptorKindForm {
    type Domain = DescriptorKind;

    fn freeze(domain: &DescriptorKind) -> Self {
        match *domain {
            DescriptorKind::Paper => Self::Paper,
            DescriptorKind::Default => Self::Default,
            DescriptorKind::Raw { dim } => Self::Raw { dim },
            DescriptorKind::Learned { network: _, dim } => Self::Learned { dim },
        }
    }

    fn thaw(self) -> Option<DescriptorKind> {
        Some(match self {
            Self::Paper => DescriptorKind::Paper,
            Self::Default => DescriptorKind::Default,
            Self::Raw { dim } => DescriptorKind::Raw { dim },
            // `read` fills it in.
            Self::Learned { dim } => DescriptorKind::Learned { network: 0, dim },
        })
    }
}

#[derive(Archive, Serialize, Deserialize)]
enum SamplingForm {
    Native,
    /// Was tried, and is in no index that a program of this project has built.
    Stretch {
        side: u16,
    },
    KeepAspect {
        side: u16,
    },
    /// As `Stretch`.
    Moments {
        side: u16,
    },
    Upright {
        side: u16,
    },
}

impl Frozen for SamplingForm {
    type Domain = Sampling;

    fn freeze(domain: &Sampling) -> Self {
        match *domain {
            Sampling::Native => Self::Native,
            Sampling::KeepAspect { side } => Self::KeepAspect { side },
            Sampling::Upright { side } => Self::Upright { side },
        }
    }

    fn thaw(self) -> Option<Sampling> {
        match self {
            Self::Native => Some(Sampling::Native),
            Self::KeepAspect { side } => Some(Sampling::KeepAspect { side }),
            Self::Upright { side } => Some(Sampling::Upright { side }),
            Self::Stretch { .. } | Self::Moments { .. } => None,
        }
    }
}

#[derive(Archive, Serialize, Deserialize)]
enum ToneForm {
    AsIs,
    Normalised { contrast: f32 },
}

impl Frozen for ToneForm {
    type Domain = Tone;

    fn freeze(domain: &Tone) -> Self {
        match *domain {
            Tone::AsIs => Self::AsIs,
            Tone::Normalised { contrast } => Self::Normalised { contrast },
        }
    }

    fn thaw(self) -> Option<Tone> {
        Some(match self {
            Self::AsIs => Tone::AsIs,
            Self::Normalised { contrast } => Tone::Normalised { contrast },
        })
    }
}

#[derive(Archive, Serialize, Deserialize)]
enum HashInfoForm {
    Random(RandomHashForm),
    /// Codes of eight bits, as all were before version 7.
    Learned(LearnedHashForm),
    /// Codes of four bits.
    LearnedInHalves(LearnedHashForm),
}

impl Frozen for HashInfoForm {
    type Domain = HashInfo;

    fn freeze(domain: &HashInfo) -> Self {
        match domain {
            HashInfo::Random(hash) => Self::Random(Frozen::freeze(hash)),
            HashInfo::Learned(hash) => match hash.code_bits {
                CodeBits::Four => Self::LearnedInHalves(LearnedHashForm::freeze(hash)),
                CodeBits::Eight => Self::Learned(LearnedHashForm::freeze(hash)),
            },
        }
    }

    fn thaw(self) -> Option<HashInfo> {
        Some(match self {
            Self::Random(hash) => HashInfo::Random(hash.thaw()?),
            Self::Learned(hash) => HashInfo::Learned(hash.thaw(CodeBits::Eight)),
            Self::LearnedInHalves(hash) => HashInfo::Learned(hash.thaw(CodeBits::Four)),
        })
    }
}

/// A learned hash but for the bits of its codes, which are the variant that holds it.
#[derive(Archive, Serialize, Deserialize)]
struct LearnedHashForm {
    planes: u32,
    axes: u32,
    groups: u32,
    centre_blocks: u32,
    entry_blocks: u32,
    centre_scale: f32,
    residual_scale: f32,
}

impl LearnedHashForm {
    fn freeze(hash: &LearnedHash) -> Self {
        let &LearnedHash {
            planes,
            axes,
            groups,
            centre_blocks,
            entry_blocks,
            centre_scale,
            residual_scale,
            code_bits: _,
        } = hash;
        Self { planes, axes, groups, centre_blocks, entry_blocks, centre_scale, residual_scale }
    }

    fn thaw(self, code_bits: CodeBits) -> LearnedHash {
        let Self { planes, axes, groups, centre_blocks, entry_blocks, centre_scale, residual_scale } = self;
        LearnedHash {
            planes,
            axes,
            groups,
            centre_blocks,
            entry_blocks,
            centre_scale,
            residual_scale,
            code_bits,
        }
    }
}
