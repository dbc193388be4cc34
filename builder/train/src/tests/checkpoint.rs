//! Checkpoints: what is loaded goes on as what was saved, and nothing else is loaded.

use super::{batch, masked_batch, masked_trainer, trainer};
use crate::{CheckpointError, Optimiser, Trainer};
use xxhash_rust::xxh3::xxh3_64;

/// A training of a few steps, and it saved.
fn saved() -> (Trainer, Vec<u8>) {
    let mut trainer = trainer(6);
    for step in 0..4 {
        trainer.step(&batch(20, step), 1e-2).expect("a valid batch");
    }
    let bytes = trainer.save();
    (trainer, bytes)
}

/// The same with masks.
fn masked_saved() -> (Trainer, Vec<u8>) {
    let mut trainer = masked_trainer(6);
    for step in 0..4 {
        trainer.step(&masked_batch(20, step), 1e-2).expect("a valid batch");
    }
    let bytes = trainer.save();
    (trainer, bytes)
}

fn error(bytes: &[u8]) -> CheckpointError {
    Trainer::load(bytes).err().expect("a bad checkpoint")
}

/// The bytes with a change and the checksum that belongs to it.
fn changed(bytes: &[u8], at: usize, value: &[u8]) -> Vec<u8> {
    let mut bytes = bytes[..bytes.len() - 8].to_vec();
    bytes[at..at + value.len()].copy_from_slice(value);
    bytes.extend(xxh3_64(&bytes).to_le_bytes());
    bytes
}

#[test]
fn a_resumed_training_gives_the_same_bytes() {
    let by_adam = || {
        let trainer = trainer(6).with_optimiser(Optimiser::Adam);
        let bytes = trainer.save();
        (trainer, bytes)
    };
    let plain = batch as fn(_, _) -> _;
    let trainers = [(saved(), plain), (masked_saved(), masked_batch), (by_adam(), plain)];
    for ((mut through, bytes), batch) in trainers {
        let mut resumed = Trainer::load(&bytes).expect("a checkpoint");
        assert_eq!(resumed.architecture(), through.architecture());
        assert_eq!((resumed.steps(), resumed.save()), (through.steps(), bytes));
        for step in 4..9 {
            for trainer in [&mut through, &mut resumed] {
                trainer.step(&batch(20, step), 1e-2).expect("a valid batch");
            }
        }
        assert!(through.save() == resumed.save());
        assert_eq!(through.weights(), resumed.weights());
    }
}

#[test]
fn every_truncation_and_every_changed_byte_is_an_error() {
    for (_, bytes) in [saved(), masked_saved()] {
        for length in (0..bytes.len()).step_by(97).chain(0..100) {
            let short = error(&bytes[..length]);
            assert!(matches!(short, CheckpointError::NotACheckpoint | CheckpointError::Length { .. }));
        }
        let longer = [bytes.as_slice(), &[0]].concat();
        assert!(matches!(error(&longer), CheckpointError::Length { .. }));
        for at in (0..bytes.len()).step_by(89).chain(0..100) {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x10;
            error(&damaged);
        }
    }
}

#[test]
fn an_error_says_what_is_wrong() {
    let (_, bytes) = saved();
    assert_eq!(error(b"PNG"), CheckpointError::NotACheckpoint);
    assert_eq!(error(&changed(&bytes, 8, &[9])), CheckpointError::Version { found: 9 });
    let huge = changed(&bytes, 12, &u32::MAX.to_le_bytes());
    assert!(matches!(error(&huge), CheckpointError::Architecture(_)));
    // The masks' numbers follow six others and three for each convolution; then the joints'.
    let (_, masked) = masked_saved();
    let hostile = changed(&masked, 8 + 4 * (6 + 9), &u32::MAX.to_le_bytes());
    assert!(matches!(error(&hostile), CheckpointError::Architecture(_)));
    let hostile = changed(&masked, 8 + 4 * (9 + 9), &u32::MAX.to_le_bytes());
    assert!(matches!(error(&hostile), CheckpointError::Architecture(_)));
    let fewer = changed(&masked, 8 + 4 * (9 + 9), &1u32.to_le_bytes());
    assert!(matches!(error(&fewer), CheckpointError::Length { .. }));
    let last = bytes.len() - 8;
    let nan = changed(&bytes, last - 4, &f32::NAN.to_le_bytes());
    assert_eq!(error(&nan), CheckpointError::Value { what: "a statistic" });
    let negative = changed(&bytes, last - 4, &(-1.0f32).to_le_bytes());
    assert_eq!(error(&negative), CheckpointError::Value { what: "a negative variance" });
    let mut damaged = bytes;
    damaged[last - 100] ^= 1;
    assert_eq!(error(&damaged), CheckpointError::Checksum);
}
