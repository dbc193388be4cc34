//! Which shapes are supported.

mod support;

use grasp_network::{Architecture, Convolution};
use support::small;

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
        ]
    );
}
