//! Catalogues whose hashes are right and whose numbers lie: each is refused, and told why.

use super::*;
use crate::file::input::{IndexParams, NewEntry};
use crate::search::build::{HashParams, RandomParams};
use crate::{Calibrated, ClassInfo, ElementType, Index, IndexWriter, Reliability};

/// A sound catalogue, and where it starts in its file.
fn sound(hash: HashParams) -> (Catalogue, u64) {
    let class = |name: &str| ClassInfo { name: name.into(), cutkosky: 1 };
    let params = IndexParams {
        classes: vec![class("one"), class("two")],
        hand_shapes: vec!["mean".into()],
        stages: vec!["grasp".into()],
        hash,
        ..IndexParams::default()
    };
    let dim = params.descriptor.dim();
    let mut writer = IndexWriter::new(params).expect("the parameters are sound");
    for n in 0..8u16 {
        let descriptor = (0..dim).map(|at| f32::from(n) * 0.1 + (at % 7) as f32).collect();
        writer.push(NewEntry { class: n % 2, descriptor, ..NewEntry::default() }).expect("the entry fits");
    }
    let bytes = writer.finish_bytes().expect("the index is built");
    let mut catalogue = Index::from_bytes(&bytes).expect("it opens").catalogue().clone();
    let reliability = Reliability::from_answers([(0.9, true), (0.2, false)]);
    let measured = Calibrated { noise: [0.2, 0.5], log_likelihood: -0.5, reliability };
    catalogue.calibration.measured = Some(measured);
    (catalogue, header::Header::read(&bytes).expect("it has a header").catalogue_offset)
}

fn random() -> (Catalogue, u64) {
    sound(HashParams::Random(RandomParams::Fixed { k: 2, t: 2, buckets: 4 }))
}

fn learned() -> (Catalogue, u64) {
    sound(HashParams::Learned)
}

type Lie = fn(&mut Catalogue);

/// What each of these changes to a sound catalogue is told.
fn assert_told(sound: (Catalogue, u64), told: &str, lies: &[Lie]) {
    for (at, lie) in lies.iter().enumerate() {
        let mut catalogue = sound.0.clone();
        lie(&mut catalogue);
        let found = Layout::check(&catalogue, sound.1).map(drop).map_err(|error| error.to_string());
        assert!(found.as_ref().is_err_and(|found| found.contains(told)), "{told}, {at}: {found:?}");
    }
}

fn random_hash(catalogue: &mut Catalogue) -> &mut RandomHash {
    match &mut catalogue.hash {
        HashInfo::Random(hash) => hash,
        HashInfo::Learned(_) => panic!("the hash is random"),
    }
}

fn learned_hash(catalogue: &mut Catalogue) -> &mut LearnedHash {
    match &mut catalogue.hash {
        HashInfo::Learned(hash) => hash,
        HashInfo::Random(_) => panic!("the hash is learned"),
    }
}

fn fitted(catalogue: &mut Catalogue) -> &mut Calibrated {
    catalogue.calibration.measured.as_mut().expect("it was measured")
}

#[test]
fn sound_numbers_and_the_ends_of_their_ranges_are_believed() {
    let ends: [Lie; 4] = [
        |_| (),
        |c| c.stages.resize(256, "grasp".into()),
        |c| (c.sigma.mean_distance, c.sigma.literal) = (0.0, 0.0),
        |c| {
            (c.calibration.k, c.calibration.floor, c.calibration.least_probability) = (100_000, 0.0, 1.0);
            fitted(c).log_likelihood = 0.0;
        },
    ];
    for (catalogue, sections_end) in [random(), learned()] {
        for end in ends {
            let mut catalogue = catalogue.clone();
            end(&mut catalogue);
            Layout::check(&catalogue, sections_end).expect("nothing is wrong");
        }
    }
}

#[test]
fn entries_and_names_that_cannot_be() {
    assert_told(random(), "descriptor length", &[|c| c.dim += 1]);
    assert_told(random(), "levels", &[|c| c.descriptor.levels = 99]);
    assert_told(random(), "another version of this program", &[|c| c.descriptor_fingerprint ^= 1]);
    assert_told(random(), "impossible number of entries", &[|c| c.entries = 0, |c| c.entries = 1 << 32]);
    let none: [Lie; 3] = [|c| c.classes.clear(), |c| c.hand_shapes.clear(), |c| c.stages.clear()];
    assert_told(random(), "lacks classes", &none);
    let many: [Lie; 3] = [
        |c| c.classes.resize(65_537, c.classes[0].clone()),
        |c| c.hand_shapes.resize(65_537, "mean".into()),
        |c| c.stages.resize(257, "grasp".into()),
    ];
    assert_told(random(), "than can be numbered", &many);
}

