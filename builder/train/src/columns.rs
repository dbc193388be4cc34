//! What each output pixel of a convolution sees, as rows of a matrix (im2col), and back.

use grasp_network::Layer;
use std::ops::Range;

/// Writes a row of values `[y][x][plane]` for each output pixel of one sample; 0 outside the
/// picture.
pub(crate) fn gather(shape: &Layer, input: &[f32], columns: &mut [f32]) {
    let line = shape.kernel * shape.input_planes;
    for_each_line(shape, |at, place| {
        let target = &mut columns[at..at + line];
        let Some((inside, source)) = place else {
            target.fill(0.0);
            return;
        };
        target[..inside.start].fill(0.0);
        target[inside.end..].fill(0.0);
        target[inside.clone()].copy_from_slice(&input[source..source + inside.len()]);
    });
}

/// Adds each row's values to the input values that [`gather`] took them from.
pub(crate) fn scatter(shape: &Layer, columns: &[f32], input: &mut [f32]) {
    for_each_line(shape, |at, place| {
        let Some((inside, target)) = place else { return };
        let values = &columns[at + inside.start..at + inside.end];
        for (sum, value) in input[target..].iter_mut().zip(values) {
            *sum += value;
        }
    });
}

/// Calls `visit` for each kernel line of each output pixel: with the place of its `kernel * planes`
/// values in the columns, the part of them that lies inside the picture, and that part's place in
/// the input. One line of a kernel is contiguous in both.
fn for_each_line(shape: &Layer, mut visit: impl FnMut(usize, Option<(Range<usize>, usize)>)) {
    let Layer { input_side: side, input_planes: planes, kernel, stride, padding, .. } = *shape;
    let mut at = 0;
    for y in 0..shape.output_side {
        for x in 0..shape.output_side {
            // In pixels of the input with its border of `padding`.
            let left = x * stride;
            let first = padding.saturating_sub(left).min(kernel);
            let end = (side + padding).saturating_sub(left).min(kernel);
            for line in y * stride..y * stride + kernel {
                let row = line.checked_sub(padding).filter(|&row| row < side && first < end);
                let place = row.map(|row| {
                    let source = (row * side + left + first - padding) * planes;
                    (first * planes..end * planes, source)
                });
                visit(at, place);
                at += kernel * planes;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use grasp_network::{Architecture, Convolution};

    fn layer(side: u32, planes: u32, kernel: u32, stride: u32) -> Layer {
        let convolutions = vec![Convolution { kernel, stride, outputs: 1 }];
        let architecture = Architecture { side, planes, convolutions, embedding: 1, heads: 1, masks: None };
        architecture.layers().expect("a supported architecture")[0]
    }

    #[test]
    fn rows_hold_the_neighbourhood_with_zeros_outside() {
        let input: Vec<f32> = (1..=9).map(|v| v as f32).collect();
        let mut columns = vec![f32::NAN; 4 * 9];
        gather(&layer(3, 1, 3, 2), &input, &mut columns);
        assert_eq!(columns[..9], [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 0.0, 4.0, 5.0]);
        assert_eq!(columns[27..], [5.0, 6.0, 0.0, 8.0, 9.0, 0.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn scatter_is_the_transpose_of_gather() {
        for (side, kernel, stride) in [(5, 3, 1), (6, 5, 2), (2, 7, 1), (1, 5, 2), (7, 1, 2)] {
            let shape = layer(side, 2, kernel, stride);
            let rows = shape.output_side * shape.output_side * shape.inputs();
            let input: Vec<f32> = (0..shape.input_values()).map(|i| ((i * 7) % 11) as f32).collect();
            let columns: Vec<f32> = (0..rows).map(|i| ((i * 5) % 13) as f32).collect();
            let (mut gathered, mut scattered) = (vec![0.0; rows], vec![0.0; input.len()]);
            gather(&shape, &input, &mut gathered);
            scatter(&shape, &columns, &mut scattered);
            let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>();
            assert_eq!(dot(&gathered, &columns), dot(&input, &scattered));
        }
    }
}
