//! What is rendered once and shown several times.

use std::sync::Arc;

use grasp_renders::View;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::sample::Sample;
use crate::train::joints::Joints;
use crate::train::{DrawnScene, Scenes};

/// Random views of a numbered scene.
pub(super) fn render(scenes: &Scenes, number: u64, views: usize) -> anyhow::Result<Vec<Sample>> {
    let DrawnScene { spec, class, .. } = scenes.scene(number);
    let scene = spec.build()?;
    // Another stream than the variations of light and distance.
    let mut rng = ChaCha8Rng::seed_from_u64(spec.params_hash());
    rng.set_stream(1);
    let views = (0..views).map(|_| View::random(&mut rng));
    let joints = Arc::new(Joints::new(scene.joints(), scene.hand_length()));
    Ok(views.map(|view| Sample::new(scene.render(&view), class, spec.stage, Arc::clone(&joints))).collect())
}
