//! The probabilities of several looks, and of the opinions of the network that looked, as one.

/// The power of the mean of several looks' probabilities that is the probability of all together.
/// Measured on the development hands, where a mean of .65 comes true in .87 to .97 of the pictures;
/// one exponent for both.
const LOOKS: f64 = 1.5;
/// Where there are opinions: the powers of the geometric means of what the neighbours of all looks
/// say, and of the opinions. Of exponents from 0 to 1.2, these make the truth about as probable as
/// any do on both development hands.
const NEIGHBOURS: f64 = 0.5;
const OPINIONS: f64 = 1.0;
/// Probabilities below this count as this: one look that rules a class out must not decide alone.
const PROBABILITY_FLOOR: f64 = 1e-3;

/// What is joined.
pub(crate) struct Joined {
    looks: usize,
    opinions: usize,
    /// Sums over the looks: what the neighbours say, its logarithm, and that of the opinions.
    neighbours: Vec<f64>,
    neighbour_logs: Vec<f64>,
    opinion_logs: Vec<f64>,
}

impl Joined {
    pub(crate) fn new(classes: usize) -> Self {
        let zeros = vec![0.0; classes];
        Self {
            looks: 0,
            opinions: 0,
            neighbours: zeros.clone(),
            neighbour_logs: zeros.clone(),
            opinion_logs: zeros,
        }
    }

    /// Adds a look: what its neighbours say, and its opinion.
    pub(crate) fn add(&mut self, neighbours: &[f64], opinion: Option<&[f64]>) {
        let log = |probability: &f64| libm::log(probability.max(PROBABILITY_FLOOR));
        self.looks += 1;
        for (class, probability) in neighbours.iter().enumerate().take(self.neighbours.len()) {
            self.neighbours[class] += probability;
            self.neighbour_logs[class] += log(probability);
        }
        if let Some(opinion) = opinion {
            self.opinions += 1;
            self.opinion_logs.iter_mut().zip(opinion).for_each(|(sum, own)| *sum += log(own));
        }
    }

    /// The probabilities of all together; several looks that agree are surer than each by itself,
    /// where `is_calibrated`.
    pub(crate) fn probabilities(self, is_calibrated: bool) -> Vec<f64> {
        let each = 1.0 / self.looks.max(1) as f64;
        if self.opinions > 0 {
            let of_opinions = OPINIONS / self.opinions as f64;
            let logs = self.neighbour_logs.iter().zip(&self.opinion_logs);
            return normalised(
                logs.map(|(a, b)| libm::exp(NEIGHBOURS * each * a + of_opinions * b)).collect(),
            );
        }
        let means: Vec<f64> = self.neighbours.iter().map(|sum| each * sum).collect();
        match is_calibrated && self.looks > 1 {
            true => normalised(means.iter().map(|mean| libm::pow(*mean, LOOKS)).collect()),
            false => means,
        }
    }
}

fn normalised(mut values: Vec<f64>) -> Vec<f64> {
    let sum: f64 = values.iter().sum();
    if sum > 0.0 {
        values.iter_mut().for_each(|value| *value /= sum);
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joined(looks: &[([f64; 2], Option<[f64; 2]>)]) -> Vec<f64> {
        let mut joined = Joined::new(2);
        for (neighbours, opinion) in looks {
            joined.add(neighbours, opinion.as_ref().map(<[f64; 2]>::as_slice));
        }
        joined.probabilities(true)
    }

    #[test]
    fn one_look_without_an_opinion_stays_as_it_is() {
        assert_eq!(joined(&[([0.7, 0.3], None)]), [0.7, 0.3]);
        let two = joined(&[([0.7, 0.3], None), ([0.7, 0.3], None)]);
        assert!(two[0] > 0.75 && (two[0] + two[1] - 1.0).abs() < 1e-12, "{two:?}");
    }

    #[test]
    fn an_opinion_counts_more_than_neighbours_and_impossible_is_only_unlikely() {
        let even = joined(&[([0.7, 0.3], Some([0.3, 0.7]))]);
        assert!(even[1] > 0.5 && even[1] < 0.7, "{even:?}");
        let apart = joined(&[([1.0, 0.0], Some([0.0, 1.0]))]);
        assert!(apart.iter().all(|probability| *probability > 0.0) && apart[1] > 0.9, "{apart:?}");
        let same = joined(&[([0.7, 0.3], Some([0.7, 0.3])); 3]);
        assert!(same[0] > 0.75, "{same:?}");
    }
}
