//! The Euclidean distance between descriptors.

/// The largest magnitude of a value of a descriptor or a query: the squared distance of two of such
/// values is finite by far.
pub(crate) const LARGEST_VALUE: f32 = 1e15;

/// Partial sums kept apart: enough for the widest vector registers, and a fixed order of summation
/// on every machine.
const LANES: usize = 16;

/// The squared distance between two vectors of equal length (of unequal ones, over the shorter).
/// The order of summation is fixed, so that every machine and every caller gets the same bits.
#[inline(always)]
pub(crate) fn squared(a: &[f32], b: &[f32]) -> f32 {
    accumulate(a, b, |x, y| (x - y) * (x - y))
}

/// The dot product of two vectors of equal length (of unequal ones, over the shorter), summed as
/// [`squared`] does.
#[inline]
pub(crate) fn dot(a: &[f32], b: &[f32]) -> f32 {
    accumulate(a, b, |x, y| x * y)
}

/// Both, as far as the shorter goes.
#[inline(always)]
pub(crate) fn alike<'v>(a: &'v [f32], b: &'v [f32]) -> (&'v [f32], &'v [f32]) {
    let length = a.len().min(b.len());
    (&a[..length], &b[..length])
}

#[inline(always)]
fn accumulate(a: &[f32], b: &[f32], term: impl Fn(f32, f32) -> f32) -> f32 {
    let (a, b) = alike(a, b);
    let ((whole_a, rest_a), (whole_b, rest_b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut lanes = [0.0f32; LANES];
    for (x, y) in whole_a.iter().zip(whole_b) {
        for lane in 0..LANES {
            lanes[lane] += term(x[lane], y[lane]);
        }
    }
    let ((fours_a, rest_a), (fours_b, rest_b)) = (rest_a.as_chunks::<4>(), rest_b.as_chunks::<4>());
    let mut four = [0.0f32; 4];
    for (x, y) in fours_a.iter().zip(fours_b) {
        for lane in 0..4 {
            four[lane] += term(x[lane], y[lane]);
        }
    }
    let tail: f32 = rest_a.iter().zip(rest_b).map(|(&x, &y)| term(x, y)).sum();
    let eight: [f32; 8] = std::array::from_fn(|lane| lanes[lane] + lanes[lane + 8]);
    let four: [f32; 4] = std::array::from_fn(|lane| (eight[lane] + eight[lane + 4]) + four[lane]);
    ((four[0] + four[2]) + (four[1] + four[3])) + tail
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn agrees_with_the_definition(pairs in prop::collection::vec((-2.0..2.0f32, -2.0..2.0f32), 0..200)) {
            let (a, b): (Vec<f32>, Vec<f32>) = pairs.iter().copied().unzip();
            let exact: f64 = pairs.iter().map(|(x, y)| f64::from(x - y).powi(2)).sum();
            prop_assert!((f64::from(squared(&a, &b)) - exact).abs() <= 1e-5 * (1.0 + exact));
            let product: f64 = pairs.iter().map(|(x, y)| f64::from(*x) * f64::from(*y)).sum();
            prop_assert!((f64::from(dot(&a, &b)) - product).abs() <= 1e-4 * (1.0 + product.abs()));
        }
    }
}
