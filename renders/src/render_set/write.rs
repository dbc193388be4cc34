//! Writing a render set: in parallel, resumable, the manifest last.

use std::collections::HashSet;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::manifest::{self, MANIFEST, ManifestRow};
use super::picture;
use crate::plan::RenderPlan;
use crate::scene::{SceneError, SceneSpec};
use crate::view::{View, world_from_hand};

/// Why a render set was not written.
#[derive(Debug, thiserror::Error)]
pub enum RenderSetError {
    /// The caller asked to stop. What was written is whole and is kept when writing is started
    /// again.
    #[error("stopped after {done} of {total} renders; run it again to go on from there")]
    Cancelled {
        /// Renders that are whole.
        done: usize,
        /// Renders of the plan.
        total: usize,
    },
    /// The plan has no scene or no view.
    #[error("the plan renders nothing: it needs a hand shape, a stage, an object size and a view")]
    Empty,
    /// No folder holds so many files.
    #[error(
        "the plan has {total} renders: at most {MOST} are written as files (`build` indexes more of them without)"
    )]
    TooMany {
        /// Renders of the plan.
        total: usize,
    },
    /// A file or folder could not be written.
    #[error("cannot write {path}")]
    Write {
        /// What.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Another run is writing into the folder.
    #[error("another program is writing renders into {path}: wait for it to end, or choose another folder")]
    Locked {
        /// The folder.
        path: PathBuf,
    },
    /// The folder holds a render set that another program made.
    #[error("{path} lists pictures that another program made: choose another folder")]
    Foreign {
        /// The manifest.
        path: PathBuf,
    },
    /// A scene could not be built.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// What writing a render set came to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Summary {
    /// The manifest.
    pub manifest: PathBuf,
    /// Renders made now.
    pub rendered: usize,
    /// Renders that were there already, made of the same parameters.
    pub kept: usize,
    /// Renders that an earlier manifest listed and this one does not. They stay in the folder.
    pub unlisted: usize,
}

/// The most renders of a set.
const MOST: usize = 20_000_000;

/// The path of a render inside its set:
/// `HAND/GRASP/STAGE_OBJECT_azAAA_elEE_rRRR.png`, angles in degrees, where no other render of the
/// set has that name.
pub fn render_file(scene: &SceneSpec, view: &View) -> String {
    // Fractions appear only where a step has them; a negative elevation keeps its sign.
    let angle = |degrees: f64, digits: usize| {
        let text = format!("{:.3}", degrees.abs());
        let text = text.trim_end_matches('0').trim_end_matches('.');
        let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
        let sign = if degrees < 0.0 { "-" } else { "" };
        let dot = if fraction.is_empty() { "" } else { "." };
        format!("{sign}{whole:0>digits$}{dot}{fraction}")
    };
    format!(
        "{}/{}/{}_{}_az{}_el{}_r{}.png",
        scene.hand_shape.name,
        scene.grasp.name,
        scene.stage,
        scene.object.name(),
        angle(view.azimuth_deg, 3),
        angle(view.elevation_deg, 2),
        angle(view.roll_deg, 3),
    )
}

/// The paths of all renders, scene by scene. Two scenes may differ by less than a name says: the
/// later one's renders are then numbered, from 2.
fn files(scenes: &[SceneSpec], plan: &RenderPlan) -> Vec<Vec<String>> {
    let mut taken = HashSet::new();
    let mut free = |file: String| {
        let numbered = |number: usize| format!("{}_{number}.png", file.trim_end_matches(".png"));
        let name = match taken.contains(&file) {
            true => (2..).map(numbered).find(|name| !taken.contains(name)).unwrap_or(file),
            false => file,
        };
        taken.insert(name.clone());
        name
    };
    let of_scene = |spec: &SceneSpec| plan.views(spec).iter().map(|view| render_file(spec, view)).collect();
    let named: Vec<Vec<String>> = scenes.par_iter().map(of_scene).collect();
    named.into_iter().map(|files| files.into_iter().map(&mut free).collect()).collect()
}

