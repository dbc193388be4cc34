//! A training on the disk: what it was asked for and how it went as a line of JSON, the trainer's
//! state, and the xxh3 of all of it.

use std::fs;
use std::io::{self, Write as _};
use std::path::Path;

use anyhow::{Context as _, bail};
use grasp_index::AtomicFile;
use grasp_renders::RENDERER_VERSION;
use grasp_train::Trainer;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_64;

use super::Options;
use super::curve::{MeanLosses, Row};

/// Goes up with every change of what a training does, or of this file.
const VERSION: u32 = 10;
/// Bytes of the hash.
const HASH: usize = 8;

/// What the line of JSON holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Header {
    grasp_training: u32,
    renderer: u32,
    options: Options,
    curve: Vec<Row>,
    losses: MeanLosses,
}

/// How far a training has come.
pub(super) struct State {
    pub(super) trainer: Trainer,
    pub(super) curve: Vec<Row>,
    /// Of the steps since the curve's last row.
    pub(super) losses: MeanLosses,
}

/// Writes a checkpoint, whole or not at all.
///
/// # Errors
/// Where the file cannot be written.
pub(super) fn write(path: &Path, options: &Options, state: &State) -> anyhow::Result<()> {
    let State { trainer, curve, losses } = state;
    let header = Header {
        grasp_training: VERSION,
        renderer: RENDERER_VERSION,
        options: options.clone(),
        curve: curve.clone(),
        losses: losses.clone(),
    };
    let mut bytes = serde_json::to_vec(&header)?;
    bytes.push(b'\n');
    bytes.extend(trainer.save());
    let hash = xxh3_64(&bytes);
    bytes.extend(hash.to_le_bytes());
    let mut file = AtomicFile::create(path)?;
    file.write_all(&bytes).with_context(|| format!("cannot write {}", path.display()))?;
    Ok(file.commit()?)
}

/// Reads the checkpoint of a training with these options; `None` where there is none.
///
/// # Errors
/// Where the file cannot be read, is damaged, or is of another training: it is not overwritten.
pub(super) fn read(path: &Path, options: &Options) -> anyhow::Result<Option<State>> {
    let bytes = match fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error).with_context(|| format!("cannot read {}", path.display())),
    };
    let name = path.display();
    let state = decode(&bytes, options).with_context(|| format!("cannot go on from {name}"))?;
    Ok(Some(state))
}

fn decode(bytes: &[u8], options: &Options) -> anyhow::Result<State> {
    const DAMAGED: &str = "it is damaged, or no checkpoint of a training: remove it to begin again, or name \
                           another file with --checkpoint";
    let (bytes, hash) = bytes.split_last_chunk::<HASH>().context(DAMAGED)?;
    if xxh3_64(bytes) != u64::from_le_bytes(*hash) {
        bail!(DAMAGED);
    }
    let end = bytes.iter().position(|&byte| byte == b'\n').context(DAMAGED)?;
    let (header, trainer) = bytes.split_at(end);
    /// What every version has.
    #[derive(Deserialize)]
    struct Versions {
        grasp_training: u32,
        renderer: u32,
    }
    let Versions { grasp_training, renderer } = serde_json::from_slice(header).context(DAMAGED)?;
    if (grasp_training, renderer) != (VERSION, RENDERER_VERSION) {
        bail!("another version of this program wrote it: remove it to begin again");
    }
    let header: Header = serde_json::from_slice(header).context(DAMAGED)?;
    if header.options != *options {
        bail!(
            "it is of a training with {}, and not with {options}: give its options to go on with it, remove it to \
             begin again, or name another file with --checkpoint",
            header.options
        );
    }
    let trainer = Trainer::load(trainer.get(1..).unwrap_or_default()).context(DAMAGED)?;
    Ok(State { trainer, curve: header.curve, losses: header.losses })
}
