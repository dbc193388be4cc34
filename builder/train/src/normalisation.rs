//! Batch normalisation with the rectifier that follows it.
//!
//! Ioffe and Szegedy, "Batch normalization", 2015: each plane is brought to mean 0 and variance 1
//! over all pixels of all samples of a batch, then scaled and shifted by trained values.

/// Added to every variance.
pub(crate) const EPSILON: f64 = 1e-3;

/// Sums over some samples of a plane's values, a pair of quantities for each plane.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sums {
    pub(crate) first: Vec<f64>,
    pub(crate) second: Vec<f64>,
}

impl Sums {
    fn new(planes: usize) -> Self {
        Self { first: vec![0.0; planes], second: vec![0.0; planes] }
    }

    /// Adds the slices' sums in their order.
    pub(crate) fn total(planes: usize, slices: &[Self]) -> Self {
        let mut total = Self::new(planes);
        for slice in slices {
            total.first.iter_mut().zip(&slice.first).for_each(|(sum, v)| *sum += v);
            total.second.iter_mut().zip(&slice.second).for_each(|(sum, v)| *sum += v);
        }
        total
    }

    /// Adds what was summed in f32 over one sample.
    fn add(&mut self, first: &mut [f32], second: &mut [f32]) {
        self.first.iter_mut().zip(&mut *first).for_each(|(sum, v)| *sum += f64::from(*v));
        self.second.iter_mut().zip(&mut *second).for_each(|(sum, v)| *sum += f64::from(*v));
        first.fill(0.0);
        second.fill(0.0);
    }
}

/// One plane's normalisation for all planes: `y = x * factor + offset`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Normalisation {
    pub(crate) mean: Vec<f32>,
    pub(crate) variance: Vec<f32>,
    inverse_deviation: Vec<f32>,
    pub(crate) factor: Vec<f32>,
    pub(crate) offset: Vec<f32>,
}

impl Normalisation {
    /// By the statistics of a batch: `sums` holds each plane's sum and sum of squares.
    pub(crate) fn of_batch(sums: &Sums, count: usize, scale: &[f32], shift: &[f32]) -> Self {
        let count = count as f64;
        let moments = sums.first.iter().zip(&sums.second).map(|(sum, squares)| {
            let mean = sum / count;
            (mean, (squares / count - mean * mean).max(0.0))
        });
        Self::new(moments, scale, shift)
    }

    /// By known means and variances.
    pub(crate) fn of_statistics(mean: &[f32], variance: &[f32], scale: &[f32], shift: &[f32]) -> Self {
        let moments = mean.iter().zip(variance).map(|(&mean, &v)| (f64::from(mean), f64::from(v)));
        Self::new(moments, scale, shift)
    }

    fn new(moments: impl Iterator<Item = (f64, f64)>, scale: &[f32], shift: &[f32]) -> Self {
        let mut this = Self::default();
        for ((mean, variance), (&scale, &shift)) in moments.zip(scale.iter().zip(shift)) {
            let inverse = 1.0 / (variance + EPSILON).sqrt();
            let factor = f64::from(scale) * inverse;
            this.mean.push(mean as f32);
            this.variance.push(variance as f32);
            this.inverse_deviation.push(inverse as f32);
            this.factor.push(factor as f32);
            this.offset.push((f64::from(shift) - mean * factor) as f32);
        }
        this
    }

    fn planes(&self) -> usize {
        self.factor.len()
    }

    /// Normalises and rectifies: what is below 0 is multiplied by `slope`.
    pub(crate) fn apply(&self, slope: f32, values: &[f32], outputs: &mut [f32]) {
        let planes = self.planes();
        for (values, outputs) in values.chunks_exact(planes).zip(outputs.chunks_exact_mut(planes)) {
            let by_plane = self.factor.iter().zip(&self.offset);
            for ((output, value), (factor, offset)) in outputs.iter_mut().zip(values).zip(by_plane) {
                let y = value * factor + offset;
                *output = if y > 0.0 { y } else { slope * y };
            }
        }
    }

    /// Passes `gradients` back through the rectifier, in place, and sums each plane's gradient and
    /// gradient times normalised value: the gradients of shift and scale. A sample has `size`
    /// values.
    pub(crate) fn rectifier_backward(
        &self,
        slope: f32,
        size: usize,
        values: &[f32],
        gradients: &mut [f32],
    ) -> Sums {
        let planes = self.planes();
        let mut sums = Sums::new(planes);
        // Sums over a sample stay short enough for f32, which is summed several times as fast.
        let (mut first, mut second) = (vec![0.0; planes], vec![0.0; planes]);
        for (values, gradients) in values.chunks_exact(size).zip(gradients.chunks_exact_mut(size)) {
            let pixels = values.chunks_exact(planes).zip(gradients.chunks_exact_mut(planes));
            for (values, gradients) in pixels {
                let by_plane = self.factor.iter().zip(&self.offset);
                let moments = self.mean.iter().zip(&self.inverse_deviation);
                let targets = first.iter_mut().zip(&mut second);
                let values = gradients.iter_mut().zip(values);
                for ((((g, x), (factor, offset)), (mean, inverse)), (first, second)) in
                    values.zip(by_plane).zip(moments).zip(targets)
                {
                    let y = x * factor + offset;
                    *g = if y > 0.0 { *g } else { slope * *g };
                    *first += *g;
                    *second += *g * ((x - mean) * inverse);
                }
            }
            sums.add(&mut first, &mut second);
        }
        sums
    }

    /// Passes `gradients` back through the normalisation, in place. `totals` are the sums of
    /// [`Self::rectifier_backward`] over the batch, `count` the values of each plane.
    pub(crate) fn backward(&self, totals: &Sums, count: usize, values: &[f32], gradients: &mut [f32]) {
        // factor * (g - mean(g) - n * mean(g * n)), n = (x - mean) * inverse, as a * g + b * x + c.
        let planes = self.planes();
        let count = count as f64;
        let (mut of_value, mut constant) = (Vec::with_capacity(planes), Vec::with_capacity(planes));
        for plane in 0..planes {
            let (factor, inverse) = (f64::from(self.factor[plane]), f64::from(self.inverse_deviation[plane]));
            let slope = factor * inverse * totals.second[plane] / count;
            of_value.push(-slope as f32);
            let mean = f64::from(self.mean[plane]);
            constant.push((slope * mean - factor * totals.first[plane] / count) as f32);
        }
        for (values, gradients) in values.chunks_exact(planes).zip(gradients.chunks_exact_mut(planes)) {
            let terms = self.factor.iter().zip(of_value.iter().zip(&constant));
            for ((g, x), (a, (b, c))) in gradients.iter_mut().zip(values).zip(terms) {
                *g = a * *g + b * x + c;
            }
        }
    }
}

/// Each plane's sum and sum of squares, of samples of `size` values.
pub(crate) fn sums(planes: usize, size: usize, values: &[f32]) -> Sums {
    let mut sums = Sums::new(planes);
    let (mut first, mut second) = (vec![0.0; planes], vec![0.0; planes]);
    for sample in values.chunks_exact(size) {
        for pixel in sample.chunks_exact(planes) {
            for ((x, first), second) in pixel.iter().zip(&mut first).zip(&mut second) {
                *first += x;
                *second += x * x;
            }
        }
        sums.add(&mut first, &mut second);
    }
    sums
}
