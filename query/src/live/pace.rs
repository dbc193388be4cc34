//! How long the work on each frame took.

use std::fmt;
use std::time::Duration;

/// The steps of a frame's work.
const STEPS: [&str; 4] = ["decode", "recognise", "draw", "encode"];

/// The times of all frames, step by step.
#[derive(Clone, Debug, Default)]
pub struct Pace {
    /// Milliseconds of each frame, all steps together.
    frames: Vec<f32>,
    /// Milliseconds of each step, over all frames.
    sums: [f64; STEPS.len()],
}

impl Pace {
    /// Adds a frame: how long it took to decode, to recognise, to draw and to encode it.
    pub fn add(&mut self, steps: [Duration; STEPS.len()]) {
        let steps = steps.map(|step| 1e3 * step.as_secs_f64());
        self.sums.iter_mut().zip(steps).for_each(|(sum, step)| *sum += step);
        self.frames.push(steps.iter().sum::<f64>() as f32);
    }

    /// How many frames there were.
    pub fn frames(&self) -> usize {
        self.frames.len()
    }

    /// The time that this share of the frames does not exceed, in milliseconds; 0 where there is no
    /// frame.
    pub fn quantile(&self, share: f64) -> f32 {
        let mut sorted = self.frames.clone();
        sorted.sort_by(f32::total_cmp);
        let at = (share * sorted.len() as f64).ceil() as usize;
        sorted.get(at.saturating_sub(1)).copied().unwrap_or_default()
    }
}

impl fmt::Display for Pace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (half, most) = (self.quantile(0.5), self.quantile(0.99));
        write!(f, "a frame takes {half:.1} ms (99 in 100 at most {most:.1}): ")?;
        let count = self.frames.len().max(1) as f64;
        let steps = STEPS.iter().zip(self.sums).map(|(name, sum)| format!("{name} {:.1}", sum / count));
        f.write_str(&steps.collect::<Vec<_>>().join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_of_whole_frames() {
        let mut pace = Pace::default();
        assert_eq!(pace.quantile(0.5), 0.0);
        for ms in 1..=100 {
            pace.add([ms, 0, 0, ms].map(Duration::from_millis));
        }
        assert_eq!((pace.quantile(0.5), pace.quantile(0.99), pace.quantile(1.0)), (100.0, 198.0, 200.0));
        insta::assert_snapshot!(pace, @"a frame takes 100.0 ms (99 in 100 at most 198.0): decode 50.5, recognise 0.0, draw 0.0, encode 50.5");
    }
}
