//! Render sets: written once, kept, resumed, read back; and manifests made by others.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use grasp_renders::render_set::{Manifest, ManifestError, RenderSetError, Summary, write_set};
use grasp_renders::{GraspSet, HAND_FLOOR, HandShape, Look, Preset, RenderPlan, Stage, ViewGrid, Views};

fn small_plan() -> RenderPlan {
    RenderPlan {
        views: Views::Grid(ViewGrid {
            step_deg: 60.0,
            elevation_deg: [-30.0, 30.0],
            rolls_deg: vec![0.0, 90.0],
        }),
        look: Look { light_variation: 0.3, distance_variation: 0.2, ..Look::default() },
        ..RenderPlan::preset(Preset::Paper)
    }
}

fn write(folder: &Path, plan: &RenderPlan) -> Summary {
    write_set(folder, plan, &|_, _| {}, &AtomicBool::new(false)).expect("the set is written")
}

/// What the manifest in a folder says, of the built-in grasps.
fn read(folder: &Path) -> Result<Manifest, ManifestError> {
    let path = folder.join("manifest.csv");
    Manifest::parse(&fs::read(&path).expect("a manifest"), path, &GraspSet::builtin())
}

/// Every file below a folder with its bytes, sorted by path.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let inside = path.strip_prefix(folder).expect("inside").to_owned();
                found.push((inside, fs::read(&path).expect("a file")));
            }
        }
    }
    found.sort();
    found
}

#[test]
fn two_thread_counts_give_the_same_bytes() {
    let set = |threads: usize| {
        let folder = tempfile::tempdir().expect("a folder");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| write(folder.path(), &small_plan()));
        files(folder.path())
    };
    let one = set(1);
    assert_eq!(one.len(), small_plan().renders() + 1);
    assert!(one == set(3));
}

#[test]
fn scenes_that_a_name_cannot_distinguish_have_files_of_their_own() {
    // The same hand twice: each pair of scenes has one name.
    let plan = RenderPlan {
        hand_shapes: vec![HandShape::preset("mean").unwrap(), HandShape::preset("mean").unwrap()],
        stages: vec![Stage::Grasp],
        ..small_plan()
    };
    let folder = tempfile::tempdir().expect("a folder");
    let summary = write(folder.path(), &plan);
    assert_eq!(files(folder.path()).len(), plan.renders() + 1);
    let set = read(folder.path()).expect("it is read");
    let names: std::collections::HashSet<_> = set.rows.iter().map(|row| &row.file).collect();
    assert_eq!((names.len(), summary.rendered), (plan.renders(), plan.renders()));
    assert_eq!(write(folder.path(), &plan), Summary { rendered: 0, kept: plan.renders(), ..summary });
}

#[test]
fn a_set_of_another_program_is_left_as_it_is() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("manifest.csv"), "grasp,file\npinch,a.png\n").expect("written");
    fs::write(folder.path().join("a.png"), "no picture of ours").expect("written");
    let before = files(folder.path());
    let error = write_set(folder.path(), &small_plan(), &|_, _| {}, &AtomicBool::new(false)).unwrap_err();
    assert!(matches!(error, RenderSetError::Foreign { .. }), "{error}");
    assert_eq!(files(folder.path()), before);
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 2, "no folder was made");
}

#[test]
fn what_is_listed_besides_is_counted_and_no_picture_of_others_is_unlisted() {
    let folder = tempfile::tempdir().expect("a folder");
    let plan = small_plan();
    write(folder.path(), &plan);
    let Views::Grid(grid) = plan.views.clone() else { unreachable!("a grid") };
    let fewer = RenderPlan { views: Views::Grid(ViewGrid { rolls_deg: vec![0.0], ..grid }), ..plan.clone() };
    let unlisted = plan.renders() - fewer.renders();
    assert!(unlisted > 0);
    assert_eq!(write(folder.path(), &fewer).unlisted, unlisted);
    assert_eq!(write(folder.path(), &plan).unlisted, 0);

    let manifest = folder.path().join("manifest.csv");
    let listed = fs::read_to_string(&manifest).expect("a manifest");
    let last = listed.lines().last().expect("a line");
    let file = last.split(',').next().expect("a file");
    fs::write(&manifest, format!("{listed}{}\n", last.replace(file, "mine.png"))).expect("written");
    fs::write(folder.path().join("mine.png"), "somebody's").expect("written");
    let before = files(folder.path());
    let error = write_set(folder.path(), &plan, &|_, _| {}, &AtomicBool::new(false)).unwrap_err();
    assert!(matches!(error, RenderSetError::Foreign { .. }), "{error}");
    assert_eq!(files(folder.path()), before);
}

