//! What a network returns: the same bits as a naive implementation, on every path.

mod support;

use grasp_network::{Architecture, Convolution, Masks, Network, Path, Scratch};
use half::f16;
use proptest::prelude::*;
use support::{architectures, masked, picture, small, weights};

/// Values of a picture, `[y][x][plane]`, 0 outside of it.
struct Picture {
    side: usize,
    planes: usize,
    values: Vec<f32>,
}

impl Picture {
    fn at(&self, y: isize, x: isize, plane: usize) -> f32 {
        let within = |at: isize| usize::try_from(at).ok().filter(|&at| at < self.side);
        match (within(y), within(x)) {
            (Some(y), Some(x)) => self.values[(y * self.side + x) * self.planes + plane],
            _ => 0.0,
        }
    }
}

/// A convolution as it is defined, one product at a time; takes its weights off the front.
fn convolve(input: &Picture, layer: Convolution, padding: usize, weights: &mut &[f32]) -> Picture {
    let (kernel, stride) = (layer.kernel as usize, layer.stride as usize);
    let (planes, outputs) = (input.planes, layer.outputs as usize);
    let (matrix, rest) = weights.split_at(kernel * kernel * planes * outputs);
    let (bias, rest) = rest.split_at(outputs);
    *weights = rest;
    let side = (input.side + 2 * padding - kernel) / stride + 1;
    let mut values = Vec::new();
    for (y, x) in (0..side * side).map(|pixel| (pixel / side, pixel % side)) {
        for output in 0..outputs {
            let mut sum = bias[output];
            for (v, u) in (0..kernel * kernel).map(|at| (at / kernel, at % kernel)) {
                for plane in 0..planes {
                    let row = (y * stride + v) as isize - padding as isize;
                    let column = (x * stride + u) as isize - padding as isize;
                    let weight = matrix[((v * kernel + u) * planes + plane) * outputs + output];
                    sum += input.at(row, column, plane) * weight;
                }
            }
            values.push(sum);
        }
    }
    Picture { side, planes: outputs, values }
}

/// The embedding, the heads and the masks.
fn naive(architecture: &Architecture, weights: &[f32], input: &[f32]) -> [Vec<f32>; 3] {
    let weights: Vec<f32> = weights.iter().map(|&weight| f16::from_f32(weight).to_f32()).collect();
    let mut weights = weights.as_slice();
    let mut picture = Picture {
        side: architecture.side as usize,
        planes: architecture.planes as usize,
        values: input.to_vec(),
    };
    let mut read = None;
    for (at, &layer) in (0..).zip(&architecture.convolutions) {
        picture = convolve(&picture, layer, layer.kernel as usize / 2, &mut weights);
        for value in &mut picture.values {
            *value = if *value > 0.0 { *value } else { 0.0 };
        }
        if let Some(masks) = architecture.masks.filter(|masks| masks.convolution == at) {
            read = Some((masks, Picture { values: picture.values.clone(), ..picture }));
        }
    }
    let mut dense = |input: &Picture, outputs| {
        let layer = Convolution { kernel: input.side as u32, stride: 1, outputs };
        convolve(input, layer, 0, &mut weights)
    };
    let mut embedding = dense(&picture, architecture.embedding);
    for value in &mut embedding.values {
        *value = if *value > 0.0 { *value } else { *value * 0.25 };
    }
    let heads = dense(&embedding, architecture.heads);
    let masks = read.map(|(masks, picture)| masks_of(masks, &picture, &mut weights));
    [embedding.values, heads.values, masks.unwrap_or_default()]
}

