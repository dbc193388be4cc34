//! Random small masks and grids for the property tests.

use proptest::collection::vec;
use proptest::prelude::*;

/// A grid of 1..=`side` by 1..=`side` values.
pub(crate) fn grids<S: Strategy + Clone>(
    value: S,
    side: usize,
) -> impl Strategy<Value = (usize, usize, Vec<S::Value>)>
where
    S::Value: Clone,
{
    (1..=side, 1..=side).prop_flat_map(move |(width, height)| {
        vec(value.clone(), width * height).prop_map(move |values| (width, height, values))
    })
}

/// A mask as width, height and pixels.
pub(crate) fn masks() -> impl Strategy<Value = (usize, usize, Vec<bool>)> {
    grids(any::<bool>(), 12)
}
