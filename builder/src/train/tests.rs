//! Trainings of a few steps: what they write follows from their options alone.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use grasp_network::Network;
use grasp_terminal::Progress;
use grasp_train::Trainer;
use tempfile::TempDir;

use super::{Course, Files, Kind, LeftOut, Optimiser, Options, Scene, Schedule, Trained, train};
use crate::interrupt::Interrupted;

const OPTIONS: Options = Options {
    kind: Kind::Hand,
    samples: 170,
    seed: 7,
    hold_out_poses: false,
    recorded_percent: 100,
    hands: None,
    validate_every: 80,
    start: None,
    optimiser: Optimiser::Muon,
    peak_rate: None,
    keep_percent: 0,
    left_out: Vec::new(),
};
/// Twenty-one steps in three rounds.
const SCHEDULE: Schedule = Schedule {
    batch: 8,
    scenes: 6,
    views: 4,
    parts_at_first: 1,
    window: 2,
    reuse: 3,
    mirrored: 8,
    validation: 6,
};

/// Trains on so many threads, until `checks` pieces of work were begun.
fn run(options: &Options, folder: &Path, threads: usize, checks: u64) -> anyhow::Result<Trained> {
    let done = AtomicU64::new(0);
    let check = || match done.fetch_add(1, Ordering::Relaxed) {
        count if count < checks => Ok(()),
        _ => Err(Interrupted),
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let start = options.start.map(|_| small_network());
    pool.install(|| train(options, SCHEDULE, start.as_ref(), &files(folder), Progress::hidden(), &check))
}

fn files(folder: &Path) -> Files {
    Files::beside(&folder.join("hand.network"))
}

/// The network and the curve that a folder holds, and nothing else.
fn written(folder: &Path) -> [Vec<u8>; 2] {
    assert_eq!(fs::read_dir(folder).unwrap().count(), 2);
    let files = files(folder);
    [files.network, files.curve].map(|path| fs::read(path).unwrap())
}

#[test]
fn threads_and_interruptions_change_no_byte() {
    // Scenes to measure by, the first part, the next one, and a few steps take so many pieces: each
    // try gets on, whichever of rendering and steps is the faster. The scene network's training is
    // stopped in the next test.
    for (kind, pieces) in [(Kind::Hand, 46), (Kind::Naming, 26), (Kind::Thing, 26), (Kind::Mask, 26)] {
        changes_no_byte(&Options { kind, ..OPTIONS }, pieces);
    }
}

/// A trained scene network, whatever it has learned.
fn small_network() -> Network {
    let architecture = Scene::new(&OPTIONS).architecture();
    let trainer = Trainer::new(&architecture, 0, 3).unwrap();
    Network::from_weights(architecture, trainer.weights()).unwrap()
}

#[test]
fn a_training_that_begins_with_a_network_is_the_same_again() {
    let start = Some(small_network().fingerprint());
    // Six more than without a network: those that the first part takes, which is rendered to begin.
    changes_no_byte(&Options { kind: Kind::Scene, start, ..OPTIONS }, 28);
}

#[test]
fn an_average_lies_between_what_was_begun_with_and_what_was_trained() {
    let start = small_network();
    let options = Options { kind: Kind::Scene, start: Some(start.fingerprint()), ..OPTIONS };
    let weights = |keep_percent| {
        let folder = tempfile::tempdir().unwrap();
        run(&Options { keep_percent, ..options.clone() }, folder.path(), 2, u64::MAX)
            .unwrap()
            .network
            .weights()
    };
    let (start, trained, average) = (start.weights(), weights(0), weights(25));
    assert_ne!(start, trained);
    for ((start, trained), average) in start.iter().zip(&trained).zip(&average) {
        let expected = 0.25 * start + 0.75 * trained;
        assert!((average - expected).abs() < 1e-3 * expected.abs().max(1.0), "{average} {expected}");
    }
}

#[test]
fn a_network_of_another_kind_is_nothing_to_begin_with() {
    let folder = tempfile::tempdir().unwrap();
    let options = Options { start: Some(small_network().fingerprint()), ..OPTIONS };
    let error = run(&options, folder.path(), 2, u64::MAX).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the network to begin with is of another shape than this kind's: give one that was trained with the same --kind"
    );
}

