//! Separable resampling of a grey picture by a triangle filter: linear interpolation where it is
//! enlarged, an area average where it is shrunk. What lies outside the source is black.

/// Where the samples of one axis fall in the source: sample `i` is centred at `origin + (i + 0.5) *
/// step`, in source pixels, pixel `j` covering `[j, j + 1)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axis {
    /// The source's length in pixels.
    pub(crate) source: usize,
    /// How many samples to take.
    pub(crate) samples: usize,
    /// The source coordinate of the first sample's near edge.
    pub(crate) origin: f32,
    /// Source pixels a sample.
    pub(crate) step: f32,
}

/// The filter of one axis: for each sample, the first source pixel and the weights from there on.
#[derive(Clone, Debug, Default)]
struct Taps {
    first: Vec<usize>,
    weights: Vec<f32>,
    /// Weights a sample, zero-filled.
    stride: usize,
}

impl Taps {
    fn fill(&mut self, axis: Axis) {
        let support = axis.step.max(1.0);
        self.stride = ((2.0 * support).ceil() as usize + 1).min(axis.source);
        self.first.clear();
        self.weights.clear();
        for sample in 0..axis.samples {
            let centre = axis.origin + (sample as f32 + 0.5) * axis.step - 0.5;
            let low = (centre - support).ceil() as i64;
            let high = (centre + support).floor() as i64;
            let weight = |j: i64| (1.0 - (j as f32 - centre).abs() / support).max(0.0);
            // The sum is over the whole filter, the part outside the source too: that part is
            // black.
            let sum: f32 = (low..=high).map(weight).sum();
            let first = low.clamp(0, (axis.source - self.stride) as i64);
            self.first.push(first as usize);
            self.weights.extend((0..self.stride as i64).map(|tap| weight(first + tap) / sum));
        }
    }
}

/// A resampler that keeps its buffers between calls.
#[derive(Clone, Debug, Default)]
pub(crate) struct Resampler {
    across: Taps,
    down: Taps,
    source_row: Vec<f32>,
    rows: Vec<f32>,
}

impl Resampler {
    /// Resamples a picture whose rows `row(y, &mut [f32])` writes, into `out`, where sample `(x,
    /// y)` lies at `start + y * stride + x`. Both axes need at least one source pixel and one
    /// sample.
    pub(crate) fn run(
        &mut self,
        across: Axis,
        down: Axis,
        mut row: impl FnMut(usize, &mut [f32]),
        out: &mut [f32],
        start: usize,
        stride: usize,
    ) {
        self.across.fill(across);
        self.down.fill(down);
        self.source_row.resize(across.source, 0.0);
        self.rows.resize(down.source * across.samples, 0.0);
        for (y, shrunk) in self.rows.chunks_exact_mut(across.samples).enumerate() {
            row(y, &mut self.source_row);
            let taps = self.across.first.iter().zip(self.across.weights.chunks_exact(self.across.stride));
            for (value, (&first, weights)) in shrunk.iter_mut().zip(taps) {
                let pixels = &self.source_row[first..first + self.across.stride];
                *value = weights.iter().zip(pixels).map(|(w, p)| w * p).sum();
            }
        }
        let taps = self.down.first.iter().zip(self.down.weights.chunks_exact(self.down.stride));
        for (y, (&first, weights)) in taps.enumerate() {
            let line = &mut out[start + y * stride..][..across.samples];
            line.fill(0.0);
            for (tap, &weight) in weights.iter().enumerate().filter(|(_, w)| **w != 0.0) {
                let source = &self.rows[(first + tap) * across.samples..][..across.samples];
                for (value, pixel) in line.iter_mut().zip(source) {
                    *value += weight * pixel;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The weight of a source pixel in a sample, and that of all there would be without an end.
    fn share(axis: Axis, sample: usize, pixel: i64) -> f64 {
        let step = f64::from(axis.step);
        let centre = f64::from(axis.origin) + (sample as f64 + 0.5) * step;
        let weight = |pixel: i64| (1.0 - (pixel as f64 + 0.5 - centre).abs() / step.max(1.0)).max(0.0);
        let around = centre as i64;
        weight(pixel) / (around - 20..around + 20).map(weight).sum::<f64>()
    }

    fn axes() -> impl Strategy<Value = Axis> {
        (1..12usize, 1..6usize, -6.0..6.0f32, 0.2..5.0f32).prop_map(|(source, samples, origin, step)| Axis {
            source,
            samples,
            origin,
            step,
        })
    }

    proptest! {
        #[test]
        fn a_sample_is_the_weighted_mean_of_the_pixels_around_it(
            across in axes(), down in axes(), pixels in prop::collection::vec(0.0..255.0f32, 144), margin in 0..3usize
        ) {
            let stride = across.samples + margin;
            let mut out = vec![-1.0; margin + stride * down.samples];
            let row = |y: usize, row: &mut [f32]| row.copy_from_slice(&pixels[12 * y..][..across.source]);
            // Buffers are used again.
            let mut resampler = Resampler::default();
            let (other, mut forgotten) = (Axis { source: 9, samples: 7, origin: 1.0, step: 1.3 }, [0.0; 49]);
            resampler.run(other, other, |_, row| row.fill(100.0), &mut forgotten, 0, 7);
            resampler.run(across, down, row, &mut out, margin, stride);
            for (at, value) in out.into_iter().enumerate() {
                let Some((x, y)) = at.checked_sub(margin).map(|at| (at % stride, at / stride)) else {
                    prop_assert_eq!(value, -1.0);
                    continue;
                };
                if x >= across.samples {
                    prop_assert_eq!(value, -1.0, "beside the picture");
                    continue;
                }
                let mut expected = 0.0;
                for (i, j) in (0..down.source).flat_map(|j| (0..across.source).map(move |i| (i, j))) {
                    let weight = share(across, x, i as i64) * share(down, y, j as i64);
                    expected += weight * f64::from(pixels[12 * j + i]);
                }
                prop_assert!((f64::from(value) - expected).abs() < 0.01, "{x} {y}: {value} {expected}");
            }
        }
    }

    fn resample(source: &[f32], axis: Axis) -> Vec<f32> {
        let mut out = vec![9.0; axis.samples];
        let one = Axis { source: 1, samples: 1, origin: 0.0, step: 1.0 };
        Resampler::default().run(axis, one, |_, row| row.copy_from_slice(source), &mut out, 0, axis.samples);
        out
    }

    #[test]
    fn equal_size_is_a_copy() {
        let axis = Axis { source: 4, samples: 4, origin: 0.0, step: 1.0 };
        assert_eq!(resample(&[1.0, 5.0, 2.0, 8.0], axis), [1.0, 5.0, 2.0, 8.0]);
    }

    #[test]
    fn shrinking_averages_every_source_pixel() {
        let axis = Axis { source: 64, samples: 4, origin: 0.0, step: 16.0 };
        let out = resample(&[3.0; 64], axis);
        // The two inner samples see only the picture, the outer two some black beyond it.
        assert!((out[1] - 3.0).abs() < 1e-5 && (out[2] - 3.0).abs() < 1e-5, "{out:?}");
        assert!(out[0] < 3.0 && out[3] < 3.0, "{out:?}");
    }

    #[test]
    fn outside_is_black() {
        let axis = Axis { source: 2, samples: 4, origin: -10.0, step: 1.0 };
        assert_eq!(resample(&[7.0, 7.0], axis), [0.0; 4]);
    }
}
