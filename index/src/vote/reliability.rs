//! How often answers of each probability are right.

/// Answers in ten bins of equal width, by the probability that they state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reliability {
    /// From improbable to probable: bin b holds probabilities from b / 10 up to (b + 1) / 10.
    pub bins: [ReliabilityBin; 10],
}

/// The answers of one bin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReliabilityBin {
    /// How many there are.
    pub n: u32,
    /// How many of them are right.
    pub right: u32,
    /// The sum of their probabilities.
    pub probability: f64,
}

impl Reliability {
    /// Of answers, each given as its probability and whether it is right.
    pub fn from_answers(answers: impl IntoIterator<Item = (f64, bool)>) -> Self {
        let mut bins = [ReliabilityBin::default(); 10];
        for (probability, is_right) in answers {
            // Certainty belongs to the last bin.
            if let Some(bin) = bins.get_mut(((probability * 10.0) as usize).min(9)) {
                bin.n += 1;
                bin.right += u32::from(is_right);
                bin.probability += probability;
            }
        }
        Self { bins }
    }

    /// Whether the counts can be those of answers: a file may state any.
    pub(crate) fn is_possible(&self) -> bool {
        let count = self.bins.iter().try_fold(0_u32, |sum, bin| sum.checked_add(bin.n));
        let is_sound = |bin: &ReliabilityBin| {
            // A sum of rounded numbers.
            let most = f64::from(bin.n) + 1e-6;
            bin.right <= bin.n && (0.0..=most).contains(&bin.probability)
        };
        count.is_some() && self.bins.iter().all(is_sound)
    }

    /// How many answers there are.
    pub fn n(&self) -> u32 {
        self.bins.iter().map(|bin| bin.n).sum()
    }

    /// The share of right answers; `None` without answers.
    pub fn accuracy(&self) -> Option<f64> {
        let right: u32 = self.bins.iter().map(|bin| bin.right).sum();
        (self.n() > 0).then(|| f64::from(right) / f64::from(self.n()))
    }

    /// The expected calibration error: how far stated probability and share of right answers lie
    /// apart, averaged over the answers. `None` without answers.
    pub fn expected_error(&self) -> Option<f64> {
        let apart: f64 = self.bins.iter().map(|bin| (bin.probability - f64::from(bin.right)).abs()).sum();
        (self.n() > 0).then(|| apart / f64::from(self.n()))
    }
}

impl ReliabilityBin {
    /// The mean probability that the answers state; `None` without answers.
    pub fn stated(&self) -> Option<f64> {
        (self.n > 0).then(|| self.probability / f64::from(self.n))
    }

    /// The share of them that is right; `None` without answers.
    pub fn found(&self) -> Option<f64> {
        (self.n > 0).then(|| f64::from(self.right) / f64::from(self.n))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        // 0.95 and 1.0 are stated and one of them is right; 0.25 is stated, and right.
        let reliability = Reliability::from_answers([(0.95, true), (1.0, false), (0.25, true)]);
        assert_eq!((reliability.bins[9].n, reliability.bins[9].right, reliability.bins[2].n), (2, 1, 1));
        let expected = (2.0 * (0.975 - 0.5) + 0.75) / 3.0;
        assert!((reliability.expected_error().unwrap() - expected).abs() < 1e-12);
        assert!((reliability.accuracy().unwrap() - 2.0 / 3.0).abs() < 1e-12);
        assert_eq!(Reliability::from_answers([]).expected_error(), None);
    }
}
