//! What a quantised network returns: the same bits as a naive implementation, on every path, and
//! nearly what its network does.

mod support;

use grasp_network::{
    Architecture, Convolution, Layer, Masks, Network, Path, QuantisedNetwork, ReadError, Rectifier, Scratch,
};
use half::f16;
use proptest::prelude::*;
use support::{architectures, picture, weights};

/// The embedding, the heads and the masks.
type Outputs = [Vec<f32>; 3];

/// A layer's values, `[y][x][plane]`.
#[derive(Clone)]
struct Values {
    side: usize,
    planes: usize,
    values: Vec<f32>,
}

/// Values as integers, and what each counts.
fn rounded(values: &[f32]) -> (Vec<i64>, f32) {
    let largest = values.iter().copied().fold(0.0, f32::max);
    let scale = if 255.0 / largest < f32::INFINITY { 255.0 / largest } else { 0.0 };
    (values.iter().map(|value| (value * scale).round_ties_even() as i64).collect(), largest / 255.0)
}

/// The weights of one output as integers, and what each counts.
fn rounded_weights(weights: &[f32]) -> (Vec<i64>, f32) {
    let unit = weights.iter().fold(0.0f32, |largest, weight| largest.max(weight.abs())) / 127.0;
    let scale = if unit > 0.0 { 1.0 / unit } else { 0.0 };
    (weights.iter().map(|weight| (weight * scale).round_ties_even() as i64).collect(), unit)
}

/// One layer as it is defined, one product at a time.
fn layer(layer: &Layer, input: &Values, parameters: &[f32], in_integers: bool) -> Values {
    let (matrix, biases) = parameters.split_at(layer.inputs() * layer.output_planes);
    let (integers, unit) = rounded(&input.values);
    let place = |pixel: usize, tap: usize| {
        let at = |output: usize, tap: usize| {
            let at = (output * layer.stride + tap).checked_sub(layer.padding)?;
            (at < input.side).then_some(at)
        };
        let y = at(pixel / layer.output_side, tap / input.planes / layer.kernel)?;
        let x = at(pixel % layer.output_side, tap / input.planes % layer.kernel)?;
        Some((y * input.side + x) * input.planes + tap % input.planes)
    };
    let mut values = Vec::new();
    for pixel in 0..layer.output_side * layer.output_side {
        for (output, bias) in biases.iter().enumerate() {
            let column: Vec<f32> = matrix.iter().skip(output).step_by(layer.output_planes).copied().collect();
            let value = if in_integers {
                let (weights, of_weights) = rounded_weights(&column);
                let product =
                    |(tap, weight): (usize, &i64)| place(pixel, tap).map(|at| integers[at] * weight);
                let sum: i64 = weights.iter().enumerate().filter_map(product).sum();
                sum as f32 * (unit * of_weights) + bias
            } else {
                let input = |tap| place(pixel, tap).map_or(0.0, |at| input.values[at]);
                column.iter().enumerate().fold(*bias, |sum, (tap, weight)| sum + input(tap) * weight)
            };
            values.push(match layer.rectifier {
                Rectifier::Zero if value > 0.0 => value,
                Rectifier::Zero => 0.0,
                Rectifier::Leaky if value > 0.0 => value,
                Rectifier::Leaky => value * Architecture::LEAK,
                Rectifier::None => value,
            });
        }
    }
    Values { side: layer.output_side, planes: layer.output_planes, values }
}

