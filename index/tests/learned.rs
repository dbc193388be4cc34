//! An index whose descriptors a network makes: it carries the network, and is read as what it is.

mod support;

use std::path::PathBuf;
use std::sync::Arc;

use grasp_index::{
    BuildError, DescriptorKind, DescriptorModel, DescriptorParams, HandImage, Index, IndexParams,
    IndexWriter, Network, NewEntry, PLANES_SIDE, ParamsError, Placement, SearchOptions, SectionKind, planes,
    shown,
};
use grasp_network::{Architecture, Convolution};
use xxhash_rust::xxh3::xxh3_64;

/// A network of few weights, other ones for each seed.
fn network(seed: u32) -> Arc<Network> {
    let architecture = Architecture {
        side: PLANES_SIDE as u32,
        planes: 2,
        convolutions: vec![Convolution { kernel: 5, stride: 2, outputs: 2 }],
        embedding: 12,
        heads: 3,
        masks: None,
    };
    let count = architecture.parameters().expect("a small network");
    let weight = |at: usize| ((at as u32).wrapping_add(seed << 16).wrapping_mul(2_654_435_761) >> 20) as f32;
    let weights = (0..count).map(|at| weight(at) / 2048.0 - 1.0).collect();
    Arc::new(Network::from_weights(architecture, weights).expect("a network"))
}

/// One that takes smaller pictures.
fn network_of_other_pictures() -> Arc<Network> {
    let architecture =
        Architecture { side: 24, planes: 2, convolutions: Vec::new(), embedding: 12, heads: 3, masks: None };
    let count = architecture.parameters().expect("a small network");
    Arc::new(Network::from_weights(architecture, vec![0.1; count]).expect("a network"))
}

/// A wedge of some size with an arm below.
fn hand(size: usize) -> HandImage {
    let (width, height) = (3 * size, 5 * size);
    let grey: Vec<u8> = (0..width * height)
        .map(|at| {
            let (x, y) = (at % width, at / width);
            let half = if y < 2 * size { size + y / 4 } else { size / 3 };
            if x.abs_diff(3 * size / 2) <= half { (60 + 100 * x / width + 60 * y / height) as u8 } else { 0 }
        })
        .collect();
    HandImage::from_segmented(width, height, &grey, 0).expect("a hand")
}

fn params(network: &Arc<Network>) -> IndexParams {
    let descriptor = DescriptorParams::learned(network);
    IndexParams { descriptor, network: Some(Arc::clone(network)), ..support::small_learned_params() }
}

/// A hand for each entry, turned as it may.
fn turned(n: usize) -> HandImage {
    hand(10 + n % 5).rotated(n as f64 / 7.0)
}

fn bytes(network: &Arc<Network>) -> Vec<u8> {
    let mut writer = IndexWriter::new(params(network)).expect("sound parameters");
    let mut describer =
        DescriptorModel::learned(Arc::clone(network)).expect("a network of the right input").describer();
    for n in 0..36usize {
        let descriptor = describer.describe(&turned(n));
        let entry =
            NewEntry { class: (n % 3) as u16, file: n.to_string(), descriptor, ..NewEntry::default() };
        writer.push(entry).expect("the entry fits");
    }
    writer.finish_bytes().expect("the index is built")
}

#[test]
fn the_index_carries_its_network_and_describes_by_it() {
    let network = network(1);
    let index = Index::from_bytes(&bytes(&network)).expect("the index opens");
    assert_eq!(index.verify().problems, []);
    let model = index.descriptor_model();
    assert_eq!(model.network(), Some(&network));
    assert_eq!(
        index.catalogue().descriptor.kind,
        DescriptorKind::Learned { network: network.fingerprint(), dim: 12 }
    );
    // Entry 17 again, from its picture.
    let query = index.describe(&hand(12).rotated(17.0 / 7.0)).expect("the index describes pictures");
    let found = index.search(&query, &SearchOptions::default()).expect("a query");
    assert_eq!((found.neighbours[0].id, found.neighbours[0].distance), (17, 0.0));
}