/// Writes all renders of a plan into a folder, which is made if need be, and the manifest last.
///
/// Renders that are there already and were made of the same parameters (each PNG file carries them)
/// are kept. Every file appears whole or not at all; the manifest lists the plan's renders only.
/// Before a picture is replaced by one of other parameters, the manifest that was there is removed:
/// what it says of that picture may no longer be so. `progress` is called from any thread with the
/// renders done and the plan's total. The same plan and seed give the same bytes at any thread
/// count.
///
/// # Errors
///
/// When a file cannot be written, when another run is writing into the folder, when the plan is
/// empty, and [`RenderSetError::Cancelled`] soon after `cancel` becomes true.
pub fn write_set(
    folder: &Path,
    plan: &RenderPlan,
    progress: &(dyn Fn(usize, usize) + Sync),
    cancel: &AtomicBool,
) -> Result<Summary, RenderSetError> {
    let total = plan.renders();
    if total == 0 {
        return Err(RenderSetError::Empty);
    }
    if total > MOST {
        return Err(RenderSetError::TooMany { total });
    }
    fs::create_dir_all(folder).map_err(|source| RenderSetError::Write { path: folder.to_owned(), source })?;
    let _lock = Lock::of(folder)?;
    let scenes = plan.scenes();
    let files = files(&scenes, plan);
    let manifest = folder.join(MANIFEST);
    let unlisted = unlisted(folder, &manifest, &files)?;
    for scene in &scenes {
        let path = folder.join(&scene.hand_shape.name).join(&scene.grasp.name);
        fs::create_dir_all(&path).map_err(|source| RenderSetError::Write { path, source })?;
    }
    let counts = Counts::default();
    let outdated = Mutex::new(Some(manifest.as_path()));
    let job = Job { folder, outdated, plan, total, counts: &counts, progress, cancel };
    scenes.par_iter().zip(&files).try_for_each(|(spec, files)| job.write_scene(spec, files))?;

    let rows = scenes.iter().zip(files).flat_map(|(spec, files)| {
        plan.views(spec).into_iter().zip(files).map(move |(view, file)| row(spec, &view, file))
    });
    let failed = |source| RenderSetError::Write { path: manifest.clone(), source };
    let bytes = manifest::to_csv(rows).map_err(failed)?;
    picture::write_durably(&manifest, &bytes).map_err(failed)?;
    let kept = counts.kept.into_inner();
    Ok(Summary { rendered: counts.done.into_inner() - kept, kept, unlisted, manifest })
}

/// Keeps other runs out of a folder until it is dropped: two in one folder would leave a manifest
/// that does not match the pictures.
struct Lock(File);

