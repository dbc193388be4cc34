//! Where answers go: standard output in one of three formats, and why there are none to standard
//! error.

use std::io::{self, Write};

use grasp_answer::record::Record;
use grasp_answer::{human, moveit};
use grasp_program::status::ERROR;

/// What a record is written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OutputFormat {
    /// For a person.
    Text,
    /// A line of JSON.
    Json,
    /// A message for MoveIt.
    Moveit,
}

/// Writes records in order and remembers the worst exit status.
#[derive(Debug)]
pub(super) struct Output<W> {
    pub(super) format: OutputFormat,
    pub(super) status: u8,
    pub(super) out: W,
}

impl<W: Write> Output<W> {
    pub(super) fn write(&mut self, record: &Record) -> anyhow::Result<()> {
        self.status = self.status.max(record.status());
        match (self.format, record) {
            (OutputFormat::Json, _) => {
                // At once: who ends the program keeps whole lines.
                let mut line = serde_json::to_vec(record).map_err(io::Error::from)?;
                line.push(b'\n');
                self.out.write_all(&line)?;
            }
            (OutputFormat::Moveit, Record::Answer(answer)) if answer.strategy.is_some() => {
                match moveit::message(answer) {
                    Some(yaml) => self.write_message(&human::name(&answer.file, answer.frame), &yaml)?,
                    None => {
                        report(record.status(), &answer.file, &moveit::refusal(answer).unwrap_or_default())
                    }
                }
            }
            (OutputFormat::Text, Record::Answer(_)) => self.out.write_all(human::text(record).as_bytes())?,
            // Standard output is answers; why there is none belongs beside it.
            (OutputFormat::Text | OutputFormat::Moveit, _) => {
                report(record.status(), record.file(), &human::text(record))
            }
        }
        self.out.flush()?;
        Ok(())
    }

    /// Writes a message for MoveIt, and what it warns of for the person who does not read its
    /// comments.
    pub(super) fn write_message(&mut self, name: &str, yaml: &str) -> io::Result<()> {
        for warning in grasp_robot::moveit::warnings(yaml) {
            tracing::warn!(subject = name, "warning: {warning}");
        }
        self.out.write_all(yaml.as_bytes())
    }
}

/// Says why an input has no answer on standard output, in lines that name it: as an error where
/// that is what `status` says.
pub(super) fn report(status: u8, file: &str, lines: &str) {
    let lines = lines.trim_end();
    match status {
        ERROR => tracing::error!(file, "{lines}"),
        _ => tracing::warn!(file, "{lines}"),
    }
}
