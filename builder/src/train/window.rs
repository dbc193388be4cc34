//! The renders that a network is trained on just now: new ones come in as old ones leave.

use std::collections::VecDeque;
use std::ops::Range;

use anyhow::Context as _;
use grasp_renders::View;
use grasp_renders::random::unit;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::check::Check;
use super::{Sample, Scenes};

/// The last parts of an endless list of renders.
#[derive(Debug)]
pub struct Window {
    parts: VecDeque<Vec<Sample>>,
    capacity: usize,
}

impl Window {
    /// An empty window for `capacity` parts.
    pub fn new(capacity: usize) -> Self {
        Self { parts: VecDeque::new(), capacity }
    }

    /// Lets the next part in, and the oldest go where there is no more room.
    pub fn advance(&mut self, part: Vec<Sample>) {
        self.parts.push_back(part);
        if self.parts.len() > self.capacity {
            self.parts.pop_front();
        }
    }

    /// Any one of the renders; `None` of an empty window.
    pub fn pick(&self, rng: &mut ChaCha8Rng) -> Option<&Sample> {
        let count: usize = self.parts.iter().map(Vec::len).sum();
        let mut at = (unit(rng) * count as f64) as usize;
        for part in &self.parts {
            if let Some(sample) = part.get(at) {
                return Some(sample);
            }
            at -= part.len();
        }
        None
    }
}

/// Renders `views` random views of each of the numbered scenes, in a fixed order.
///
/// # Errors
/// Where a scene cannot be built, or `check` has stopped the work.
pub fn render(
    scenes: &Scenes,
    numbers: Range<u64>,
    views: usize,
    check: Check<'_>,
) -> anyhow::Result<Vec<Sample>> {
    let of_scene = |number: u64| {
        check()?;
        let (spec, class) = scenes.scene(number);
        let scene = spec.build().with_context(|| format!("cannot render scene {number}"))?;
        // Another stream than the variations of light and distance.
        let mut rng = ChaCha8Rng::seed_from_u64(spec.params_hash());
        rng.set_stream(1);
        let views = (0..views).map(|_| View::random(&mut rng));
        Ok(views.map(|view| Sample::new(scene.render(&view), class, spec.stage)).collect())
    };
    let renders: anyhow::Result<Vec<Vec<Sample>>> = numbers.into_par_iter().map(of_scene).collect();
    Ok(renders?.into_iter().flatten().collect())
}
