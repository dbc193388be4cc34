//! The file of a network: what is written is read again, and nothing else is.

mod support;

use grasp_network::{Architecture, Convolution, Masks, Network, ReadError, Scratch};
use proptest::prelude::*;
use support::{masked, picture, small, weights};
use xxhash_rust::xxh3::xxh3_64;

fn network() -> Network {
    Network::from_weights(small(), weights(&small(), 1)).unwrap()
}

fn masked_network() -> Network {
    Network::from_weights(masked(), weights(&masked(), 1)).unwrap()
}

/// One of each version of the format.
fn networks() -> [(Network, Architecture); 4] {
    [
        (network(), small()),
        (masked_network(), masked()),
        (network().in_integers(), small()),
        (masked_network().in_integers(), masked()),
    ]
}

/// The bytes with a hash that fits them again.
fn hashed(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.truncate(bytes.len() - 8);
    bytes.extend(xxh3_64(&bytes).to_le_bytes());
    bytes
}

/// The bytes with another number at `at`, and a hash that fits.
fn with_number(network: &Network, at: usize, value: u32) -> Vec<u8> {
    let mut bytes = network.to_bytes();
    bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
    hashed(bytes)
}

fn message(bytes: &[u8]) -> String {
    Network::from_bytes(bytes).unwrap_err().to_string()
}

#[test]
fn a_round_trip_keeps_every_byte() {
    for (network, architecture) in networks() {
        let bytes = network.to_bytes();
        let copy = Network::from_bytes(&bytes).unwrap();
        assert_eq!(copy, network);
        assert_eq!(copy.arithmetic(), network.arithmetic());
        assert_eq!(copy.to_bytes(), bytes);
        assert_eq!(copy.architecture(), &architecture);
        assert_eq!(copy.fingerprint(), xxh3_64(&bytes));
    }
}

#[test]
fn the_format_stays() {
    let fingerprints = networks().map(|(network, _)| network.fingerprint());
    assert_eq!(
        fingerprints,
        [16423724866010552684, 14436974832421869674, 12768660989567649429, 12801927739035164691]
    );
    let versions = networks().map(|(network, _)| network.to_bytes()[8]);
    assert_eq!(versions, [1, 2, 3, 3]);
}

#[test]
fn every_truncated_file_is_reported() {
    for bytes in networks().map(|(network, _)| network.to_bytes()) {
        for length in 0..bytes.len() {
            let error = Network::from_bytes(&bytes[..length]).unwrap_err();
            match error {
                ReadError::Truncated { expected, found } => {
                    assert!(found == length as u64 && expected > found, "{length}: {error}");
                }
                ReadError::NotANetwork => assert_eq!(length, 0),
                _ => panic!("{length}: {error}"),
            }
        }
    }
}

#[test]
fn every_changed_byte_is_reported() {
    for bytes in networks().map(|(network, _)| network.to_bytes()) {
        for at in 0..bytes.len() {
            let mut bytes = bytes.clone();
            bytes[at] ^= 1 << (at % 8);
            match (at, Network::from_bytes(&bytes).unwrap_err()) {
                (0..8, ReadError::NotANetwork) => {}
                (16..24, ReadError::Truncated { .. } | ReadError::TooLong { .. }) => {}
                (8.., ReadError::Damaged) => {}
                (_, error) => panic!("byte {at}: {error}"),
            }
        }
    }
}

#[test]
fn messages_say_what_is_wrong() {
    let with_number = |at, value| with_number(&network(), at, value);
    let messages = [
        message(b"GIF89a"),
        message(&network().to_bytes()[..100]),
        message(&[network().to_bytes(), vec![0]].concat()),
        message(&with_number(8, 4)),
        message(&with_number(12, 17)),
        message(&with_number(24, 300)),
        message(&with_number(40, 4)),
        message(&with_number(44, 3)),
        message(&with_number(36, 6)),
        message(&with_number(64, 0x7c00)),
    ];
    assert_eq!(
        messages,
        [
            "not the weights of a network: the first bytes are others",
            "truncated: 38260 bytes expected, 100 found",
            "too long: 38260 bytes expected, 38261 found",
            "written in version 4 of the format, where this program reads 1 to 3",
            "unsupported network: the number of convolutions is 17, where 0 to 16 are supported",
            "unsupported network: the side is 300, where 1 to 256 pixels are supported",
            "unsupported network: the kernel is 4, where odd sizes to 15 pixels are supported",
            "unsupported network: the stride is 3, where 1 and 2 are supported",
            "malformed: the architecture takes 38302 bytes, and the file has 38260",
            "weight 0 is inf as f16, where -65504 to 65504 are supported",
        ]
    );
}

