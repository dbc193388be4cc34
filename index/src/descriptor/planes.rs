//! What a network is shown of a hand: its grey and its mask, upright, in a square of few pixels.

use crate::hand_image::HandImage;
use multiversion::multiversion;

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

/// Where a pixel is sampled along each axis, in pixels from its centre: hands are up to twice as
/// large as the square.
const SAMPLES: [f64; 2] = [-0.25, 0.25];
/// Samples across the square.
const ACROSS: usize = SAMPLES.len() * PLANES_SIDE;

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
// With AVX2, where a processor has it, to the same bits.
#[multiversion(targets("x86_64+avx2"))]
pub fn planes(hand: &HandImage, placement: &Placement, out: &mut [f32]) {
    let centroid = centroid(hand);
    let [low, high] = ends(hand, placement, centroid);
    // Half a pixel more on either side: places are those of the pixels' centres.
    let extent = (high[0] - low[0]).max(high[1] - low[1]).max(1.0) + 1.0;
    let step = extent * (1.0 + BORDER) / PLANES_SIDE as f64 / placement.zoom;
    let middle: [f64; 2] = std::array::from_fn(|axis| {
        0.5 * (low[axis] + high[axis]) - placement.shift[axis] * step * PLANES_SIDE as f64
    });
    let framed = Framed::of(hand);
    let [[xx, xy], [yx, yy]] = placement.inverse();
    let half = (PLANES_SIDE as f64 - 1.0) / 2.0;
    // What each place across adds to x and y.
    let mut across = [[0.0; ACROSS]; 2];
    for column in 0..PLANES_SIDE {
        for (sample, du) in SAMPLES.iter().enumerate() {
            let u = (column as f64 - half) * step + middle[0] + du * step;
            across[0][SAMPLES.len() * column + sample] = xx * u;
            across[1][SAMPLES.len() * column + sample] = yx * u;
        }
    }
    for (row, pixels) in out.chunks_exact_mut(2 * PLANES_SIDE).take(PLANES_SIDE).enumerate() {
        // Of each pixel, the share that is hand, and the grey there, over all samples.
        let mut sums = [[0.0f32; 2]; PLANES_SIDE];
        for dv in SAMPLES {
            let v = (row as f64 - half) * step + middle[1] + dv * step;
            let (mut places, down) = (across, [xy * v, yy * v]);
            for axis in 0..2 {
                for place in &mut places[axis] {
                    *place = *place + down[axis] + centroid[axis];
                }
            }
            let samples = framed.samples(places);
            for (sum, samples) in sums.iter_mut().zip(samples.as_chunks::<{ SAMPLES.len() }>().0) {
                for [inside, grey] in samples {
                    sum[0] += inside;
                    sum[1] += grey;
                }
            }
        }
        for (pixel, [share, grey]) in pixels.as_chunks_mut().0.iter_mut().zip(sums) {
            let mean = if share > 1e-3 { grey / share / 255.0 } else { 0.0 };
            *pixel = [mean, share / SAMPLES.len().pow(2) as f32];
        }
    }
    normalise(out);
}

/// The centroid of the mask, x and y. Inlined, as the next, into what is compiled for AVX2.
#[inline(always)]
fn centroid(hand: &HandImage) -> [f64; 2] {
    let (mut count, mut sums) = (0u64, [0u64; 2]);
    for (y, row) in hand.mask().chunks_exact(hand.width()).enumerate() {
        let (mut inside, mut by_x) = (0, 0);
        for (&value, x) in row.iter().zip(0u64..) {
            inside += u64::from(value);
            by_x += u64::from(value) * x;
        }
        count += inside;
        sums = [sums[0] + by_x, sums[1] + inside * y as u64];
    }
    sums.map(|sum| sum as f64 / count.max(1) as f64)
}

/// The least and the greatest places, along each axis of the square, that pixels of the mask come
/// to lie at when they are mapped about its centroid.
#[inline(always)]
fn ends(hand: &HandImage, placement: &Placement, centroid: [f64; 2]) -> [[f64; 2]; 2] {
    let (mut low, mut high) = ([f64::MAX; 2], [f64::MIN; 2]);
    for (y, row) in hand.mask().chunks_exact(hand.width()).enumerate() {
        // A map is linear: of a row, nothing comes to lie beyond both its ends.
        let ends = [row.iter().position(|v| *v != 0), row.iter().rposition(|v| *v != 0)];
        for x in ends.into_iter().flatten() {
            let (x, y) = (x as f64 - centroid[0], y as f64 - centroid[1]);
            for (axis, [to_x, to_y]) in placement.map.iter().enumerate() {
                let at = to_x * x + to_y * y;
                low[axis] = low[axis].min(at);
                high[axis] = high[axis].max(at);
            }
        }
    }
    [low, high]
}

