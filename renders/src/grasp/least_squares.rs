//! Nonlinear least squares by the method of Levenberg and Marquardt, with derivatives by
//! differences.

use nalgebra::{SMatrix, SVector};

/// The least damping: the steps of Gauss and Newton, all but exactly.
const LEAST_DAMPING: f64 = 1e-6;
/// What the damping is multiplied by where a step is accepted.
const ACCEPTED: f64 = 0.3;

/// Upon what the damping acts.
pub(super) enum Damping {
    /// Each unknown alike (Levenberg).
    Even,
    /// Each unknown by the curvature along it (Marquardt): for unknowns of different units.
    Scaled,
}

/// How a sum of squares is made small.
pub(super) struct LeastSquares {
    pub(super) damping: Damping,
    /// The damping to begin with.
    pub(super) start: f64,
    /// What the damping is multiplied by where a step is rejected.
    pub(super) rejected: f64,
    /// The difference of an unknown by which a derivative is estimated.
    pub(super) difference: f64,
    /// How many steps are tried.
    pub(super) steps: usize,
}

impl LeastSquares {
    /// The unknowns near `start` whose residuals have the least squares. `limit` moves unknowns
    /// that are out of range to where they may be.
    pub(super) fn fit<const UNKNOWNS: usize, const ROWS: usize>(
        &self,
        start: SVector<f64, UNKNOWNS>,
        residuals: impl Fn(&SVector<f64, UNKNOWNS>) -> SVector<f64, ROWS>,
        limit: impl Fn(SVector<f64, UNKNOWNS>) -> SVector<f64, UNKNOWNS>,
    ) -> SVector<f64, UNKNOWNS> {
        let mut unknowns = start;
        let mut here = residuals(&unknowns);
        let mut damping = self.start;
        for _ in 0..self.steps {
            let mut jacobian = SMatrix::<f64, ROWS, UNKNOWNS>::zeros();
            for column in 0..UNKNOWNS {
                let mut there = unknowns;
                there[column] += self.difference;
                jacobian.set_column(column, &((residuals(&there) - here) / self.difference));
            }
            let normal = jacobian.transpose() * jacobian;
            let slope = jacobian.transpose() * here;
            let along = match self.damping {
                Damping::Even => SVector::repeat(damping),
                Damping::Scaled => normal.diagonal() * damping,
            };
            let damped = normal + SMatrix::<f64, UNKNOWNS, UNKNOWNS>::from_diagonal(&along);
            let Some(step) = damped.cholesky().map(|factor| factor.solve(&slope)) else { break };
            let next = limit(unknowns - step);
            let there = residuals(&next);
            if there.norm_squared() < here.norm_squared() {
                (unknowns, here) = (next, there);
                damping = (damping * ACCEPTED).max(LEAST_DAMPING);
            } else {
                damping *= self.rejected;
            }
        }
        unknowns
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    /// Rosenbrock's valley as a sum of squares; its least is 0 at (1, 1).
    fn valley(at: &Vector2<f64>) -> Vector2<f64> {
        Vector2::new(1.0 - at[0], 10.0 * (at[1] - at[0] * at[0]))
    }

    fn search(damping: Damping) -> LeastSquares {
        LeastSquares { damping, start: 1e-2, rejected: 10.0, difference: 1e-6, steps: 200 }
    }

    #[test]
    fn a_crooked_valley_is_followed_to_its_end() {
        for damping in [Damping::Even, Damping::Scaled] {
            let found = search(damping).fit(Vector2::new(-1.2, 1.0), valley, |unknowns| unknowns);
            assert!((found - Vector2::new(1.0, 1.0)).norm() < 1e-4, "{found}");
        }
    }

    #[test]
    fn limits_hold() {
        let within = |unknowns: Vector2<f64>| unknowns.map(|value| value.clamp(-2.0, 0.5));
        let found = search(Damping::Even).fit(Vector2::new(-1.2, 0.5), valley, within);
        assert!(found.iter().all(|value| (-2.0..=0.5).contains(value)), "{found}");
        assert!(valley(&found).norm_squared() < 0.3, "{found}");
    }
}