/// Stopped after every so many pieces of work, a training writes what it writes in one go.
fn changes_no_byte(options: &Options, pieces: u64) {
    let folders: [TempDir; 3] = std::array::from_fn(|_| tempfile::tempdir().unwrap());
    let [once, twice, stopped] = folders.each_ref().map(TempDir::path);
    let trained = run(options, once, 2, u64::MAX).unwrap();
    let samples: Vec<u64> = trained.curve.iter().map(|row| row.samples).collect();
    assert_eq!(samples, [80, 160, 168]);
    assert_eq!(trained.network.to_bytes(), written(once)[0]);
    run(options, twice, 1, u64::MAX).unwrap();
    assert!(written(once) == written(twice));

    let mut stops = 0;
    while let Err(error) = run(options, stopped, 2, pieces) {
        assert!(error.is::<Interrupted>(), "{error:#}");
        assert!(!files(stopped).network.exists());
        stops += 1;
        assert!(stops < 10, "the training goes on");
    }
    assert!(stops > 0);
    assert!(written(once) == written(stopped));
}

#[test]
fn another_trainings_checkpoint_is_refused_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    assert!(run(&OPTIONS, folder.path(), 2, 36).unwrap_err().is::<Interrupted>());
    let checkpoint = files(folder.path()).checkpoint;
    let bytes = fs::read(&checkpoint).unwrap();
    let other = Options {
        seed: 8,
        hold_out_poses: true,
        recorded_percent: 40,
        hands: Some(12),
        optimiser: Optimiser::Adam,
        peak_rate: Some(3e-4),
        left_out: vec![LeftOut::Skin, LeftOut::Ways],
        ..OPTIONS
    };
    let refused = |options: &Options| format!("{:#}", run(options, folder.path(), 2, 0).unwrap_err());
    let message = refused(&other);
    assert!(
        message.contains(
            "cannot go on from"
        ) && message.contains(
            "it is of a training with --samples 170 --seed 7 --validate-every 80, and not with --samples 170 --seed 8 \
             --validate-every 80 --hold-out-poses --recorded-poses 40 --hands 12 --optimiser adam --rate 0.0003 --without skin --without ways: give its options to go on with it, remove it to begin again, or name \
             another file with --checkpoint"
        ),
        "{message}"
    );
    assert_eq!(fs::read(&checkpoint).unwrap(), bytes);

    for at in [0, 40, bytes.len() / 2, bytes.len() - 1] {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1;
        fs::write(&checkpoint, damaged).unwrap();
        assert!(refused(&OPTIONS).contains("it is damaged, or no checkpoint of a training"));
    }
    fs::write(&checkpoint, "").unwrap();
    assert!(refused(&OPTIONS).contains("it is damaged, or no checkpoint of a training"));
}

#[test]
fn two_trainings_do_not_share_a_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let checkpoint = folder.path().join("shared");
    let train_another = || {
        let files =
            Files { checkpoint: checkpoint.clone(), ..Files::beside(&folder.path().join("other.network")) };
        train(&OPTIONS, SCHEDULE, None, &files, Progress::hidden(), &|| Err(Interrupted))
    };
    let refused = AtomicU64::new(0);
    // Begun in the midst of a training.
    let check = || match refused.fetch_add(1, Ordering::Relaxed) {
        0 => {
            let error = train_another().unwrap_err().to_string();
            assert!(error.starts_with("another training keeps what it has done in"), "{error}");
            Ok(())
        }
        _ => Err(Interrupted),
    };
    let files = Files { checkpoint: checkpoint.clone(), ..files(folder.path()) };
    let stopped = train(&OPTIONS, SCHEDULE, None, &files, Progress::hidden(), &check).unwrap_err();
    assert!(stopped.is::<Interrupted>());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "neither leaves anything");
    assert!(train_another().unwrap_err().is::<Interrupted>(), "the checkpoint is free again");
}

#[test]
fn a_folder_that_is_missing_is_reported_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let error = run(&OPTIONS, &folder.path().join("none"), 1, 0).unwrap_err();
    assert!(error.to_string().contains("there is no folder"), "{error:#}");
}