/// What a network of these weights returns, its layers computed in integers where their inputs come
/// from a convolution and in fours.
fn naive(architecture: &Architecture, weights: &[f32], input: &[f32]) -> Outputs {
    let weights: Vec<f32> = weights.iter().map(|&weight| f16::from_f32(weight).to_f32()).collect();
    let convolutions = architecture.convolutions.len();
    let picture = Values {
        side: architecture.side as usize,
        planes: architecture.planes as usize,
        values: input.to_vec(),
    };
    let (mut outputs, mut rest) = (vec![picture], weights.as_slice());
    for (at, shape) in architecture.layers().unwrap().iter().enumerate() {
        let source = match architecture.masks {
            Some(masks) if at == convolutions + 2 => masks.convolution as usize + 1,
            _ => at,
        };
        let (parameters, after) = rest.split_at(shape.parameters());
        let in_integers = (1..=convolutions).contains(&source) && outputs[source].planes.is_multiple_of(4);
        outputs.push(layer(shape, &outputs[source], parameters, in_integers));
        rest = after;
    }
    let masks = architecture.masks.map_or_else(Vec::new, |masks| {
        let values = &outputs[convolutions + 3].values;
        let side = outputs[convolutions + 3].side;
        let mut spread = vec![0.0; values.len()];
        for (from, to) in masks.runs(side) {
            let cells = masks.cells as usize;
            spread[to..][..cells].copy_from_slice(&values[from..][..cells]);
        }
        spread
    });
    [outputs[convolutions + 1].values.clone(), outputs[convolutions + 2].values.clone(), masks]
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|value| value.to_bits()).collect()
}

fn quantised(network: &Network, path: Path) -> QuantisedNetwork {
    QuantisedNetwork::from(&network.clone().with_path(path))
}

/// The same network of prepared bytes that begin at a multiple of 64, and of others.
fn prepared(network: &Network, path: Path) -> [QuantisedNetwork; 2] {
    let bytes = QuantisedNetwork::prepare(&network.to_bytes()).unwrap();
    [0, 4].map(|offset| {
        let room = vec![0; offset + bytes.len() + 64].leak();
        let start = room.as_ptr().align_offset(64) + offset;
        let place = &mut room[start..][..bytes.len()];
        place.copy_from_slice(&bytes);
        QuantisedNetwork::from_prepared(place, path).unwrap()
    })
}

/// About half of all layers are computed in integers.
fn outputs() -> impl Strategy<Value = u32> {
    prop_oneof![(1..=18u32).prop_map(|fours| 4 * fours), 1..=70u32]
}

/// Layers of 16, 40 and 64 planes: half a block of outputs, one and a part of another, and two.
fn wide() -> Architecture {
    Architecture {
        side: 9,
        planes: 3,
        convolutions: vec![
            Convolution { kernel: 5, stride: 2, outputs: 16 },
            Convolution { kernel: 3, stride: 1, outputs: 40 },
            Convolution { kernel: 3, stride: 1, outputs: 64 },
            Convolution { kernel: 3, stride: 2, outputs: 36 },
        ],
        embedding: 20,
        heads: 5,
        masks: Some(Masks { convolution: 2, count: 2, cells: 2 }),
    }
}

/// Networks whose layers are computed in tiles of 2 x 2 outputs where products of words are summed,
/// and others: of an odd side, or of planes that fill no vector.
fn tiled() -> impl Strategy<Value = Architecture> {
    let planes = (3..=18u32).prop_map(|fours| 4 * fours);
    (1..=14u32, planes, outputs(), outputs(), 0..=1u32).prop_map(|(side, planes, then, last, masked)| {
        let convolution = |kernel, outputs| Convolution { kernel, stride: 1, outputs };
        Architecture {
            side,
            planes: 3,
            convolutions: vec![convolution(1, planes), convolution(3, then), convolution(3, last)],
            embedding: 6,
            heads: 3,
            masks: Some(Masks { convolution: 1 + masked, count: 1, cells: 2 }),
        }
    })
}

