//! Which shapes are supported.

mod support;

use grasp_network::{Architecture, Convolution, Masks};
use support::{masked, small};

fn message(change: impl FnOnce(&mut Architecture)) -> String {
    let mut architecture = small();
    change(&mut architecture);
    architecture.validate().unwrap_err().to_string()
}

#[test]
fn the_layers_have_the_documented_sizes() {
    let layers = small().layers().unwrap();
    let sizes: Vec<[usize; 4]> = layers
        .iter()
        .map(|layer| [layer.input_side, layer.input_planes, layer.output_side, layer.output_planes])
        .collect();
    assert_eq!(sizes, [[9, 2, 5, 7], [5, 7, 5, 33], [5, 33, 1, 20], [1, 20, 1, 5]]);
    let parameters: Vec<usize> = layers.iter().map(|layer| layer.parameters()).collect();
    assert_eq!(parameters, [(50 + 1) * 7, (63 + 1) * 33, (825 + 1) * 20, (20 + 1) * 5]);
    assert_eq!(small().parameters().unwrap(), parameters.iter().sum());
}

#[test]
fn the_layer_of_the_masks_comes_last() {
    let layers = masked().layers().unwrap();
    assert_eq!(layers[..4], small().layers().unwrap());
    let last = layers[4];
    assert_eq!([last.input_side, last.input_planes, last.output_side, last.output_planes], [5, 7, 5, 18]);
    assert_eq!(last.parameters(), (7 + 1) * 18);
    assert_eq!((masked().mask_side().unwrap(), small().mask_side().unwrap()), (15, 0));
}

#[test]
fn the_runs_of_the_masks_cover_them_once() {
    let masks = Masks { convolution: 0, count: 2, cells: 3 };
    let runs: Vec<_> = masks.runs(2).collect();
    // Two masks of 6 x 6 values: the first pixel's three lines in each, then the pixel beside it.
    assert_eq!(runs[..7], [(0, 0), (3, 6), (6, 12), (9, 36), (12, 42), (15, 48), (18, 3)]);
    let [mut from, mut to]: [Vec<_>; 2] = runs.into_iter().unzip().into();
    from.sort_unstable();
    to.sort_unstable();
    assert!(from == to && from == (0..72).step_by(3).collect::<Vec<_>>());
}

#[test]
fn each_number_has_a_range() {
    let messages = [
        message(|shape| shape.side = 0),
        message(|shape| shape.side = 257),
        message(|shape| shape.planes = 1025),
        message(|shape| shape.embedding = u32::MAX),
        message(|shape| shape.heads = 0),
        message(|shape| shape.convolutions[0].kernel = 4),
        message(|shape| shape.convolutions[1].stride = 0),
        message(|shape| shape.convolutions[1].outputs = 0),
        message(|shape| shape.convolutions = vec![shape.convolutions[0]; 17]),
        message(|shape| shape.masks = Some(Masks { convolution: 2, count: 1, cells: 1 })),
        message(|shape| shape.masks = Some(Masks { convolution: 1, count: 0, cells: 1 })),
        message(|shape| shape.masks = Some(Masks { convolution: 1, count: 1, cells: u32::MAX })),
        message(|shape| shape.masks = Some(Masks { convolution: 1, count: 5, cells: 16 })),
    ];
    assert_eq!(
        messages,
        [
            "unsupported network: the side is 0, where 1 to 256 pixels are supported",
            "unsupported network: the side is 257, where 1 to 256 pixels are supported",
            "unsupported network: the number of input planes is 1025, \
             where 1 to 1024 are supported",
            "unsupported network: the size of the embedding is 4294967295, \
             where 1 to 1024 are supported",
            "unsupported network: the size of the heads is 0, where 1 to 1024 are supported",
            "unsupported network: the kernel is 4, where odd sizes to 15 pixels are supported",
            "unsupported network: the stride is 0, where 1 and 2 are supported",
            "unsupported network: the number of output planes is 0, where 1 to 1024 are supported",
            "unsupported network: the number of convolutions is 17, where 0 to 16 are supported",
            "unsupported network: the convolution of the masks is 2, \
             where those of the network are supported, counted from 0",
            "unsupported network: the number of masks is 0, where 1 to 64 are supported",
            "unsupported network: the number of mask cells a side is 4294967295, \
             where 1 to 16 are supported",
            "unsupported network: the number of mask values a pixel is 1280, \
             where at most 1024 are supported",
        ]
    );
}

#[test]
fn the_whole_is_bounded() {
    let slow = Convolution { kernel: 15, stride: 1, outputs: 16 };
    let last = Convolution { kernel: 15, stride: 2, outputs: 1 };
    let wide = Convolution { kernel: 3, stride: 1, outputs: 1024 };
    let messages = [
        message(|shape| (shape.side, shape.planes) = (256, 17)),
        message(|shape| (shape.side, shape.convolutions) = (256, vec![slow, last])),
        message(|shape| shape.convolutions = vec![wide; 2]),
        message(|shape| {
            shape.side = 64;
            shape.convolutions[0].stride = 1;
            shape.masks = Some(Masks { convolution: 0, count: 4, cells: 16 });
        }),
    ];
    assert_eq!(
        messages,
        [
            "unsupported network: the number of activations is 1114112, \
             where at most 1048576 a layer are supported",
            "unsupported network: the number of multiply-adds is 2831680128, \
             where at most 1073741824 are supported (with outputs in multiples of 32)",
            "unsupported network: the number of weights is 12112576, \
             where at most 8388608 are supported (with outputs in multiples of 32)",
            "unsupported network: the number of activations is 4194304, \
             where at most 1048576 a layer are supported",
        ]
    );
}