#[cfg(unix)]
#[test]
fn two_runs_do_not_mix_in_one_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    let plan = small_plan();
    let other_run = AtomicBool::new(false);
    // Asked for in the midst of a run.
    let second = |_, _| {
        if !other_run.swap(true, Ordering::Relaxed) {
            let error = write_set(folder.path(), &plan, &|_, _| {}, &AtomicBool::new(false)).unwrap_err();
            assert!(matches!(error, RenderSetError::Locked { .. }), "{error}");
        }
    };
    write_set(folder.path(), &plan, &second, &AtomicBool::new(false)).expect("the first is not disturbed");
    assert!(other_run.into_inner());
    assert_eq!(write(folder.path(), &plan).kept, plan.renders());
}

#[test]
fn no_manifest_speaks_of_pictures_that_were_replaced() {
    let folder = tempfile::tempdir().expect("a folder");
    let plan = small_plan();
    write(folder.path(), &plan);
    let other = RenderPlan { seed: 9, ..plan.clone() };
    let cancel = AtomicBool::new(false);
    let stop = |_, _| cancel.store(true, Ordering::Relaxed);
    write_set(folder.path(), &other, &stop, &cancel).expect_err("cancelled");
    assert!(!folder.path().join("manifest.csv").exists());
    // What is there is kept as it is listed where nothing was replaced.
    write(folder.path(), &plan);
    write_set(folder.path(), &plan, &|_, _| {}, &AtomicBool::new(true)).expect_err("cancelled");
    assert!(folder.path().join("manifest.csv").exists());
}

#[test]
fn what_was_written_is_read_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let plan = small_plan();
    write(folder.path(), &plan);
    let manifest = read(folder.path()).expect("the manifest is read");
    assert_eq!(manifest.rows.len(), plan.renders());
    let views = plan.views(&plan.scenes()[0]);
    for (s, spec) in plan.scenes().iter().enumerate() {
        let scene = spec.build().expect("a scene");
        let row = &manifest.rows[s * views.len() + 7];
        let render = scene.render(&views[7]);
        assert_eq!(row.grasp, spec.grasp.name);
        assert_eq!(row.view, render.view);
        assert!(row.camera_from_hand.angle_to(&render.camera_from_hand) < 1e-9);
        let file = fs::File::open(manifest.folder.join(&row.file)).expect("the picture");
        let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("a PNG");
        let mut pixels = vec![0; reader.output_buffer_size().expect("small")];
        reader.next_frame(&mut pixels).expect("whole");
        assert_eq!(pixels, render.grey);
        assert!(pixels.iter().all(|&g| g == 0 || g >= HAND_FLOOR));
    }
}

#[test]
fn whole_renders_are_kept_and_broken_or_other_ones_made_anew() {
    let folder = tempfile::tempdir().expect("a folder");
    let plan = small_plan();
    let total = plan.renders();
    assert_eq!(write(folder.path(), &plan).rendered, total);
    let before = files(folder.path());
    assert_eq!(write(folder.path(), &plan).kept, total);

    // One lost, one cut short, one of another plan in its place.
    let pictures: Vec<PathBuf> = before.iter().map(|(p, _)| folder.path().join(p)).collect();
    let pictures: Vec<&PathBuf> =
        pictures.iter().filter(|p| p.extension().is_some_and(|e| e == "png")).collect();
    fs::remove_file(pictures[0]).expect("removed");
    let bytes = fs::read(pictures[1]).expect("read");
    fs::write(pictures[1], &bytes[..bytes.len() - 5]).expect("cut");
    fs::copy(pictures[3], pictures[2]).expect("copied");
    let again = write(folder.path(), &plan);
    assert_eq!((again.rendered, again.kept), (3, total - 3));
    assert!(before == files(folder.path()));

    let other = RenderPlan { seed: 9, ..plan };
    assert_eq!(write(folder.path(), &other).rendered, total);
}

#[test]
fn a_cancelled_run_leaves_no_manifest_and_goes_on_later() {
    let folder = tempfile::tempdir().expect("a folder");
    let plan = small_plan();
    let cancel = AtomicBool::new(false);
    let seen = AtomicUsize::new(0);
    let progress = |done: usize, _total: usize| {
        seen.fetch_max(done, Ordering::Relaxed);
        if done >= 20 {
            cancel.store(true, Ordering::Relaxed);
        }
    };
    let error = write_set(folder.path(), &plan, &progress, &cancel).expect_err("cancelled");
    let RenderSetError::Cancelled { done, total } = error else {
        panic!("{error}");
    };
    assert!((20..total).contains(&done));
    let written = files(folder.path());
    assert!(written.iter().all(|(p, _)| p.extension().is_some_and(|e| e == "png")), "no manifest, no part");
    let rest = write(folder.path(), &plan);
    assert_eq!(rest.kept, written.len());
    assert_eq!(rest.kept + rest.rendered, total);
}