/// A hand in a frame of nothing, so that no place is without pixels around it.
struct Framed {
    /// Of each pixel, 1 and its grey, 0 to 255, where it is hand, and else 0 and 0.
    pixels: Vec<[f32; 2]>,
    width: usize,
    height: usize,
}

impl Framed {
    /// Its pixels on each side: beyond a hand, interpolation is to find two empty ones in a row.
    const FRAME: usize = 2;

    fn of(hand: &HandImage) -> Self {
        let (width, height) = (hand.width() + 2 * Self::FRAME, hand.height() + 2 * Self::FRAME);
        let mut pixels = vec![[0.0; 2]; width * height];
        let rows = pixels.chunks_exact_mut(width).skip(Self::FRAME);
        let hand = hand.mask().chunks_exact(hand.width()).zip(hand.pixels().chunks_exact(hand.width()));
        for (row, (mask, grey)) in rows.zip(hand) {
            for (pixel, (&inside, &grey)) in row[Self::FRAME..].iter_mut().zip(mask.iter().zip(grey)) {
                *pixel = [f32::from(inside), f32::from(grey)];
            }
        }
        Self { pixels, width, height }
    }

    /// Linear interpolation around places, given by their x and their y: the share that is hand,
    /// and the grey there, what is no hand being 0. Each step is done for all places, several of
    /// which a processor takes at a time.
    ///
    /// Loops in place of `map` and `from_fn`: these are compiled for any processor, and are not
    /// inlined into what is for this one.
    #[inline(always)]
    fn samples<const N: usize>(&self, places: [[f64; N]; 2]) -> [[f32; 2]; N] {
        let (mut low, mut shares) = ([[0; N]; 2], [[0.0f32; N]; 2]);
        let axes = places.iter().zip([self.width, self.height]);
        for (((places, length), low), shares) in axes.zip(&mut low).zip(&mut shares) {
            // Places beyond the frame are moved into it: there is as little.
            let most = (length - Self::FRAME - 2) as f64;
            for ((place, low), share) in places.iter().zip(low).zip(shares) {
                let place = place.max(-(Self::FRAME as f64)).min(most);
                let (integer, float) = floor(place);
                *low = integer + Self::FRAME as i32;
                *share = (place - float) as f32;
            }
        }
        let mut samples = [[0.0; 2]; N];
        for n in 0..N {
            let (fx, fy) = (shares[0][n], shares[1][n]);
            let (gx, gy) = (1.0 - fx, 1.0 - fy);
            let at = low[1][n] as usize * self.width + low[0][n] as usize;
            let (above, below) =
                (&self.pixels[at..at + 2], &self.pixels[at + self.width..at + self.width + 2]);
            for of in 0..2 {
                samples[n][of] = gx * gy * above[0][of]
                    + fx * gy * above[1][of]
                    + gx * fy * below[0][of]
                    + fx * fy * below[1][of];
            }
        }
        samples
    }
}

