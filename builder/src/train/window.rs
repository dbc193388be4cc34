//! The renders that a network is trained on just now: new ones come in as old ones leave.

use std::collections::VecDeque;
use std::ops::Range;

use anyhow::Context as _;
use grasp_renders::random::unit;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::check::Check;

/// The last parts of an endless list of renders.
#[derive(Debug)]
pub struct Window<R> {
    parts: VecDeque<Vec<R>>,
    capacity: usize,
}

impl<R> Window<R> {
    /// An empty window for `capacity` parts.
    pub fn new(capacity: usize) -> Self {
        Self { parts: VecDeque::new(), capacity }
    }

    /// Lets the next part in, and the oldest go where there is no more room.
    pub fn advance(&mut self, part: Vec<R>) {
        self.parts.push_back(part);
        if self.parts.len() > self.capacity {
            self.parts.pop_front();
        }
    }

    /// Any one of the renders; `None` of an empty window.
    pub fn pick(&self, rng: &mut ChaCha8Rng) -> Option<&R> {
        let count: usize = self.parts.iter().map(Vec::len).sum();
        let mut at = (unit(rng) * count as f64) as usize;
        for part in &self.parts {
            if let Some(render) = part.get(at) {
                return Some(render);
            }
            at -= part.len();
        }
        None
    }
}

/// Renders each of the numbered scenes by `render`, in a fixed order.
///
/// # Errors
/// Where a scene cannot be built, or `check` has stopped the work.
pub(super) fn render_all<R: Send>(
    numbers: Range<u64>,
    check: Check<'_>,
    render: impl Fn(u64) -> anyhow::Result<Vec<R>> + Sync,
) -> anyhow::Result<Vec<R>> {
    let of_scene = |number: u64| {
        check()?;
        render(number).with_context(|| format!("cannot render scene {number}"))
    };
    let renders: anyhow::Result<Vec<Vec<R>>> = numbers.into_par_iter().map(of_scene).collect();
    Ok(renders?.into_iter().flatten().collect())
}
