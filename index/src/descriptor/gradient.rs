//! Gradient orientation (Equation 1): `phi = atan((dH/dy) / (dH/dx))` in `[0, pi)`, where **x is
//! downward and y rightward**. So 0 is an edge that lies level, pi/2 an upright one.
//!
//! Central differences; outside the picture is black.

/// A picture with a border of one black pixel.
#[derive(Clone, Debug, Default)]
pub(super) struct Padded {
    width: usize,
    height: usize,
    /// `(width + 2) * (height + 2)` values.
    pub(super) values: Vec<f32>,
}

impl Padded {
    /// Makes the picture this size and black.
    pub(super) fn clear(&mut self, width: usize, height: usize) {
        (self.width, self.height) = (width, height);
        self.values.clear();
        self.values.resize((width + 2) * (height + 2), 0.0);
    }

    /// Where the first inner pixel lies in `values`.
    pub(super) fn start(&self) -> usize {
        self.stride() + 1
    }

    /// The distance between rows in `values`.
    pub(super) fn stride(&self) -> usize {
        self.width + 2
    }

    /// For inner row `y`: the row above, itself and the row below, each with the border.
    fn around(&self, y: usize) -> [&[f32]; 3] {
        [0, 1, 2].map(|dy| &self.values[(y + dy) * self.stride()..][..self.stride()])
    }
}

/// For each row, `bins` lines of `width` weights: how much of each pixel falls in each bin.
#[derive(Clone, Debug, Default)]
pub(super) struct Field {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) weights: Vec<f32>,
    down: Vec<f32>,
    right: Vec<f32>,
    position: Vec<f32>,
    magnitude: Vec<f32>,
}

impl Field {
    fn resize(&mut self, picture: &Padded, bins: usize) {
        (self.width, self.height) = (picture.width, picture.height);
        self.weights.resize(self.width * self.height * bins, 0.0);
        for line in [&mut self.down, &mut self.right, &mut self.position, &mut self.magnitude] {
            line.resize(picture.width, 0.0);
        }
    }

    /// The gradient of row `y`, turned by pi where that brings its orientation into `[0, pi)`.
    fn gradient_of_row(&mut self, picture: &Padded, y: usize) {
        let [above, here, below] = picture.around(y);
        let inner = 1..=picture.width;
        let ends = above[inner.clone()].iter().zip(&below[inner]);
        let sides = here.iter().zip(&here[2..]);
        let gradient = self.down.iter_mut().zip(&mut self.right);
        for ((down, right), ((above, below), (before, after))) in gradient.zip(ends.zip(sides)) {
            let (d, r) = (below - above, after - before);
            let turn = r < 0.0 || (r == 0.0 && d < 0.0);
            (*down, *right) = if turn { (-d, -r) } else { (d, r) };
        }
    }

    /// Hard counts: a pixel with a gradient has weight 1 in the bin `[b pi/B, (b+1) pi/B)` of its
    /// orientation.
    pub(super) fn count(&mut self, picture: &Padded, bins: usize) {
        self.resize(picture, bins);
        // The bin follows from the sides of the bins' borders: exact where the orientation lies on
        // a border, as 45 degrees, frequent in pictures of integers, do.
        let borders: Vec<(f32, f32)> = (1..bins)
            .map(|b| libm::sincos(b as f64 * std::f64::consts::PI / bins as f64))
            .map(|(sin, cos)| (sin as f32, cos as f32))
            .collect();
        self.weights.fill(0.0);
        for y in 0..picture.height {
            self.gradient_of_row(picture, y);
            let row = &mut self.weights[y * bins * picture.width..][..bins * picture.width];
            for (x, (&down, &right)) in self.down.iter().zip(&self.right).enumerate() {
                if down != 0.0 || right != 0.0 {
                    let bin = borders.iter().filter(|(sin, cos)| cos * right - sin * down >= 0.0).count();
                    row[bin * picture.width + x] = 1.0;
                }
            }
        }
    }

    /// Soft counts: a pixel's magnitude, shared linearly between the two bins nearest to its
    /// orientation. Bin `b` is centred at `b pi/B`, so that the axes are centres.
    pub(super) fn share(&mut self, picture: &Padded, bins: usize) {
        self.resize(picture, bins);
        let bins_a_radian = bins as f32 / std::f32::consts::PI;
        for y in 0..picture.height {
            self.gradient_of_row(picture, y);
            let polar = self.position.iter_mut().zip(&mut self.magnitude);
            for ((position, magnitude), (&down, &right)) in polar.zip(self.down.iter().zip(&self.right)) {
                *magnitude = (down * down + right * right).sqrt();
                *position = angle(down, right) * bins_a_radian;
            }
            let row = &mut self.weights[y * bins * picture.width..][..bins * picture.width];
            for (bin, line) in row.chunks_exact_mut(picture.width).enumerate() {
                for ((weight, &position), &magnitude) in
                    line.iter_mut().zip(&self.position).zip(&self.magnitude)
                {
                    let apart = (position - bin as f32).abs();
                    let apart = apart.min(bins as f32 - apart);
                    *weight = magnitude * (1.0 - apart).max(0.0);
                }
            }
        }
    }
}

/// `atan2(right, down)` for `right >= 0`, in `[0, pi]`, within 1e-5 radians: the polynomial that
/// shading languages use (NVIDIA Cg standard library, atan2). It needs additions and
/// multiplications alone, so the compiler can do several at a time, and every machine gets the same
/// bits.
fn angle(down: f32, right: f32) -> f32 {
    let steep = down.abs();
    let ratio = right.min(steep) / right.max(steep).max(f32::MIN_POSITIVE);
    let s = ratio * ratio;
    let series = -0.013_480_47 * s + 0.057_477_314;
    let series = series * s - 0.121_239_07;
    let series = series * s + 0.195_635_92;
    let series = series * s - 0.332_994_6;
    let small = (series * s + 0.999_995_6) * ratio;
    let half = if right > steep { std::f32::consts::FRAC_PI_2 - small } else { small };
    if down < 0.0 { std::f32::consts::PI - half } else { half }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_polynomial_is_the_arc_tangent(down in -300.0..300.0f32, right in 0.0..300.0f32) {
            prop_assert!((angle(down, right) - libm::atan2f(right, down)).abs() < 1e-5);
        }
    }

    #[test]
    fn a_level_edge_has_orientation_zero() {
        // x is downward: brightness that grows downward has dH/dy = 0.
        assert_eq!(angle(5.0, 0.0), 0.0);
        assert!((angle(0.0, 5.0) - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
        assert_eq!(angle(0.0, 0.0), 0.0);
    }
}
