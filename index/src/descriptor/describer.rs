//! From a hand image to its descriptor.

use super::gradient::{Field, Padded};
use super::learned::{Learned, NetworkEstimate};
use super::model::DescriptorModel;
use super::params::{DescriptorKind, DescriptorParams, ParamsError, Sampling, Tone};
use super::pyramid;
use crate::hand_image::HandImage;
use crate::resample::{Axis, Resampler};

/// The brightness of a mean pixel of the hand after [`Tone::Normalised`]; its scale is arbitrary,
/// as histograms are normalised.
const MEAN_TONE: f32 = 0.6;

/// Computes descriptors and keeps its buffers between calls: worth having where one picture is
/// described many times.
///
/// ```
/// use grasp_index::{Describer, DescriptorParams, HandImage};
/// let grey: Vec<u8> = (0..40 * 40).map(|i| 50 + (i % 40) as u8 * 4).collect();
/// let hand = HandImage::from_segmented(40, 40, &grey, 0)?;
/// let params = DescriptorParams::default();
/// let mut describer = Describer::new(&params)?;
/// let mut descriptor = vec![0.0; params.dim()];
/// for quarter in 0..4 {
///     let turned = hand.rotated(f64::from(quarter) * std::f64::consts::FRAC_PI_2);
///     describer.describe_into(&turned, &mut descriptor);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Describer {
    params: DescriptorParams,
    resampler: Resampler,
    picture: Padded,
    field: Field,
    columns: Vec<f32>,
    learned: Option<Learned>,
}

impl DescriptorModel {
    /// A describer, with buffers of its own.
    pub fn describer(&self) -> Describer {
        Describer {
            params: *self.params(),
            resampler: Resampler::default(),
            picture: Padded::default(),
            field: Field::default(),
            columns: Vec::new(),
            learned: self.network().cloned().map(Learned::new),
        }
    }
}

impl Describer {
    /// A describer for these parameters.
    ///
    /// # Errors
    /// [`ParamsError`], where they are out of range ([`DescriptorParams::validate`]) or those of a
    /// learned descriptor, whose describers come from [`DescriptorModel`].
    pub fn new(params: &DescriptorParams) -> Result<Self, ParamsError> {
        DescriptorModel::new(*params).map(|model| model.describer())
    }

    /// The descriptor of a hand image: [`DescriptorParams::dim`] values; all are 0
    /// where [`DescriptorParams::describes_pictures`] is not so.
    pub fn describe(&mut self, hand: &HandImage) -> Vec<f32> {
        let mut descriptor = vec![0.0; self.params.dim()];
        self.describe_into(hand, &mut descriptor);
        descriptor
    }

    /// Writes the descriptor of a hand image into `out`. Where `out` is shorter than
    /// [`DescriptorParams::dim`], the rest of the descriptor is dropped; where it is longer, its
    /// end is left alone.
    pub fn describe_into(&mut self, hand: &HandImage, out: &mut [f32]) {
        if let Some(learned) = &mut self.learned {
            learned.describe(hand, self.params.turn_deg(hand), out);
            return;
        }
        self.describe_as_is(&hand.rotated(self.params.turn_deg(hand).to_radians()), out);
    }

    /// The descriptor of a hand image that is turned clockwise by `turn_deg`, by
    /// [`DescriptorParams::turn_deg`] or as somebody wants to try; `turned` is
    /// [that picture](HandImage::rotated), which most callers have a use for besides.
    pub fn describe_turned(&mut self, hand: &HandImage, turn_deg: f64, turned: &HandImage) -> Vec<f32> {
        let mut descriptor = vec![0.0; self.params.dim()];
        match &mut self.learned {
            Some(learned) => learned.describe(hand, turn_deg, &mut descriptor),
            None => self.describe_as_is(turned, &mut descriptor),
        }
        descriptor
    }

    /// What the network of a learned descriptor says by itself of the picture that was described
    /// last.
    pub fn opinion(&self) -> Option<&NetworkEstimate> {
        self.learned.as_ref()?.opinion()
    }

    fn describe_as_is(&mut self, hand: &HandImage, out: &mut [f32]) {
        self.paint(hand);
        let (bins, levels) = (self.params.bins as usize, self.params.levels as usize);
        let mut descriptor = match self.params.kind {
            DescriptorKind::Paper => {
                self.field.count(&self.picture, bins);
                let mut histograms = pyramid::hard(&self.field, bins, levels);
                pyramid::normalise_cells(&mut histograms, bins);
                histograms
            }
            DescriptorKind::Default => {
                self.field.share(&self.picture, bins);
                let mut histograms = pyramid::soft(&self.field, bins, levels, &mut self.columns);
                pyramid::normalise_levels(&mut histograms, bins, levels);
                histograms.iter_mut().for_each(|value| *value = value.sqrt());
                histograms
            }
            DescriptorKind::Raw { .. } | DescriptorKind::Learned { .. } => vec![0.0; self.params.dim()],
        };
        let length = out.len().min(descriptor.len());
        out[..length].swap_with_slice(&mut descriptor[..length]);
    }

