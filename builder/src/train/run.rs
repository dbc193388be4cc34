//! A training from its files to its files.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context as _, bail, ensure};
use grasp_index::{AtomicFile, WriteError};
use grasp_network::Network;
use grasp_terminal::Progress;

use super::check::Check;
use super::course::Course;
use super::hand::Hand;
use super::options::Kind;
use super::scene::Scene;
use super::training::Training;
use super::{Options, Row, Schedule, checkpoint, curve};
use crate::interrupt::Interrupted;

/// How much work is lost, at most, when the program is killed.
const CHECKPOINT_EVERY: Duration = Duration::from_secs(120);

/// What a training writes.
#[derive(Clone, Debug)]
pub struct Files {
    /// The network, when it is trained.
    pub network: PathBuf,
    /// How the training goes, renewed at every validation.
    pub curve: PathBuf,
    /// What a training that was stopped goes on from; removed when the network is written.
    pub checkpoint: PathBuf,
}

impl Files {
    /// Those beside a network's.
    pub fn beside(network: &Path) -> Self {
        let beside = |ending: &str| {
            let mut name = network.as_os_str().to_owned();
            name.push(ending);
            PathBuf::from(name)
        };
        Self { network: network.to_path_buf(), curve: beside(".csv"), checkpoint: beside(".checkpoint") }
    }
}

/// What came of a training.
#[derive(Debug)]
pub struct Trained {
    /// The network that was written.
    pub network: Network,
    /// How the training went.
    pub curve: Vec<Row>,
}

/// Trains a network, from the checkpoint where there is one, and writes it. It begins with the
/// weights of `start`, whose fingerprint is in the options, or with random ones.
///
/// # Errors
/// Where `start` is not the network that the options name or is of another kind, a file cannot be
/// read or written, another training is at work on the checkpoint or it is of one with other
/// options, a scene cannot be rendered, the training diverges, or `check` has stopped the work:
/// what was trained until then is in the checkpoint.
pub fn train(
    options: &Options,
    schedule: Schedule,
    start: Option<&Network>,
    files: &Files,
    progress: Progress,
    check: Check<'_>,
) -> anyhow::Result<Trained> {
    ensure!(
        options.start == start.map(Network::fingerprint),
        "the options name another network to begin with than the one that is given"
    );
    match options.kind {
        Kind::Hand => train_on::<Hand>(options, schedule, start, files, progress, check),
        Kind::Scene | Kind::Naming | Kind::Thing | Kind::Mask => {
            train_on::<Scene>(options, schedule, start, files, progress, check)
        }
    }
}

fn train_on<C: Course>(
    options: &Options,
    schedule: Schedule,
    start: Option<&Network>,
    files: &Files,
    progress: Progress,
    check: Check<'_>,
) -> anyhow::Result<Trained> {
    // From the beginning: nobody else trains the same network, and it can be written in the end.
    let mut out = AtomicFile::create(&files.network)?;
    let _claim = claim(&files.checkpoint)?;
    // What cannot be written is reported now, not after an hour.
    for path in [&files.curve, &files.checkpoint] {
        drop(AtomicFile::create(path)?);
    }
    let saved = checkpoint::read(&files.checkpoint, options)?;
    let mut training = Training::<C>::new(options, schedule, start, saved, check)?;
    if !training.is_done() {
        let scenes = C::validation_scenes(&schedule) + training.scenes_at_start();
        let work = progress.bar(scenes, "rendering", "scenes");
        let validation = training.course().validation(&schedule, None, check, &work)?;
        training.fill(check, &work)?;
        drop(work);
        finish(&mut training, options, &validation, files, progress, check)?;
    }
    let network = match start {
        Some(start) if options.keep_percent > 0 => {
            average(start, &training.network()?, options.keep_percent)?
        }
        _ => training.network()?,
    };
    // As it is computed wherever it is used: several times as fast.
    let network = network.in_integers();
    let rows = training.state().curve.clone();
    curve::write(&files.curve, &rows)?;
    let written = out.write_all(&network.to_bytes());
    written.with_context(|| format!("cannot write {}", files.network.display()))?;
    out.commit()?;
    if files.checkpoint.exists() {
        let removed = fs::remove_file(&files.checkpoint);
        removed.with_context(|| format!("cannot remove {}", files.checkpoint.display()))?;
    }
    Ok(Trained { network, curve: rows })
}

/// Keeps other trainings, of another network, from the same checkpoint until it is dropped: they
/// would overwrite each other's. The checkpoint is replaced again and again, so that no lock of its
/// own would last.
fn claim(checkpoint: &Path) -> anyhow::Result<AtomicFile> {
    let place = fs::canonicalize(checkpoint).unwrap_or_else(|_| checkpoint.to_path_buf());
    let mut name = place.into_os_string();
    name.push(".lock");
    match AtomicFile::create(Path::new(&name)) {
        Err(WriteError::Locked { .. }) => bail!(
            "another training keeps what it has done in {}: wait for it to end, or name another file with --checkpoint",
            checkpoint.display()
        ),
        other => Ok(other?),
    }
}

/// Interpolates weights: `percent` % of `start`'s, the rest of `trained`'s, which began with it:
/// what is new is learned, and less is forgotten of pictures unlike those (Wortsman et al., "Robust
/// fine-tuning of zero-shot models", CVPR 2022).
fn average(start: &Network, trained: &Network, percent: u8) -> anyhow::Result<Network> {
    let share = f32::from(percent) / 100.0;
    let weights = start.weights().into_iter().zip(trained.weights());
    let weights = weights.map(|(start, trained)| start + (1.0 - share) * (trained - start)).collect();
    Network::from_weights(start.architecture().clone(), weights).context("the networks have no average")
}

/// Does all rounds, and saves the state every now and then and when the work is stopped.
fn finish<C: Course>(
    training: &mut Training<C>,
    options: &Options,
    validation: &C::Validation,
    files: &Files,
    progress: Progress,
    check: Check<'_>,
) -> anyhow::Result<()> {
    let work = progress.bar(options.samples, "training", "samples");
    work.set_position(training.samples());
    let (mut saved, mut rows) = (Instant::now(), training.state().curve.len());
    while !training.is_done() {
        let done = training.advance(validation, check, &work);
        if done.as_ref().is_err_and(|error| !error.is::<Interrupted>()) {
            return done;
        }
        if training.state().curve.len() > rows {
            rows = training.state().curve.len();
            curve::write(&files.curve, &training.state().curve)?;
        }
        if done.is_err() || saved.elapsed() >= CHECKPOINT_EVERY {
            checkpoint::write(&files.checkpoint, options, training.state())?;
            saved = Instant::now();
        }
        done?;
    }
    Ok(())
}