#[test]
fn a_network_of_such_heads_says_what_it_takes_the_last_picture_for() {
    let architecture = |heads| Architecture { heads, ..network(1).architecture().clone() };
    let of_heads = |heads| {
        let architecture = architecture(heads);
        let weights = vec![0.01; architecture.parameters().expect("a small network")];
        let network = Network::from_weights(architecture, weights).expect("a network");
        DescriptorModel::learned(Arc::new(network)).expect("a network of the right input")
    };
    // Four classes, the mirrored hand, three stages and a rotation.
    let model = of_heads(4 + 1 + 3 + 6);
    let params = model.params();
    assert!(params.is_learned() && !DescriptorParams::upright().is_learned());
    assert_eq!((params.described_side(), DescriptorParams::upright().described_side()), (96, 48));
    let mut describer = model.describer();
    assert_eq!(describer.opinion(), None);
    describer.describe(&hand(10));
    assert_eq!(describer.opinion().map(|said| said.classes.len()), Some(4));
    let mut other = of_heads(3).describer();
    other.describe(&hand(10));
    assert_eq!(other.opinion(), None);
}

#[test]
fn a_turned_picture_has_about_the_same_descriptor() {
    let mut describer =
        DescriptorModel::learned(network(1)).expect("a network of the right input").describer();
    let hand = hand(18);
    let level = describer.describe(&hand);
    let apart = |other: &[f32]| level.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt();
    let size = apart(&[0.0; 12]);
    for degrees in [-150.0f64, -60.0, 20.0, 110.0] {
        let turned = apart(&describer.describe(&hand.rotated(degrees.to_radians())));
        assert!(turned < 0.12 * size, "{degrees}: {turned} of {size}");
    }
    // Looked at as it lies, it is another picture.
    let fallen = hand.rotated(1.5);
    let as_it_lies = describer.describe_turned(&fallen, 0.0, &fallen);
    assert!(apart(&as_it_lies) > 0.2 * size);
}

#[test]
fn what_a_network_is_shown_has_the_same_grey_whatever_the_light() {
    let bright = hand(20);
    let grey: Vec<u8> = bright.pixels().iter().map(|v| (f32::from(*v) * 0.6 + 4.0) as u8).collect();
    let dim = HandImage::from_mask(bright.width(), bright.height(), &grey, bright.mask()).expect("a hand");
    let see = |hand: &HandImage| {
        let mut out = vec![f32::NAN; 2 * PLANES_SIDE * PLANES_SIDE];
        planes(hand, &Placement::turned(0.3), &mut out);
        out
    };
    let (bright, dim) = (see(&bright), see(&dim));
    assert!(bright.iter().zip(&dim).all(|(a, b)| (a - b).abs() < 0.2));
    for pixel in bright.chunks_exact(2) {
        assert!((-3.0..=3.0).contains(&pixel[0]) && (0.0..=1.0).contains(&pixel[1]), "{pixel:?}");
        assert!(pixel[1] > 0.0 || pixel[0] == 0.0, "there is no grey outside the hand");
    }
}

#[test]
fn what_a_network_is_shown_is_pinned() {
    let mut out = vec![0.0; 2 * PLANES_SIDE * PLANES_SIDE];
    planes(&shown(&hand(20)), &Placement::turned(0.3), &mut out);
    let bytes: Vec<u8> = out.iter().flat_map(|value| value.to_le_bytes()).collect();
    assert_eq!(
        format!("{:016x}", xxh3_64(&bytes)),
        "2324e4cfa165acff",
        "the same hand is shown otherwise: raise PLANES_REVISION in index/src/descriptor/planes.rs, and \
         train the shipped network anew"
    );
}

#[test]
fn most_of_a_long_arm_is_not_shown() {
    let hand = hand(20);
    let without = shown(&hand);
    assert!(without.height() < hand.height() && without.width() == hand.width());
    // However it lies.
    let turned = shown(&hand.rotated(2.0));
    let area = |hand: &HandImage| hand.mask().iter().filter(|v| **v != 0).count() as f64;
    assert!((area(&turned) / area(&without) - 1.0).abs() < 0.05);
}

