//! Where a layer's pixels lie in the buffers.

use crate::layer::Layer;

/// Where an output pixel reads and writes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pixel {
    /// The first value of its window in the input's buffer.
    pub(crate) input: usize,
    /// Its first value in the output's buffer, which has the padding of the next layer.
    pub(crate) output: usize,
}

/// Pixels of zeros on each side of the buffers that a layer reads and writes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Borders {
    /// At least the layer's own padding.
    pub(crate) input: usize,
    pub(crate) output: usize,
}

impl Borders {
    /// Those of layer `at`, which reads the output of layer `source`, or the picture.
    pub(crate) fn of_layer(layers: &[Layer], at: usize, source: Option<usize>) -> Self {
        Self {
            input: source.map_or(layers[at].padding, |source| Self::of_output(layers, source)),
            output: Self::of_output(layers, at),
        }
    }

    /// Pixels of zeros around the output of layer `at`: what the next layer needs.
    pub(crate) fn of_output(layers: &[Layer], at: usize) -> usize {
        layers.get(at + 1).map_or(0, |next| next.padding)
    }

    /// Values from a row of the input's buffer to the next.
    pub(crate) fn input_row(self, layer: &Layer) -> usize {
        (layer.input_side + 2 * self.input) * layer.input_planes
    }
}

/// Where a layer's output pixels read and write, row by row.
pub(crate) fn pixels(layer: &Layer, borders: Borders) -> Vec<Pixel> {
    let (side, border) = (layer.output_side, borders.output);
    // A layer that needs less padding than the buffer has begins inside of it.
    let inset = borders.input - layer.padding;
    let place = |y: usize, x: usize| Pixel {
        input: (y * layer.stride + inset) * borders.input_row(layer)
            + (x * layer.stride + inset) * layer.input_planes,
        output: ((y + border) * (side + 2 * border) + x + border) * layer.output_planes,
    };
    (0..side * side).map(|pixel| place(pixel / side, pixel % side)).collect()
}