#[test]
fn masks_belong_to_versions_2_and_3() {
    let masked = masked_network();
    let messages = [
        message(&with_number(&masked, 8, 1)),
        // The first weights become masks.
        message(&with_number(&network(), 8, 2)),
        message(&with_number(&masked, 64, 2)),
        message(&with_number(&masked, 68, 65)),
        message(&with_number(&masked, 72, 0)),
        message(&with_number(&masked, 72, 4)),
        message(&with_number(&masked, 64, 1)),
        message(&with_number(&network(), 8, 3)),
        message(&with_number(&network().in_integers(), 8, 2)),
    ];
    assert_eq!(
        messages,
        [
            "malformed: the architecture takes 38260 bytes, and the file has 38560",
            "unsupported network: the convolution of the masks is 481863889, \
             where those of the network are supported, counted from 0",
            "unsupported network: the convolution of the masks is 2, \
             where those of the network are supported, counted from 0",
            "unsupported network: the number of masks is 65, where 1 to 64 are supported",
            "unsupported network: the number of mask cells a side is 0, where 1 to 16 are supported",
            "malformed: the architecture takes 38784 bytes, and the file has 38560",
            "malformed: the architecture takes 39496 bytes, and the file has 38560",
            "unsupported network: the convolution of the masks is 481863889, \
             where those of the network are supported, counted from 0",
            "unsupported network: the number of masks is 0, where 1 to 64 are supported",
        ]
    );
}

#[test]
fn weights_that_are_no_network_are_rejected() {
    let message = |change: fn(&mut Architecture, &mut Vec<f32>)| {
        let (mut shape, mut weights) = (small(), weights(&small(), 1));
        change(&mut shape, &mut weights);
        Network::from_weights(shape, weights).unwrap_err().to_string()
    };
    let messages = [
        message(|_, weights| weights.truncate(10)),
        message(|_, weights| weights[3] = f32::NAN),
        message(|_, weights| weights[4] = -65_520.0),
        message(|shape, weights| {
            shape.convolutions.push(Convolution { kernel: 1, stride: 1, outputs: 33 });
            *weights = vec![65_504.0; shape.parameters().unwrap()];
        }),
        message(|shape, weights| {
            shape.convolutions.extend([Convolution { kernel: 1, stride: 1, outputs: 33 }; 2]);
            shape.masks = Some(Masks { convolution: 3, count: 1, cells: 1 });
            // With an embedding and heads of 0, only the masks are too large.
            let dense = [4, 5].map(|at| shape.layers().unwrap()[at].parameters());
            let all = shape.parameters().unwrap();
            *weights = vec![65_504.0; all];
            let masks = 33 + 1;
            weights[all - masks - dense[0] - dense[1]..all - masks].fill(0.0);
        }),
    ];
    assert_eq!(
        messages,
        [
            "10 weights, where the architecture has 19094",
            "weight 3 is NaN as f16, where -65504 to 65504 are supported",
            "weight 4 is -inf as f16, where -65504 to 65504 are supported",
            "the weights of layer 3 are so large that its sums could reach 1.6e30",
            "the weights of layer 6 are so large that its sums could reach 1.4e35",
        ]
    );
}

proptest! {
    #[test]
    fn other_bytes_are_never_read(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(Network::from_bytes(&bytes).is_err());
    }

    /// Whoever makes a file can make its hash too: what it says is checked by itself.
    #[test]
    fn hostile_headers_are_rejected_or_run(
        at in 2..19usize,
        value in prop_oneof![any::<u32>(), 0..300u32, 0..4u32, Just(u32::MAX)],
        which in 0..4usize,
    ) {
        let bytes = with_number(&networks()[which].0, 4 * at, value);
        if let Ok(network) = Network::from_bytes(&bytes) {
            // Some shapes have the same number of weights: a side of 9 or 10, halved.
            prop_assert_eq!(network.to_bytes(), bytes);
            network.run(&mut Scratch::default(), &picture(network.architecture(), 1));
        }
    }
}
