//! The power law that measurements follow.

/// `y = scale * x^exponent`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    /// The exponent.
    pub exponent: f64,
    /// The factor before it.
    pub scale: f64,
}

impl PowerLaw {
    /// The law's y.
    #[must_use]
    pub fn at(self, x: f64) -> f64 {
        self.scale * x.powf(self.exponent)
    }
}

/// The least-squares line through the points' logarithms; `None` where fewer than two different x
/// have a y above 0.
#[must_use]
pub fn power_law(points: &[(f64, f64)]) -> Option<PowerLaw> {
    let logs: Vec<(f64, f64)> =
        points.iter().filter(|(x, y)| *x > 0.0 && *y > 0.0).map(|(x, y)| (x.ln(), y.ln())).collect();
    let n = logs.len() as f64;
    let (mean_x, mean_y) =
        (logs.iter().map(|(x, _)| x).sum::<f64>() / n, logs.iter().map(|(_, y)| y).sum::<f64>() / n);
    let spread: f64 = logs.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    let shared: f64 = logs.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    let exponent = shared / spread;
    let law = PowerLaw { exponent, scale: (mean_y - exponent * mean_x).exp() };
    (spread > 0.0 && exponent.is_finite()).then_some(law)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_found_again() {
        let points: Vec<(f64, f64)> = [5e3, 5e4, 5e5].iter().map(|&x: &f64| (x, 3.0 * x.powf(0.7))).collect();
        let law = power_law(&points).unwrap();
        assert!((law.exponent - 0.7).abs() < 1e-9 && (law.scale - 3.0).abs() < 1e-6, "{law:?}");
        assert!((law.at(5e4) - points[1].1).abs() < 1e-6);
        assert_eq!(power_law(&points[..1]), None);
        assert_eq!(power_law(&[(2.0, 1.0), (2.0, 3.0)]), None);
        assert_eq!(power_law(&[]), None);
    }
}
