//! What a network is shown of a hand: its grey and its mask, upright, in a square of few pixels.

use crate::hand_image::{HandImage, floor};

/// Pixels a side of a network's input.
pub const PLANES_SIDE: usize = 48;

/// Planes of a network's input: grey and mask.
pub(super) const PLANES: usize = 2;

/// The longest side, in pixels, of a hand that planes are made of: larger ones are shrunk first.
pub const PLANES_SOURCE_SIDE: usize = 96;
/// Counts changes of the code that change planes.
pub(super) const PLANES_REVISION: u8 = 1;

/// How far behind the uppermost point of an upright hand its arm is shown, in breadths of the hand.
pub const SHOWN_LENGTHS: f64 = 1.6;
/// How much of the square the hand's box leaves free, as a share of the box.
const BORDER: f64 = 0.08;
/// Standard deviations of the grey inside the hand beyond which it is cut off, as highlights are.
const GREY_RANGE: f32 = 3.0;
/// Added to the standard deviation of the grey, which lies in 0 to 1: a flat hand has only noise.
const FLAT: f32 = 0.01;

/// Where a pixel is sampled, in pixels from its centre: hands are up to twice as large as the
/// square.
const SAMPLES: [[f64; 2]; 4] = [[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]];

/// How a hand lies in the square: a linear map about the mask's centroid, then its box is centred
/// and fills the square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Rows of the matrix from places in the picture (x right, y down) to places in the square, up
    /// to scale.
    pub map: [[f64; 2]; 2],
    /// The share of the usual size at which the box is drawn: 1 fills the square.
    pub zoom: f64,
    /// How far the box lies from the middle, right and down, in shares of the square.
    pub shift: [f64; 2],
}

impl Placement {
    /// The hand turned clockwise by an angle and nothing else.
    pub fn turned(radians: f64) -> Self {
        let (sin, cos) = libm::sincos(radians);
        Self { map: [[cos, -sin], [sin, cos]], zoom: 1.0, shift: [0.0; 2] }
    }

    /// The inverse of [`Self::map`]; the identity where there is none.
    fn inverse(&self) -> [[f64; 2]; 2] {
        let [[a, b], [c, d]] = self.map;
        let area = a * d - b * c;
        if area.abs() > 1e-9 {
            [[d / area, -b / area], [-c / area, a / area]]
        } else {
            [[1.0, 0.0], [0.0, 1.0]]
        }
    }
}

/// What is shown of a hand: most of a long arm is not, so that the hand itself is large.
pub fn shown(hand: &HandImage) -> HandImage {
    hand.without_arm(hand.upright_turn_deg(), SHOWN_LENGTHS)
}

/// Writes [`PLANES_SIDE`] x [`PLANES_SIDE`] pixels of two values each into `out`: the grey less its
/// mean, in standard deviations of the grey inside the hand and 0 outside, and the share of the
/// pixel that is hand. What `out` has no room for is dropped.
pub fn planes(hand: &HandImage, placement: &Placement, out: &mut [f32]) {
    let rows = || hand.mask().chunks_exact(hand.width()).enumerate();
    let (mut count, mut sums) = (0u64, [0u64; 2]);
    for (y, row) in rows() {
        let (mut inside, mut by_x) = (0, 0);
        for (&value, x) in row.iter().zip(0u64..) {
            inside += u64::from(value);
            by_x += u64::from(value) * x;
        }
        count += inside;
        sums = [sums[0] + by_x, sums[1] + inside * y as u64];
    }
    let centroid = sums.map(|sum| sum as f64 / count.max(1) as f64);
    let (mut low, mut high) = ([f64::MAX; 2], [f64::MIN; 2]);
    // A map is linear: of a row, nothing comes to lie beyond both its ends.
    let ends = rows().flat_map(|(y, row)| {
        let ends = [row.iter().position(|v| *v != 0), row.iter().rposition(|v| *v != 0)];
        ends.into_iter().flatten().map(move |x| (x, y))
    });
    for (x, y) in ends {
        let (x, y) = (x as f64 - centroid[0], y as f64 - centroid[1]);
        for (axis, [to_x, to_y]) in placement.map.iter().enumerate() {
            let at = to_x * x + to_y * y;
            low[axis] = low[axis].min(at);
            high[axis] = high[axis].max(at);
        }
    }
    // Half a pixel more on either side: places are those of the pixels' centres.
    let extent = (high[0] - low[0]).max(high[1] - low[1]).max(1.0) + 1.0;
    let step = extent * (1.0 + BORDER) / PLANES_SIDE as f64 / placement.zoom;
    let middle: [f64; 2] = std::array::from_fn(|axis| {
        0.5 * (low[axis] + high[axis]) - placement.shift[axis] * step * PLANES_SIDE as f64
    });
    let [[xx, xy], [yx, yy]] = placement.inverse();
    let half = (PLANES_SIDE as f64 - 1.0) / 2.0;
    for (row, pixels) in out.chunks_exact_mut(2 * PLANES_SIDE).take(PLANES_SIDE).enumerate() {
        let v = (row as f64 - half) * step + middle[1];
        for (column, pixel) in pixels.chunks_exact_mut(2).enumerate() {
            let u = (column as f64 - half) * step + middle[0];
            let (mut grey, mut share) = (0.0, 0.0);
            for [du, dv] in SAMPLES {
                let (u, v) = (u + du * step, v + dv * step);
                let (x, y) = (xx * u + xy * v + centroid[0], yx * u + yy * v + centroid[1]);
                let (sum, weight) = sample(hand, x, y);
                grey += sum;
                share += weight;
            }
            let mean = if share > 1e-3 { grey / share / 255.0 } else { 0.0 };
            pixel.copy_from_slice(&[mean, share / SAMPLES.len() as f32]);
        }
    }
    normalise(out);
}

/// Linear interpolation around a place: the grey there, 0 to 255, what is no hand being 0, and the
/// share that is hand.
fn sample(hand: &HandImage, x: f64, y: f64) -> (f32, f32) {
    let (left, top) = (floor(x), floor(y));
    let (fx, fy) = ((x - left as f64) as f32, (y - top as f64) as f32);
    let (mut grey, mut share) = (0.0, 0.0);
    hand.around([left, top], [fx, fy], |inside, value, weight| {
        share += weight * f32::from(inside);
        grey += weight * f32::from(value);
    });
    (grey, share)
}

/// Brings the grey of every hand to the same mean and contrast.
fn normalise(out: &mut [f32]) {
    let (mut count, mut sum, mut squares) = (0.0f32, 0.0f32, 0.0f32);
    for pixel in out.chunks_exact(2).filter(|pixel| pixel[1] > 0.5) {
        count += 1.0;
        sum += pixel[0];
        squares += pixel[0] * pixel[0];
    }
    let mean = sum / count.max(1.0);
    let deviation = (squares / count.max(1.0) - mean * mean).max(0.0).sqrt() + FLAT;
    for pixel in out.chunks_exact_mut(2) {
        pixel[0] = ((pixel[0] - mean) / deviation).clamp(-GREY_RANGE, GREY_RANGE) * pixel[1];
    }
}
