//! From a signed distance to triangles.

mod distance;
mod nets;
mod triangles;

pub(crate) use distance::{RoundCone, RoundTriangle, smooth_union};
pub(crate) use nets::{Field, surface_nets};
pub(crate) use triangles::Mesh;

#[cfg(test)]
use nalgebra::Vector3;

/// Balls that stand apart: places and radii.
#[cfg(test)]
#[derive(Debug)]
pub(crate) struct Balls(pub(crate) Vec<(Vector3<f64>, f64)>);

#[cfg(test)]
impl Field for Balls {
    fn distance(&self, p: &Vector3<f64>) -> f64 {
        self.0.iter().map(|(centre, radius)| (p - centre).norm() - radius).fold(f64::INFINITY, f64::min)
    }

    fn near(&self, centre: &Vector3<f64>, radius: f64) -> Balls {
        let least = self.distance(centre);
        let may_matter =
            |ball: &&(Vector3<f64>, f64)| (centre - ball.0).norm() - ball.1 <= least + 2.0 * radius;
        Balls(self.0.iter().filter(may_matter).copied().collect())
    }
}
