//! Signed distances of simple bodies (after I. Quilez, "Distance functions"): negative inside.

use nalgebra::Vector3;

type V = Vector3<f64>;

/// A sphere of radius `ra` at `a` and one of radius `rb` at `b` in a common tight skin.
pub(crate) fn round_cone(p: &V, a: &V, b: &V, ra: f64, rb: f64) -> f64 {
    let ba = b - a;
    let l2 = ba.norm_squared();
    let rr = ra - rb;
    let a2 = l2 - rr * rr;
    if a2 <= 0.0 {
        // One sphere swallows the other.
        return ((p - a).norm() - ra).min((p - b).norm() - rb);
    }
    let il2 = 1.0 / l2;
    let pa = p - a;
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

/// The triangle `a b c` fattened by `radius`.
pub(crate) fn round_triangle(p: &V, a: &V, b: &V, c: &V, radius: f64) -> f64 {
    let normal = (b - a).cross(&(a - c));
    let inside = [(a, b), (b, c), (c, a)].iter().all(|(u, v)| (*v - *u).cross(&normal).dot(&(p - *u)) >= 0.0);
    let distance = if inside {
        (normal.dot(&(p - a)) / normal.norm()).abs()
    } else {
        [(a, b), (b, c), (c, a)]
            .iter()
            .map(|(u, v)| {
                let e = *v - *u;
                let t = ((p - *u).dot(&e) / e.norm_squared()).clamp(0.0, 1.0);
                (p - *u - e * t).norm()
            })
            .fold(f64::INFINITY, f64::min)
    };
    distance - radius
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
            prop_assert!((round_cone(&p, &a, &b, ra, rb) - naive).abs() < 2e-3);
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
            let d = round_triangle(&p, &a, &b, &c, 0.0);
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
