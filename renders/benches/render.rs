//! One view of a built scene, and the building of a scene.

use criterion::{Criterion, criterion_group, criterion_main};
use grasp_renders::{Preset, RenderPlan, View};

fn render(c: &mut Criterion) {
    let plan = RenderPlan::preset(Preset::Paper);
    for spec in plan.scenes() {
        let scene = spec.build().expect("the built-in scenes build");
        let mut azimuth_deg = 0.0;
        c.bench_function(&format!("render {}", spec.grasp.name), |b| {
            b.iter(|| {
                azimuth_deg = (azimuth_deg + 37.0) % 360.0;
                scene.render(&View { azimuth_deg, elevation_deg: 40.0, roll_deg: 0.0 })
            });
        });
    }
    let spec = plan.scenes().swap_remove(0);
    c.bench_function("build a scene", |b| b.iter(|| spec.build()));
}

criterion_group!(benches, render);
criterion_main!(benches);
