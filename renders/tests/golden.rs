//! Golden values of pixels: whoever changes the renderer's pictures raises its version.

use grasp_renders::{Preset, RENDERER_VERSION, RenderPlan};
use xxhash_rust::xxh3::xxh3_64;

/// One picture of each preset: a hand that closes on an object, and one with drawn pose, arm, light
/// and distance.
#[test]
fn pixels_are_pinned_to_the_version_of_the_renderer() {
    let pictures = [Preset::Paper, Preset::Standard].map(|preset| {
        let plan = RenderPlan::preset(preset);
        let scenes = plan.scenes();
        [0, scenes.len() / 2].map(|at| {
            let scene = scenes[at].build().expect("a scene");
            let render = scene.render(&plan.views(&scenes[at])[7]);
            format!("{:016x}", xxh3_64(&render.grey))
        })
    });
    let pinned = (4, [["f34052073dbb34dd", "aed23aeda42c2d13"], ["2447cce1e3e3c298", "d63360928ae47ab9"]]);
    assert_eq!(
        (RENDERER_VERSION, pictures.each_ref().map(|hashes| hashes.each_ref().map(String::as_str))),
        pinned,
        "the same parameters give other pixels: raise RENDERER_VERSION in renders/src/scene.rs, so \
         that no picture of before is taken for one of now, and pin these"
    );
}