#[test]
fn hashes_that_cannot_be_searched() {
    let of_random: [Lie; 4] = [
        |c| random_hash(c).tables = 0,
        |c| random_hash(c).buckets = 0,
        |c| random_hash(c).planes = 0,
        |c| random_hash(c).planes = 65,
    ];
    assert_told(random(), "impossible hash", &of_random);
    let huge: Lie = |c| (random_hash(c).tables, random_hash(c).buckets) = (1 << 16, 1 << 16);
    assert_told(random(), "more buckets than", &[huge]);
    assert_told(random(), "needs the descriptors", &[|c| c.originals = Originals::F16]);
    let of_learned: [Lie; 10] = [
        |c| learned_hash(c).groups = 0,
        |c| learned_hash(c).centre_blocks = 0,
        |c| learned_hash(c).axes = 0,
        |c| learned_hash(c).axes += 2,
        |c| learned_hash(c).axes = MAX_AXES as u32 + 4,
        |c| learned_hash(c).centre_scale = 0.0,
        |c| learned_hash(c).centre_scale = f32::INFINITY,
        |c| learned_hash(c).residual_scale = -1.0,
        |c| learned_hash(c).residual_scale = f32::INFINITY,
        |c| learned_hash(c).residual_scale = f32::NAN,
    ];
    assert_told(learned(), "impossible hash", &of_learned);
    assert_told(learned(), "more buckets than", &[|c| learned_hash(c).centre_blocks = 1 << 28]);
    assert_told(learned(), "more entries than", &[|c| learned_hash(c).entry_blocks = 0]);
}

#[test]
fn measurements_that_nobody_can_have_made() {
    let measured: [Lie; 4] = [
        |c| c.measured.curve[0].probes = 0,
        |c| c.measured.curve[0].recall_at_10 = 1.1,
        |c| c.measured.curve[0].share_of_database = -0.1,
        |c| c.measured.curve[0].eps_success[5] = f64::NAN,
    ];
    assert_told(random(), "impossible measurement", &measured);
    let sigma: [Lie; 4] = [
        |c| c.sigma.mean_distance = -1.0,
        |c| c.sigma.mean_distance = f64::INFINITY,
        |c| c.sigma.literal = -1.0,
        |c| c.sigma.literal = f64::NAN,
    ];
    assert_told(random(), "impossible sigma", &sigma);
    let calibration: [Lie; 19] = [
        |c| c.calibration.k = 0,
        |c| c.calibration.k = 100_001,
        |c| c.calibration.sigma_scale = 0.0,
        |c| c.calibration.sigma_scale = f64::INFINITY,
        |c| c.calibration.power = 0.0,
        |c| c.calibration.power = f64::INFINITY,
        |c| c.calibration.floor = -0.1,
        |c| c.calibration.floor = f64::INFINITY,
        |c| c.calibration.farthest = Some(0.0),
        |c| c.calibration.farthest = Some(f64::NAN),
        |c| c.calibration.least_probability = -0.1,
        |c| c.calibration.least_probability = 1.1,
        |c| fitted(c).log_likelihood = 0.1,
        |c| fitted(c).log_likelihood = f64::NEG_INFINITY,
        |c| fitted(c).reliability.bins[9].right = 2,
        |c| fitted(c).reliability.bins[9].probability = -0.1,
        |c| fitted(c).reliability.bins[9].probability = 1.1,
        |c| fitted(c).reliability.bins[9].probability = f64::NAN,
        |c| fitted(c).reliability.bins[0].n = u32::MAX,
    ];
    assert_told(random(), "impossible calibration", &calibration);
}

#[test]
fn sections_that_are_not_where_they_are_said_to_be() {
    assert_told(random(), "another number of sections", &[|c| c.sections.truncate(3)]);
    let others: [Lie; 2] =
        [|c| c.sections[0].kind = SectionKind::Labels, |c| c.sections[0].element = ElementType::U32];
    assert_told(random(), "Descriptors is not where it should be", &others);
    let moved: [Lie; 2] = [|c| c.sections[0].offset = 0, |c| c.sections[1].offset += 64];
    assert_told(random(), "does not start where the one before ends", &moved);
    assert_told(random(), "Descriptors has another length", &[|c| c.sections[0].length -= 4]);
    let endless: [Lie; 2] = [
        |c| c.thumbnail_side = u32::MAX,
        // A text may have any length, and file names come after their offsets.
        |c| c.sections[3].length = u64::MAX,
    ];
    assert_told(random(), "is too long", &endless);
    let (catalogue, sections_end) = random();
    assert_told((catalogue.clone(), sections_end - 64), "reaches beyond the catalogue", &[|_| ()]);
    assert_told((catalogue, sections_end + 64), "does not start where the last section ends", &[|_| ()]);
}