/// The masks, value by value.
fn masks_of(masks: Masks, picture: &Picture, weights: &mut &[f32]) -> Vec<f32> {
    let (count, cells) = (masks.count as usize, masks.cells as usize);
    let layer = Convolution { kernel: 1, stride: 1, outputs: (count * cells * cells) as u32 };
    let outputs = convolve(picture, layer, 0, weights);
    let side = picture.side * cells;
    let value = |at: usize| {
        let (mask, y, x) = (at / side / side, at / side % side, at % side);
        let plane = (mask * cells + y % cells) * cells + x % cells;
        outputs.at((y / cells) as isize, (x / cells) as isize, plane)
    };
    (0..count * side * side).map(value).collect()
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|value| value.to_bits()).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_path_returns_the_bits_of_the_naive_one(
        architecture in architectures([1, 3, 5, 7, 9], 1..=70u32),
        seed: u64,
    ) {
        let weights = weights(&architecture, seed);
        let network = Network::from_weights(architecture.clone(), weights.clone()).unwrap();
        let copy = Network::from_bytes(&network.to_bytes()).unwrap();
        // Used again: nothing of one picture may be left in the next one's.
        let mut scratch = Scratch::default();
        for picture in [picture(&architecture, seed ^ 1), picture(&architecture, seed ^ 2)] {
            let [embedding, heads, masks] = naive(&architecture, &weights, &picture);
            for path in Path::available() {
                for network in [&network, &copy] {
                    let network = network.clone().with_path(path);
                    let output = network.run(&mut scratch, &picture);
                    prop_assert_eq!(bits(output.embedding), bits(&embedding), "{}", path.name());
                    prop_assert_eq!(bits(output.heads), bits(&heads), "{}", path.name());
                    prop_assert_eq!(bits(output.masks), bits(&masks), "{}", path.name());
                }
            }
        }
    }
}

#[test]
fn the_bits_are_those_of_every_other_machine() {
    let network = Network::from_weights(small(), weights(&small(), 1)).unwrap();
    let mut scratch = Scratch::default();
    let output = network.run(&mut scratch, &picture(&small(), 2));
    assert_eq!(bits(output.heads), [3199133199, 1047402878, 1041938834, 3204052308, 1032221047]);
    assert_eq!(bits(&output.embedding[..3]), [1039924188, 1053411510, 3185752449]);
    let network = Network::from_weights(masked(), weights(&masked(), 1)).unwrap();
    let output = network.run(&mut scratch, &picture(&masked(), 2));
    assert_eq!(bits(output.heads)[..2], [3199133199, 1047402878]);
    assert_eq!(
        (bits(&output.masks[..3]), output.masks.len()),
        (vec![3197283234, 1060079294, 3192804792], 2 * 15 * 15)
    );
}

#[test]
fn a_scratch_fits_itself_to_another_network() {
    let shape = |kernel, side| Architecture {
        side,
        planes: 1,
        convolutions: vec![Convolution { kernel, stride: 1, outputs: 3 }],
        embedding: 4,
        heads: 2,
        masks: None,
    };
    let masked = |convolution| Architecture {
        convolutions: [3, 5, 1].map(|kernel| Convolution { kernel, stride: 1, outputs: 3 }).to_vec(),
        masks: Some(Masks { convolution, count: 1, cells: 2 }),
        ..shape(3, 6)
    };
    // Padded inputs of equal sizes, whose zeros lie elsewhere; equal layers, whose masks are read
    // elsewhere.
    let shapes = [shape(5, 4), shape(3, 6), shape(1, 8), shape(5, 4)];
    let networks = [masked(0), masked(1), masked(2), shape(3, 6), masked(0)];
    let networks = [shapes.as_slice(), &networks].concat();
    let networks: Vec<_> = networks
        .into_iter()
        .map(|shape| Network::from_weights(shape.clone(), weights(&shape, 3)).unwrap())
        .collect();
    let mut shared = Scratch::default();
    for network in &networks {
        let input = picture(network.architecture(), 4);
        let mut own = Scratch::default();
        assert_eq!(network.run(&mut shared, &input), network.run(&mut own, &input));
    }
}

#[test]
fn outputs_are_finite_for_the_largest_weights_and_inputs() {
    let architecture = small();
    let weights = vec![65_504.0; architecture.parameters().unwrap()];
    let network = Network::from_weights(architecture.clone(), weights).unwrap();
    let input = vec![Network::MAX_INPUT; picture(&architecture, 0).len()];
    let mut scratch = Scratch::default();
    let output = network.run(&mut scratch, &input);
    // One more layer would be too many, and is rejected: see tests/file.rs.
    assert!(output.heads.iter().all(|&value| value > 1e28 && value < 1e31), "{:?}", output.heads);
}

#[test]
#[should_panic(expected = "the values of a picture")]
fn an_input_of_another_length_panics() {
    let network = Network::from_weights(small(), weights(&small(), 1)).unwrap();
    network.run(&mut Scratch::default(), &[0.0; 9]);
}
