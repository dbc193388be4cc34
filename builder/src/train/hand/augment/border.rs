//! The hand's border as another segmentation would find it.

use grasp_renders::random::{between, unit};
use rand_chacha::ChaCha8Rng;

use super::noise::{blur, smooth};
use super::picture::Picture;

/// Cells a side of the field by which the border errs.
const CELLS: usize = 12;
/// How steeply the new mask falls off across the border.
const STEEP: f32 = 6.0;

/// Thresholds the blurred mask somewhere between a third and two thirds, a little more here and
/// less there; what comes in has the grey of its neighbours.
pub(super) fn redraw(picture: &mut Picture, rng: &mut ChaCha8Rng) {
    let sigma = between(rng, [0.7, 2.0]) as f32;
    let inside: Vec<f32> = picture.grey.iter().zip(&picture.mask).map(|(g, m)| g * m).collect();
    let grey = blur(&inside, picture.side, sigma);
    let mask = blur(&picture.mask, picture.side, sigma);
    let errors = smooth(picture.side, CELLS, rng);
    let threshold = between(rng, [0.28, 0.72]) as f32;
    let strength = 0.12 * unit(rng) as f32;
    for (at, share) in mask.iter().enumerate() {
        if picture.mask[at] < 0.5 {
            picture.grey[at] = if *share > 1e-3 { grey[at] / share } else { 0.0 };
        }
        picture.mask[at] = ((share + strength * errors[at] - threshold) * STEEP + 0.5).clamp(0.0, 1.0);
    }
}