    /// Samples the hand image into the padded picture, with the tone that the parameters ask for.
    fn paint(&mut self, hand: &HandImage) {
        let tones = tones(hand, self.params.tone);
        let width = hand.width();
        let row = |y: usize, row: &mut [f32]| {
            let line = y * width..(y + 1) * width;
            let pixels = hand.pixels()[line.clone()].iter().zip(&hand.mask()[line]);
            for (value, (&grey, &inside)) in row.iter_mut().zip(pixels) {
                *value = if inside != 0 { tones[grey as usize] } else { 0.0 };
            }
        };
        let (across, down) = axes(hand, self.params.sampling);
        self.picture.clear(across.samples, down.samples);
        let (start, stride) = (self.picture.start(), self.picture.stride());
        if self.params.sampling == Sampling::Native {
            for y in 0..down.samples {
                row(y, &mut self.picture.values[start + y * stride..][..width]);
            }
        } else {
            self.resampler.run(across, down, row, &mut self.picture.values, start, stride);
        }
    }
}

/// Where the samples lie in the hand image: across and down.
fn axes(hand: &HandImage, sampling: Sampling) -> (Axis, Axis) {
    let (width, height) = (hand.width() as f32, hand.height() as f32);
    let axis = |source: usize, samples: usize, centre: f32, step: f32| Axis {
        source,
        samples,
        origin: centre - step * samples as f32 / 2.0,
        step,
    };
    let middle = (width / 2.0, height / 2.0);
    match sampling {
        Sampling::Native => (
            axis(hand.width(), hand.width(), middle.0, 1.0),
            axis(hand.height(), hand.height(), middle.1, 1.0),
        ),
        Sampling::KeepAspect { side } | Sampling::Upright { side } => {
            // One sample stays black on every side, so that the whole silhouette is an edge.
            let (side, step) = (side as usize, width.max(height) / (f32::from(side) - 2.0));
            (axis(hand.width(), side, middle.0, step), axis(hand.height(), side, middle.1, step))
        }
    }
}

/// What each grey value inside the hand becomes.
fn tones(hand: &HandImage, tone: Tone) -> [f32; 256] {
    let mut tones = std::array::from_fn(|grey| grey as f32);
    let Tone::Normalised { contrast } = tone else {
        return tones;
    };
    let mut counts = [0u32; 256];
    for (&grey, _) in hand.pixels().iter().zip(hand.mask()).filter(|(_, inside)| **inside != 0) {
        counts[grey as usize] += 1;
    }
    let (mut n, mut sum, mut squares) = (0.0f64, 0.0f64, 0.0f64);
    for (grey, &count) in counts.iter().enumerate() {
        let (grey, count) = (grey as f64, f64::from(count));
        n += count;
        sum += count * grey;
        squares += count * grey * grey;
    }
    let mean = sum / n.max(1.0);
    let deviation = (squares / n.max(1.0) - mean * mean).max(0.0).sqrt();
    // A hand without shading has only noise left to stretch: leave it flat.
    let deviation = deviation.max(0.04 * mean).max(1.0);
    for tone in &mut tones {
        let shade = (f64::from(*tone) - mean) / deviation * f64::from(contrast);
        // The darkest crease is still hand, and a highlight no second hand.
        *tone = MEAN_TONE * (1.0 + shade.clamp(-0.8, 0.8)) as f32;
    }
    tones
}

impl DescriptorParams {
    /// The descriptor of a hand image: [`Self::dim`] values, all 0 where
    /// [`Self::describes_pictures`] is not so. [`Describer`] does the same faster for many
    /// pictures.
    ///
    /// # Errors
    /// [`ParamsError`], where the parameters are out of range.
    pub fn describe(&self, hand: &HandImage) -> Result<Vec<f32>, ParamsError> {
        Ok(Describer::new(self)?.describe(hand))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tones of a hand of these two grey values, as many pixels of each.
    fn tones_of(greys: [u8; 2], contrast: f32) -> [f32; 256] {
        let pixels: Vec<u8> = (0..100).map(|at| greys[at % 2]).collect();
        let hand = HandImage::from_mask(10, 10, &pixels, &[1; 100]).expect("a hand");
        tones(&hand, Tone::Normalised { contrast })
    }

    #[test]
    fn a_hand_is_stretched_to_its_contrast_but_noise_is_not() {
        // The mean, the deviation, and how far at least a grey value counts as one deviation.
        for (greys, mean, scale) in
            [([80, 120], 100.0, 20.0), ([99, 101], 100.0, 4.0), ([199, 201], 200.0, 8.0), ([9, 10], 9.5, 1.0)]
        {
            let tones = tones_of(greys, 0.1);
            for grey in greys {
                let expected = 0.6 * (1.0 + 0.1 * (f32::from(grey) - mean) / scale);
                assert!((tones[usize::from(grey)] - expected).abs() < 1e-6, "{greys:?}, {grey}");
            }
        }
    }

    #[test]
    fn a_crease_is_still_hand_and_a_highlight_no_second_one() {
        let tones = tones_of([90, 110], 0.5);
        for (grey, expected) in [(0, 0.12), (90, 0.3), (255, 1.08)] {
            assert!((tones[grey] - expected).abs() < 1e-6, "{grey}: {}", tones[grey]);
        }
    }
}