#[test]
fn a_learned_descriptor_needs_its_own_network() {
    let (one, other) = (network(1), network(2));
    let named = one.fingerprint();
    let refused = IndexWriter::new(IndexParams { network: None, ..params(&one) });
    assert!(matches!(refused, Err(BuildError::Descriptor(ParamsError::Network(n))) if n == named));
    let refused = IndexWriter::new(IndexParams { network: Some(other), ..params(&one) });
    assert!(matches!(refused, Err(BuildError::Descriptor(ParamsError::Network(n))) if n == named));
    let refused = DescriptorParams::learned(&one).describe(&hand(10)).expect_err("there is no network");
    assert_eq!(refused, ParamsError::Network(named));
}

#[test]
fn a_network_of_other_pictures_is_rejected_before_it_is_asked() {
    let other = network_of_other_pictures();
    let refused = DescriptorModel::learned(Arc::clone(&other)).expect_err("it takes other pictures");
    assert_eq!(refused, ParamsError::Input { side: 24, planes: 2 });
    let refused = IndexWriter::new(params(&other)).expect_err("it takes other pictures");
    assert!(matches!(refused, BuildError::Descriptor(ParamsError::Input { side: 24, planes: 2 })));
}

/// Whatever byte of the network is changed, the index does not open: nothing is described wrongly.
#[test]
fn a_damaged_network_is_found_at_opening() {
    let sound = bytes(&network(1));
    let index = Index::from_bytes(&sound).expect("the index opens");
    let sections = &index.catalogue().sections;
    let section = sections.iter().find(|s| s.kind == SectionKind::Network).expect("there is a network");
    let range = section.offset as usize..(section.offset + section.length) as usize;
    assert_eq!(section.xxh3, xxh3_64(&sound[range.clone()]));
    for at in range.step_by(97) {
        let mut damaged = sound.clone();
        damaged[at] ^= 0x10;
        let refused = Index::from_bytes(&damaged).expect_err("the network is damaged").to_string();
        assert!(refused.contains("the network of its descriptors"), "{refused}");
    }
}

/// The fixture describes each picture to the bits that it was written with, and finds each entry by
/// its own descriptor.
fn assert_is_read_for_ever(name: &str, network: &Network) {
    let path = [env!("CARGO_MANIFEST_DIR"), "tests", "fixtures", name];
    let index = Index::open(path.iter().collect::<PathBuf>()).expect("the fixture opens");
    assert_eq!(index.verify().problems, []);
    assert_eq!(index.descriptor_model().network().map(Arc::as_ref), Some(network));
    let mut describer = index.describer();
    for n in 0..36 {
        let written = index.descriptor(n as u32).expect("there are 36 entries").into_owned();
        assert_eq!(describer.describe(&turned(n)), written, "{n}");
        let found = index.search(&written, &SearchOptions::default()).expect("the query is sound");
        assert_eq!(found.neighbours[0].distance, 0.0, "{n}");
    }
}

/// Version 5 had networks in floats alone. The fixture is `bytes(&network(1))` of then.
#[test]
fn an_index_of_version_5_describes_to_the_same_bits_for_ever() {
    assert_is_read_for_ever("v5-network.idx", &network(1));
}

/// Version 6 brought networks in integers, and scanned codes of 8 bits even where descriptors are
/// kept. The fixture is `bytes` of then, of `network(1)` in integers.
#[test]
fn an_index_of_version_6_describes_to_the_same_bits_for_ever() {
    assert_is_read_for_ever("v6-network.idx", &Network::clone(&network(1)).in_integers());
}

#[test]
fn an_index_of_a_network_in_integers_describes_by_it() {
    let integers = Arc::new(Network::clone(&network(1)).in_integers());
    let written = bytes(&integers);
    let index = Index::from_bytes(&written).expect("the index opens");
    assert_eq!(index.descriptor_model().network(), Some(&integers));
    let described = index.describer().describe(&turned(3));
    assert_eq!(described, index.descriptor(3).expect("there are 36 entries").into_owned());
}