impl Lock {
    /// Locks a folder. Where a system opens or locks none, nothing keeps others out.
    fn of(folder: &Path) -> Result<Option<Self>, RenderSetError> {
        let Ok(handle) = File::open(folder) else { return Ok(None) };
        match handle.try_lock() {
            Err(TryLockError::WouldBlock) => Err(RenderSetError::Locked { path: folder.to_owned() }),
            Err(TryLockError::Error(_)) => Ok(None),
            Ok(()) => Ok(Some(Self(handle))),
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Not by closing alone: a child process that is just being started has the handle as well.
        let _ = self.0.unlock();
    }
}

/// How many renders the manifest in the folder lists that are not among the plan's files.
///
/// # Errors
/// [`RenderSetError::Foreign`] where it lists a picture that another program made: that is
/// somebody's work, and is not replaced.
fn unlisted(folder: &Path, manifest: &Path, files: &[Vec<String>]) -> Result<usize, RenderSetError> {
    let Ok(file) = File::open(manifest) else {
        return Ok(0);
    };
    let mut reader = csv::Reader::from_reader(file);
    // Other programs' columns may come in any order.
    let column = reader.headers().ok().and_then(|names| names.iter().position(|name| name.trim() == "file"));
    let Some(column) = column else { return Ok(0) };
    let listed = reader.records().filter_map(|row| Some(row.ok()?.get(column)?.to_owned()));
    // Where a picture is gone there is nothing to tell by; a set that lost pictures is to be
    // completed.
    let has_picture = |file: &String| fs::metadata(folder.join(file)).is_ok_and(|data| data.len() > 0);
    let listed: Vec<String> = listed.filter(has_picture).collect();
    let planned: HashSet<&String> = files.iter().flatten().collect();
    let others: Vec<&String> = listed.iter().filter(|file| !planned.contains(file)).collect();
    // A picture of a planned name may be damaged; the first one speaks for all of these.
    let is_ours = |file: &&String| picture::is_ours(&folder.join(file));
    if !listed.iter().take(1).all(|file| is_ours(&file)) || !others.par_iter().all(is_ours) {
        return Err(RenderSetError::Foreign { path: manifest.to_owned() });
    }
    Ok(others.len())
}

#[derive(Default)]
struct Counts {
    done: AtomicUsize,
    kept: AtomicUsize,
}

struct Job<'a> {
    folder: &'a Path,
    /// The manifest that was there before, until a picture is replaced.
    outdated: Mutex<Option<&'a Path>>,
    plan: &'a RenderPlan,
    total: usize,
    counts: &'a Counts,
    progress: &'a (dyn Fn(usize, usize) + Sync),
    cancel: &'a AtomicBool,
}

impl Job<'_> {
    fn write_scene(&self, spec: &SceneSpec, files: &[String]) -> Result<(), RenderSetError> {
        let hash = spec.params_hash();
        self.check_cancelled()?;
        // Only a scene that lacks a picture is worth building.
        let views = self.plan.views(spec);
        let missing: Vec<(&View, &String)> = views
            .par_iter()
            .zip(files)
            .filter(|(view, file)| {
                // Once stopped, nothing more is looked at; what that leaves out is not rendered
                // either.
                if self.cancel.load(Ordering::Relaxed) {
                    return true;
                }
                let path = self.folder.join(file);
                let current = picture::is_current(&path, &picture::stamp(hash, view));
                if current {
                    self.counts.kept.fetch_add(1, Ordering::Relaxed);
                    self.count();
                }
                !current
            })
            .collect();
        if missing.is_empty() {
            return Ok(());
        }
        let scene = spec.build()?;
        missing.into_par_iter().try_for_each(|(view, file)| {
            self.check_cancelled()?;
            let path = self.folder.join(file);
            picture::encode(&scene.render(view), &picture::stamp(hash, view))
                .and_then(|bytes| {
                    if path.exists() {
                        self.remove_manifest()?;
                    }
                    picture::write_whole(&path, &bytes)
                })
                .map_err(|source| RenderSetError::Write { path, source })?;
            self.count();
            Ok(())
        })
    }

    /// Removes the manifest that was there before, once.
    fn remove_manifest(&self) -> io::Result<()> {
        let mut outdated = self.outdated.lock().unwrap_or_else(PoisonError::into_inner);
        match outdated.take().map(fs::remove_file) {
            Some(Err(error)) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }

    fn check_cancelled(&self) -> Result<(), RenderSetError> {
        if self.cancel.load(Ordering::Relaxed) {
            let done = self.counts.done.load(Ordering::Relaxed);
            return Err(RenderSetError::Cancelled { done, total: self.total });
        }
        Ok(())
    }

    fn count(&self) {
        let done = self.counts.done.fetch_add(1, Ordering::Relaxed) + 1;
        (self.progress)(done, self.total);
    }
}

fn row(spec: &SceneSpec, view: &View, file: String) -> ManifestRow {
    ManifestRow {
        file,
        hand_shape: spec.hand_shape.name.clone(),
        grasp: spec.grasp.name.clone(),
        cutkosky: spec.grasp.cutkosky,
        stage: spec.stage,
        view: *view,
        camera_from_hand: view.camera_from_world() * world_from_hand(&spec.grasp.up),
        object: spec.object.name(),
        seed: spec.seed,
    }
}
