//! The table of answers: a line is added for each and is on the disk before the next picture is
//! shown.

use std::collections::HashMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};

use super::choices::CHOICES;

/// The columns of the table; an interface.
const HEADER: &str = "file,answer,cutkosky\n";

/// A table of answers that is open, and locked against a second quiz. Of several answers to a
/// picture the last counts.
#[derive(Debug)]
pub struct AnswerFile {
    path: PathBuf,
    file: File,
    length: u64,
}

/// Why answers cannot be kept.
#[derive(Debug, thiserror::Error)]
pub enum AnswerError {
    /// The operating system refused; a full disk is told here.
    #[error("cannot keep answers in {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// Another quiz is under way.
    #[error("another quiz writes to {}: end it, or name another file with --out", path.display())]
    Locked {
        /// The file.
        path: PathBuf,
    },
    /// The file is something else.
    #[error("{} is not a table of answers: name another file with --out", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// A line cannot be understood.
    #[error("{}, line {line}: `{found}` is not one of the six grasps: correct it, or delete the line", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: u64,
        /// What stands there.
        found: String,
    },
}

impl AnswerFile {
    /// Opens a table, or begins one, and tells the answers in it by picture, as places in
    /// [`CHOICES`]. A last line that was cut short is dropped.
    ///
    /// # Errors
    /// [`AnswerError`]; the file is then as it was.
    pub fn open(path: &Path) -> Result<(Self, HashMap<String, usize>), AnswerError> {
        let io = |source| AnswerError::Io { path: path.to_owned(), source };
        let mut file = OpenOptions::new().read(true).append(true).create(true).open(path).map_err(io)?;
        file.try_lock().map_err(|error| match error {
            TryLockError::WouldBlock => AnswerError::Locked { path: path.to_owned() },
            TryLockError::Error(source) => io(source),
        })?;
        let mut text = String::new();
        file.read_to_string(&mut text).map_err(|error| match error.kind() {
            io::ErrorKind::InvalidData => AnswerError::Foreign { path: path.to_owned() },
            _ => io(error),
        })?;
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let (lines, cut_short) = text.split_at(whole);
        let is_begun = lines.is_empty() && HEADER.starts_with(cut_short);
        if !is_begun && !lines.starts_with(HEADER) {
            return Err(AnswerError::Foreign { path: path.to_owned() });
        }
        let before = read(path, lines)?;
        if !cut_short.is_empty() {
            file.set_len(whole as u64).map_err(io)?;
        }
        let mut answers = Self { path: path.to_owned(), file, length: whole as u64 };
        if whole == 0 {
            answers.write(HEADER.as_bytes())?;
        }
        Ok((answers, before))
    }

    /// Adds an answer, a place in [`CHOICES`].
    ///
    /// # Errors
    /// Where it cannot be written; the table is then without it.
    pub fn append(&mut self, picture: &str, choice: usize) -> Result<(), AnswerError> {
        let Some(choice) = CHOICES.get(choice) else {
            return Ok(());
        };
        let mut line = csv::Writer::from_writer(Vec::new());
        let written = line.write_record([picture, choice.grasp, &choice.cutkosky.to_string()]);
        let bytes = written
            .map_err(io::Error::from)
            .and_then(|()| line.into_inner().map_err(|error| io::Error::other(error.to_string())));
        let bytes = bytes.map_err(|source| AnswerError::Io { path: self.path.clone(), source })?;
        self.write(&bytes)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), AnswerError> {
        match self.file.write_all(bytes).and_then(|()| self.file.sync_data()) {
            Ok(()) => {
                self.length += bytes.len() as u64;
                Ok(())
            }
            Err(source) => {
                // Half a line must not stay; where even that fails, opening the file again drops
                // it.
                let _ = self.file.set_len(self.length);
                Err(AnswerError::Io { path: self.path.clone(), source })
            }
        }
    }
}

fn read(path: &Path, lines: &str) -> Result<HashMap<String, usize>, AnswerError> {
    let mut before = HashMap::new();
    for row in csv::Reader::from_reader(lines.as_bytes()).records() {
        let row = row.map_err(|_| AnswerError::Foreign { path: path.to_owned() })?;
        let found = row.get(1).unwrap_or_default();
        let choice = CHOICES.iter().position(|choice| choice.grasp == found);
        let choice = choice.ok_or_else(|| AnswerError::Line {
            path: path.to_owned(),
            line: row.position().map_or(0, csv::Position::line),
            found: found.to_owned(),
        })?;
        before.insert(row.get(0).unwrap_or_default().to_owned(), choice);
    }
    Ok(before)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn answers_are_there_again_and_the_last_one_counts() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("answers.csv");
        let (mut answers, before) = AnswerFile::open(&path).unwrap();
        assert!(before.is_empty());
        assert!(matches!(AnswerFile::open(&path), Err(AnswerError::Locked { .. })));
        for (picture, choice) in [("a, b.png", 0), ("c.png", 5), ("a, b.png", 3)] {
            answers.append(picture, choice).unwrap();
        }
        drop(answers);
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(text.lines().nth(1), Some("\"a, b.png\",large-diameter,1"));
        // Cut off in the middle of a line, as by a power failure.
        fs::write(&path, text + "d.png,pin").unwrap();
        let (mut answers, before) = AnswerFile::open(&path).unwrap();
        assert_eq!(before, HashMap::from([("a, b.png".into(), 3), ("c.png".into(), 5)]));
        answers.append("d.png", 1).unwrap();
        drop(answers);
        assert_eq!(AnswerFile::open(&path).unwrap().1.len(), 3);
    }

    #[test]
    fn other_files_are_left_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("labels.csv");
        for text in ["file,grasp\na,pinch\n", "file,answer", "nothing", "\0\0\n"] {
            fs::write(&path, text).unwrap();
            let opened = AnswerFile::open(&path);
            // Half a header is ours, and is begun anew.
            assert_eq!(opened.is_ok(), text == "file,answer", "{text}");
            if opened.is_err() {
                assert_eq!(fs::read_to_string(&path).unwrap(), text);
            }
        }
        fs::write(&path, format!("{HEADER}a.png,lateral,1\n")).unwrap();
        let error = AnswerFile::open(&path).unwrap_err().to_string();
        assert!(error.contains("line 2: `lateral`"), "{error}");
    }
}