/// The largest integer that is not above a value within 2^31, as an integer and as a float: by sums
/// alone, of which a processor does several at a time, and casts one by one.
#[inline(always)]
fn floor(value: f64) -> (i32, f64) {
    /// Around this, floats are 1 apart, and their last bits count them.
    const INTEGERS: f64 = 1.5 * (1u64 << 52) as f64;
    let nearest = value + INTEGERS;
    let down = if nearest - INTEGERS > value { nearest - 1.0 } else { nearest };
    (down.to_bits() as i32, down - INTEGERS)
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The same a pixel at a time, those beyond the picture left out.
    fn naive(hand: &HandImage, [x, y]: [f64; 2]) -> [f32; 2] {
        let (left, top) = (x.floor(), y.floor());
        let (fx, fy) = ((x - left) as f32, (y - top) as f32);
        let mut sums = [0.0; 2];
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let weight = [1.0 - fx, fx][dx] * [1.0 - fy, fy][dy];
            let (x, y) = (left + dx as f64, top + dy as f64);
            if (0.0..hand.width() as f64).contains(&x) && (0.0..hand.height() as f64).contains(&y) {
                let at = y as usize * hand.width() + x as usize;
                sums[0] += weight * f32::from(hand.mask()[at]);
                sums[1] += weight * f32::from(hand.pixels()[at]);
            }
        }
        sums
    }

    /// Area, centroid and second moments, x and y, of shares of pixels.
    fn moments(shares: impl Iterator<Item = ([f64; 2], f64)> + Clone) -> (f64, [f64; 2], [[f64; 2]; 2]) {
        let area: f64 = shares.clone().map(|(_, share)| share).sum();
        let mean = |of: &dyn Fn([f64; 2]) -> f64| {
            shares.clone().map(|(at, share)| share * of(at)).sum::<f64>() / area
        };
        let middle = [mean(&|at| at[0]), mean(&|at| at[1])];
        let moment = |a: usize, b: usize| mean(&|at| (at[a] - middle[a]) * (at[b] - middle[b]));
        (area, middle, [[moment(0, 0), moment(0, 1)], [moment(1, 0), moment(1, 1)]])
    }

    /// An L with a long and a broad leg.
    fn hand() -> HandImage {
        let is_hand = |x: usize, y: usize| x < 14 || y >= 46;
        let mask: Vec<u8> = (0..40 * 60).map(|at| u8::from(is_hand(at % 40, at / 40))).collect();
        HandImage::from_mask(40, 60, &[100; 40 * 60], &mask).expect("an L is a hand")
    }

    proptest! {
        /// A linear map takes the centroid to the centroid, and the second moments to `M C M^T`.
        #[test]
        fn a_hand_lies_in_the_square_where_its_placement_says(
            turn in -3.2..3.2f64, stretch in 0.8..1.25f64, shear in -0.3..0.3f64, zoom in 0.7..0.95f64,
            shift in prop::array::uniform2(-0.03..0.03f64)
        ) {
            let hand = hand();
            let [[a, b], [c, d]] = Placement::turned(turn).map;
            let map = [[stretch * a + shear * c, stretch * b + shear * d], [c, d]];
            let mut out = vec![0.0; 2 * PLANES_SIDE * PLANES_SIDE];
            planes(&hand, &Placement { map, zoom, shift }, &mut out);

            let pixels = hand.mask().iter().enumerate();
            let of_hand = pixels.map(|(at, &inside)| ([(at % 40) as f64, (at / 40) as f64], f64::from(inside)));
            let mapped = of_hand.map(|([x, y], share)| (map.map(|[to_x, to_y]| to_x * x + to_y * y), share));
            let ends = [0, 1].map(|axis| {
                let inside = mapped.clone().filter(|(_, share)| *share > 0.0).map(|(at, _)| at[axis]);
                inside.fold([f64::MAX, f64::MIN], |[low, high], at| [low.min(at), high.max(at)])
            });
            let extent = ends.map(|[low, high]| high - low);
            let scale = PLANES_SIDE as f64 * zoom / (1.08 * (extent[0].max(extent[1]) + 1.0));
            let (area, middle, second) = moments(mapped);
            let determinant = (map[0][0] * map[1][1] - map[0][1] * map[1][0]).abs();

            let shares = out.chunks_exact(2).enumerate();
            let (shown_area, shown_middle, shown_second) = moments(shares.map(|(at, pixel)| {
                ([(at % PLANES_SIDE) as f64 + 0.5, (at / PLANES_SIDE) as f64 + 0.5], f64::from(pixel[1]))
            }));
            prop_assert!((shown_area / (area * determinant * scale * scale) - 1.0).abs() < 0.02);
            for a in 0..2 {
                let from_middle = (middle[a] - (ends[a][0] + ends[a][1]) / 2.0) * scale;
                let expected = PLANES_SIDE as f64 * (0.5 + shift[a]) + from_middle;
                prop_assert!((shown_middle[a] - expected).abs() < 0.1, "{shown_middle:?}, not {expected}");
                for b in 0..2 {
                    let expected = second[a][b] * scale * scale;
                    prop_assert!((shown_second[a][b] - expected).abs() < 2.0, "{shown_second:?}, not {expected}");
                }
            }
        }
    }

    proptest! {
        #[test]
        fn what_is_sampled_within_and_beyond_a_hand_is_right_to_the_last_bit(
            (width, height) in (16usize..30, 16usize..30),
            seed in any::<u8>(),
            place in (-30.0..40.0f64, -30.0..40.0f64),
            is_exact in any::<bool>(),
        ) {
            let of = |at: usize, by: usize| (at * by + usize::from(seed)) as u8;
            let grey: Vec<u8> = (0..width * height).map(|at| of(at, 37)).collect();
            let mut mask: Vec<u8> = (0..width * height).map(|at| u8::from(of(at, 91) % 5 != 0)).collect();
            // A hand is cropped to its mask.
            (mask[0], mask[width * height - 1]) = (1, 1);
            let hand = HandImage::from_mask(width, height, &grey, &mask).unwrap();
            let place = if is_exact { [place.0.round(), place.1.round()] } else { [place.0, place.1] };
            let framed = Framed::of(&hand);
            prop_assert_eq!(framed.samples([[place[0]], [place[1]]]), [naive(&hand, place)]);
            // Far away there is nothing; what is no place is no reason to panic.
            let far = [[f64::MAX, 0.0, f64::NAN], [0.0, f64::NEG_INFINITY, 1e300]];
            prop_assert!(framed.samples(far)[..2] == [[0.0; 2]; 2]);
        }
    }
}
