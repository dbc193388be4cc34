//! The figures of an experiment on standard output.

use std::io::{self, Write as _};

use serde::Serialize;

/// The figures on standard output, as a JSON record or as text.
pub(super) fn print(
    json: bool,
    figures: &impl Serialize,
    text: impl FnOnce() -> String,
) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    if json {
        serde_json::to_writer(&mut out, figures).map_err(io::Error::from)?;
        writeln!(out)?;
    } else {
        write!(out, "{}", text())?;
    }
    Ok(())
}
