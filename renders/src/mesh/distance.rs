//! Signed distances of simple bodies (after I. Quilez, "Distance functions"): negative inside.

use nalgebra::Vector3;

type V = Vector3<f64>;

/// A sphere of radius `ra` at `a` and one of radius `rb` at `b` in a common tight skin.
///
/// A body is asked for many points: what does not depend on them is computed once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RoundCone {
    a: V,
    b: V,
    ra: f64,
    rb: f64,
    // What follows from these, as the source names it.
    ba: V,
    l2: f64,
    il2: f64,
    rr: f64,
    a2: f64,
}

impl RoundCone {
    pub(crate) fn new([a, b]: [V; 2], [ra, rb]: [f64; 2]) -> Self {
        let ba = b - a;
        let l2 = ba.norm_squared();
        let rr = ra - rb;
        Self { a, b, ra, rb, ba, l2, il2: 1.0 / l2, rr, a2: l2 - rr * rr }
    }

    /// The spheres at its ends: centres and radii.
    pub(crate) fn ends(&self) -> [(V, f64); 2] {
        [(self.a, self.ra), (self.b, self.rb)]
    }

    pub(crate) fn distance(&self, p: &V) -> f64 {
        let Self { ra, rb, ba, l2, il2, rr, a2, .. } = *self;
        let pa = p - self.a;
        if a2 <= 0.0 {
            // One sphere swallows the other.
            return (pa.norm() - ra).min((p - self.b).norm() - rb);
        }
        let y = pa.dot(&ba);
        let z = y - l2;
        let x2 = (pa * l2 - ba * y).norm_squared();
        let y2 = y * y * l2;
        let z2 = z * z * l2;
        let k = rr.signum() * rr * rr * x2;
        if z.signum() * a2 * z2 > k {
            return (x2 + z2).sqrt() * il2 - rb;
        }
        if y.signum() * a2 * y2 < k {
            return (x2 + y2).sqrt() * il2 - ra;
        }
        ((x2 * a2 * il2).sqrt() + y * rr) * il2 - ra
    }
}

/// A triangle fattened by a radius.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RoundTriangle {
    radius: f64,
    normal: V,
    normal_length: f64,
    edges: [Edge; 3],
}

/// One edge of a triangle.
#[derive(Debug, Clone, Copy)]
struct Edge {
    from: V,
    along: V,
    length_squared: f64,
    /// In the triangle's plane, toward its inside.
    inward: V,
}

impl RoundTriangle {
    pub(crate) fn new([a, b, c]: [V; 3], radius: f64) -> Self {
        let normal = (b - a).cross(&(a - c));
        let edges = [(a, b), (b, c), (c, a)].map(|(from, to)| {
            let along = to - from;
            Edge { from, along, length_squared: along.norm_squared(), inward: along.cross(&normal) }
        });
        Self { radius, normal, normal_length: normal.norm(), edges }
    }

    pub(crate) fn distance(&self, p: &V) -> f64 {
        let is_inside = self.edges.iter().all(|edge| edge.inward.dot(&(p - edge.from)) >= 0.0);
        let distance = if is_inside {
            (self.normal.dot(&(p - self.edges[0].from)) / self.normal_length).abs()
        } else {
            self.edges.iter().map(|edge| edge.distance(p)).fold(f64::INFINITY, f64::min)
        };
        distance - self.radius
    }
}

impl Edge {
    fn distance(&self, p: &V) -> f64 {
        let p = p - self.from;
        let t = (p.dot(&self.along) / self.length_squared).clamp(0.0, 1.0);
        (p - self.along * t).norm()
    }
}

/// The union of two bodies with the crease between them filled over a width of about `k` metres.
pub(crate) fn smooth_union(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k * 0.25
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = V> {
        (-2.0..2.0f64, -2.0..2.0f64, -2.0..2.0f64).prop_map(|(x, y, z)| V::new(x, y, z))
    }

    proptest! {
        /// A round cone is the union of all spheres between its ends: sample them.
        #[test]
        fn round_cone_is_the_hull_of_its_spheres(p in point(), a in point(), b in point(), ra in 0.1..0.5f64, rb in 0.1..0.5f64) {
            prop_assume!((a - b).norm() > 0.6);
            let naive = (0..=2000)
                .map(|i| f64::from(i) / 2000.0)
                .map(|t| (p - a - (b - a) * t).norm() - ra - (rb - ra) * t)
                .fold(f64::INFINITY, f64::min);
            prop_assume!(naive > 0.0);
            prop_assert!((RoundCone::new([a, b], [ra, rb]).distance(&p) - naive).abs() < 2e-3);
        }

        #[test]
        fn round_triangle_is_the_nearest_of_its_points(p in point(), a in point(), b in point(), c in point()) {
            prop_assume!((b - a).cross(&(c - a)).norm() > 0.2);
            let mut naive = f64::INFINITY;
            for i in 0..=60 {
                for j in 0..=60 - i {
                    let (u, v) = (f64::from(i) / 60.0, f64::from(j) / 60.0);
                    naive = naive.min((p - a - (b - a) * u - (c - a) * v).norm());
                }
            }
            let d = RoundTriangle::new([a, b, c], 0.0).distance(&p);
            prop_assert!(d <= naive + 1e-9 && naive - d < 0.12, "{d} {naive}");
        }

        #[test]
        fn smooth_union_only_adds(a in -1.0..1.0f64, b in -1.0..1.0f64) {
            let s = smooth_union(a, b, 0.3);
            prop_assert!(s <= a.min(b) && s >= a.min(b) - 0.3 * 0.25);
            prop_assert_eq!(smooth_union(a, a + 0.31, 0.3), a);
        }
    }
}
