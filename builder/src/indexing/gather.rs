//! Described pictures, gathered into an index that is then finished.

use std::time::Duration;

use anyhow::{Context as _, bail};
use grasp_index::{AtomicFile, BuildError, IndexParams, IndexWriter, Phase};
use grasp_terminal::Progress;
use grasp_terminal::text::{counted, percent};

use super::described::Described;
use super::inputs::Inputs;
use super::known::Known;
use super::report::Report;
use crate::interrupt::{self, Interrupted};

/// An index on its way: entries go in, in the order of the source, and [`Self::finish`] makes the
/// file of them.
pub(crate) struct Gathered {
    out: String,
    writer: IndexWriter,
    inputs: Inputs,
    report: Report,
}

impl Gathered {
    /// An index in `file`, without entries, that comes from where `origin` says.
    pub(crate) fn new(
        file: AtomicFile,
        params: IndexParams,
        origin: Vec<(String, String)>,
    ) -> anyhow::Result<Self> {
        let inputs = Inputs::new(&params, origin);
        let report =
            Report { written: None, entries: 0, reused: 0, without_hand: 0, elapsed: Duration::default() };
        let out = file.path().display().to_string();
        let writer = IndexWriter::create_in(file, params)?;
        Ok(Self { out, writer, inputs, report })
    }

    /// Takes pictures in.
    pub(crate) fn take(&mut self, batch: Vec<Described>) -> anyhow::Result<()> {
        for described in batch {
            let Some((entry, reused)) = described else {
                self.report.without_hand += 1;
                continue;
            };
            self.inputs.add(&entry);
            self.writer.push(entry)?;
            self.report.entries += 1;
            self.report.reused += usize::from(reused);
        }
        Ok(())
    }

    /// Counts pictures that were found to show no hand.
    pub(crate) fn add_without_hand(&mut self, pictures: u64) {
        self.report.without_hand += pictures as usize;
    }

    /// Makes the index, unless the existing file is what would come of it. `asked` gives the
    /// held-out descriptors and their classes.
    pub(crate) fn finish(
        self,
        known: &Known,
        asked: impl FnOnce() -> anyhow::Result<(Vec<f32>, Vec<u16>)>,
        progress: Progress,
    ) -> anyhow::Result<Report> {
        let Self { out, mut writer, inputs, mut report } = self;
        if report.entries == 0 {
            let pictures = counted(report.without_hand, ["picture", "pictures"]);
            bail!("no hand in {pictures}: there is nothing to index");
        }
        known.check()?;
        if known.is_made_from(&inputs) {
            return Ok(report);
        }
        writer.add_provenance(inputs.provenance());
        let spinner = progress.spinner("rendering held-out hands");
        let (descriptors, classes) = asked()?;
        writer.hold_out(descriptors, classes)?;
        drop(spinner);
        let spinner = progress.spinner("hashing");
        let summary = writer.finish(&|phase, share| {
            let doing = match phase {
                Phase::Sigma => "measuring sigma",
                Phase::Tune => "choosing the hash",
                Phase::Tables => "filling the hash tables",
                Phase::Measure => "measuring the search",
                Phase::Calibrate => "calibrating the vote",
                _ => "writing",
            };
            spinner.set_phase(doing);
            spinner.set_message(match share {
                0.0 => doing.into(),
                share => format!("{doing} ({})", percent(share)),
            });
            interrupt::flow()
        });
        drop(spinner);
        let summary = match summary {
            Err(BuildError::Stopped) => return Err(Interrupted.into()),
            other => other.with_context(|| format!("{out} was not written"))?,
        };
        report.written = Some(summary);
        Ok(report)
    }
}