/// Compares all paths to the naive one, by two pictures in turn.
fn check_bits(architecture: &Architecture, seed: u64) -> Result<(), TestCaseError> {
    let weights = weights(architecture, seed);
    let network = Network::from_weights(architecture.clone(), weights.clone()).unwrap();
    // Used again: nothing of one picture may be left in the next one's.
    let mut scratch = Scratch::default();
    for picture in [picture(architecture, seed ^ 1), picture(architecture, seed ^ 2)] {
        let naive = naive(architecture, &weights, &picture);
        for path in Path::available() {
            let [aligned, moved] = prepared(&network, path);
            for network in [quantised(&network, path), aligned, moved] {
                let output = network.run(&mut scratch, &picture);
                let found = [output.embedding, output.heads, output.masks].map(bits);
                prop_assert_eq!(found, naive.each_ref().map(|values| bits(values)), "{}", path.name());
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_path_returns_the_bits_of_the_naive_one(architecture in architectures([1, 3, 5], outputs()), seed: u64) {
        check_bits(&architecture, seed)?;
    }

    #[test]
    fn so_it_does_by_tiles(architecture in tiled(), seed: u64) {
        check_bits(&architecture, seed)?;
    }
}

/// A layer of 3 x 3 whose inputs are all as large as can be where `is_large`, 0 elsewhere, and whose
/// weights are as large as can be, with the signs of `sign`.
fn extreme(
    planes: u32,
    is_large: fn(usize, usize) -> bool,
    sign: fn(usize) -> f32,
) -> (Architecture, Vec<f32>, Vec<f32>) {
    let architecture = Architecture {
        side: 6,
        planes: 1,
        convolutions: vec![
            Convolution { kernel: 1, stride: 1, outputs: planes },
            Convolution { kernel: 3, stride: 1, outputs: 4 },
        ],
        embedding: 1,
        heads: 1,
        masks: Some(Masks { convolution: 1, count: 1, cells: 1 }),
    };
    let layers = architecture.layers().unwrap();
    let mut weights = vec![1.0; architecture.parameters().unwrap()];
    weights[planes as usize..][..planes as usize].fill(0.0);
    let kernel = &mut weights[layers[0].parameters()..][..9 * planes as usize * 4];
    for (at, weight) in kernel.iter_mut().enumerate() {
        *weight = sign(at / 4 / planes as usize);
    }
    let picture = (0..36).map(|at| f32::from(u8::from(is_large(at / 6, at % 6)))).collect();
    (architecture, weights, picture)
}

#[test]
fn sums_do_not_overflow_where_all_is_as_large_as_can_be() {
    // 204 planes are the most that are computed in tiles.
    for planes in [204, 208] {
        for is_large in [|_, _| true, |y: usize, x: usize| y / 2 % 2 == x / 2 % 2, |y, x| y % 2 == x % 2] {
            for sign in [|_| 1.0, |tap: usize| if tap.is_multiple_of(2) { 1.0 } else { -1.0 }] {
                let (architecture, weights, picture) = extreme(planes, is_large, sign);
                let naive = naive(&architecture, &weights, &picture);
                let network = Network::from_weights(architecture, weights).unwrap();
                for path in Path::available() {
                    let network = quantised(&network, path);
                    let mut scratch = Scratch::default();
                    let output = network.run(&mut scratch, &picture);
                    let found = [output.embedding, output.heads, output.masks].map(bits);
                    assert_eq!(found, naive.each_ref().map(|values| bits(values)), "{}", path.name());
                }
            }
        }
    }
}

#[test]
fn outputs_are_nearly_those_of_floats() {
    let network = Network::from_weights(wide(), weights(&wide(), 5)).unwrap();
    for path in Path::available() {
        let (mut scratch, mut integers) = (Scratch::default(), Scratch::default());
        let input = picture(&wide(), 6);
        let exact = network.run(&mut scratch, &input);
        let network = quantised(&network, path);
        let near = network.run(&mut integers, &input);
        for (exact, near) in
            [(exact.embedding, near.embedding), (exact.heads, near.heads), (exact.masks, near.masks)]
        {
            let size = exact.iter().map(|value| value * value).sum::<f32>().sqrt();
            let off = exact.iter().zip(near).map(|(one, other)| (one - other).powi(2)).sum::<f32>().sqrt();
            assert!(off > 0.0 && off < 0.03 * size, "{}: {off} of {size}", path.name());
        }
    }
}

#[test]
fn the_bits_are_those_of_every_other_machine() {
    let network = Network::from_weights(wide(), weights(&wide(), 1)).unwrap();
    let mut scratch = Scratch::default();
    for path in Path::available() {
        let network = quantised(&network, path);
        let output = network.run(&mut scratch, &picture(&wide(), 2));
        assert_eq!(
            bits(output.heads),
            [3147605179, 1041378926, 3185227930, 3181149669, 3185437093],
            "{}",
            path.name()
        );
        assert_eq!(bits(&output.masks[..3]), [1040399370, 3177482200, 1035508797], "{}", path.name());
    }
}

#[test]
fn a_network_in_integers_is_the_quantised_one() {
    for path in Path::available() {
        let floats = Network::from_weights(wide(), weights(&wide(), 6)).unwrap().with_path(path);
        let (quantised, integers) = (quantised(&floats, path), floats.clone().in_integers());
        assert_eq!((integers.path(), integers.weights()), (path, floats.weights()));
        assert_ne!((integers.fingerprint(), &integers), (floats.fingerprint(), &floats));
        let (mut scratch, mut other) = (Scratch::default(), Scratch::default());
        let input = picture(&wide(), 7);
        assert_eq!(integers.run(&mut scratch, &input), quantised.run(&mut other, &input));
        // The memory serves either, by turns.
        let of_floats = floats.run(&mut other, &input).embedding.to_vec();
        assert_eq!(floats.run(&mut scratch, &input).embedding, of_floats);
        assert_eq!(integers.run(&mut scratch, &input), quantised.run(&mut other, &input));
    }
}

#[test]
fn prepared_bytes_of_another_form_or_length_are_rejected() {
    let network = Network::from_weights(wide(), weights(&wide(), 8)).unwrap();
    let bytes: &'static [u8] = QuantisedNetwork::prepare(&network.to_bytes()).unwrap().leak();
    let read = |bytes| QuantisedNetwork::from_prepared(bytes, Path::best()).map(|_| ());
    assert_eq!(read(bytes), Ok(()));
    for length in (0..bytes.len()).step_by(97).chain([bytes.len() - 1]) {
        assert!(read(&bytes[..length]).is_err(), "{length} of {} bytes", bytes.len());
    }
    let longer: &'static [u8] = [bytes, &[0]].concat().leak();
    let (expected, found) = (bytes.len() as u64, longer.len() as u64);
    assert_eq!(read(longer), Err(ReadError::TooLong { expected, found }));
    assert_eq!(read(b"a poem"), Err(ReadError::NotANetwork));
}

#[test]
fn a_scratch_fits_itself_to_another_network() {
    let masked = |convolution| Architecture {
        side: 6,
        planes: 4,
        convolutions: [4, 4, 4].map(|outputs| Convolution { kernel: 3, stride: 1, outputs }).to_vec(),
        embedding: 4,
        heads: 2,
        masks: Some(Masks { convolution, count: 1, cells: 2 }),
    };
    let mut shared = Scratch::default();
    for shape in [masked(0), masked(1), wide(), masked(2), masked(0)] {
        let network =
            QuantisedNetwork::from(&Network::from_weights(shape.clone(), weights(&shape, 3)).unwrap());
        let input = picture(&shape, 4);
        let mut own = Scratch::default();
        assert_eq!(network.run(&mut shared, &input), network.run(&mut own, &input));
    }
}

#[test]
fn outputs_are_finite_for_large_weights_and_inputs_and_0_for_none() {
    let shape = Architecture {
        convolutions: vec![
            Convolution { kernel: 5, stride: 2, outputs: 8 },
            Convolution { kernel: 3, stride: 1, outputs: 32 },
        ],
        masks: None,
        ..wide()
    };
    let mut scratch = Scratch::default();
    for (weight, value) in [(40_000.0, Network::MAX_INPUT), (0.0, 1.0), (1.0, 0.0), (6e-8, 1e-30)] {
        let weights = vec![weight; shape.parameters().unwrap()];
        let network = Network::from_weights(shape.clone(), weights).unwrap();
        let input = vec![value; picture(&shape, 0).len()];
        for path in Path::available() {
            let network = quantised(&network, path);
            let output = network.run(&mut scratch, &input);
            assert!(output.heads.iter().all(|value| value.is_finite()), "{weight}: {:?}", output.heads);
            assert!(weight != 0.0 || output.heads.iter().all(|value| *value == 0.0), "{:?}", output.heads);
        }
    }
}

#[test]
#[should_panic(expected = "the values of a picture")]
fn an_input_of_another_length_panics() {
    let network = QuantisedNetwork::from(&Network::from_weights(wide(), weights(&wide(), 1)).unwrap());
    network.run(&mut Scratch::default(), &[0.0; 9]);
}