/// A folder with one picture and a manifest of these lines.
fn foreign(lines: &str) -> (tempfile::TempDir, Result<Manifest, String>) {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("a.png"), b"not looked at").expect("written");
    fs::write(folder.path().join("manifest.csv"), lines).expect("written");
    let read = read(folder.path()).map_err(|e| {
        let path = folder.path().display().to_string();
        e.to_string().replace(&path, "SET")
    });
    (folder, read)
}

#[test]
fn a_short_manifest_of_another_program_is_enough() {
    let (_folder, read) = foreign("qw,qx,qy,qz,camera,grasp,file\n1,0,0,0,blender,pinch,a.png\n");
    let manifest = read.expect("it is enough");
    let row = &manifest.rows[0];
    assert_eq!((row.cutkosky, row.hand_shape.as_str(), row.seed), (9, "unknown", 0));
    assert_eq!(row.stage, grasp_renders::Stage::Grasp);
    assert_eq!(row.camera_from_hand.w, 1.0);
}

#[test]
fn mistakes_in_a_manifest_are_told_with_their_line() {
    let fault = |lines: &str| foreign(lines).1.expect_err("wrong");
    let line = |row: &str| {
        fault(&format!("file,grasp,cutkosky,stage,qx,qy,qz,qw\na.png,pinch,9,grasp,0,0,0,1\n{row}\n"))
    };
    insta::assert_snapshot!(fault("file,grasp,qx,qy,qz\n"), @"SET/manifest.csv: line 1: column `qw` is missing: file, grasp, qx, qy, qz and qw are needed");
    insta::assert_snapshot!(fault("file,grasp,qx,qy,qz,qw\n"), @"SET/manifest.csv: the manifest lists no render");
    insta::assert_snapshot!(line("a.png,pinch,9,grasp,0,0,zero,1"), @"SET/manifest.csv: line 3: `zero` in column `qz` is not a number in the range of that column");
    insta::assert_snapshot!(line("a.png,pinch,9,grasp,0,0,,1"), @"SET/manifest.csv: line 3: `` in column `qz` is not a number in the range of that column");
    insta::assert_snapshot!(line("a.png,pinch,9,grasp,0,0,0,2"), @"SET/manifest.csv: line 3: qx, qy, qz, qw have length 2.0000: camera_from_hand must be a unit quaternion");
    insta::assert_snapshot!(line("a.png,pinch,9,grasp,0,0,NaN,1"), @"SET/manifest.csv: line 3: qx, qy, qz, qw have length NaN: camera_from_hand must be a unit quaternion");
    insta::assert_snapshot!(line("../a.png,pinch,9,grasp,0,0,0,1"), @"SET/manifest.csv: line 3: the file `../a.png` leads out of the manifest's folder");
    insta::assert_snapshot!(line("/a.png,pinch,9,grasp,0,0,0,1"), @"SET/manifest.csv: line 3: the file `/a.png` leads out of the manifest's folder");
    insta::assert_snapshot!(line("b.png,pinch,9,grasp,0,0,0,1"), @"SET/manifest.csv: line 3: the file `b.png` does not exist");
    insta::assert_snapshot!(line("a.png,pnich,9,grasp,0,0,0,1"), @"SET/manifest.csv: line 3: there is no grasp `pnich`: the grasps are large-diameter, small-diameter, abducted-thumb, pinch, power-sphere, precision-disc");
    insta::assert_snapshot!(line("a.png,pinch,8,grasp,0,0,0,1"), @"SET/manifest.csv: line 3: grasp `pinch` is number 9, not 8");
    insta::assert_snapshot!(line("a.png,pinch,9,hold,0,0,0,1"), @"SET/manifest.csv: line 3: there is no stage `hold`: the stages are reach, close and grasp");
    insta::assert_snapshot!(line("a.png,pinch"), @"SET/manifest.csv: line 3: not a line of this table: it has 2 fields where the header has 8");
    insta::assert_snapshot!(line("./a.png,pinch,9,grasp,0,0,0,1"), @"SET/manifest.csv: line 3: the file `./a.png` is listed twice");
}
