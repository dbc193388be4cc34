//! What goes wrong, as Python's exceptions, in the words of the programs.

use std::error::Error;
use std::path::Path;

use grasp_answer::found::with_place;
use grasp_answer::human;
use grasp_answer::record::Record;
use grasp_index::{CannotRecognise, FileChanged, OpenError, SearchError};
use grasp_recognise::RecogniseError;
use grasp_recognise::picture::DecodeError;
use grasp_terminal::error::message;
use pyo3::prelude::*;

/// The classes that `grasp/errors.py` defines.
mod classes {
    pyo3::import_exception!(grasp.errors, GraspError);
    pyo3::import_exception!(grasp.errors, IndexFileError);
    pyo3::import_exception!(grasp.errors, ParameterError);
    pyo3::import_exception!(grasp.errors, PictureError);
}

/// A parameter that cannot be; the message says what can.
pub(crate) fn parameter(message: impl Into<String>) -> PyErr {
    classes::ParameterError::new_err(message.into())
}

/// A fault of the package, and of no caller.
pub(crate) fn internal(message: &str) -> PyErr {
    classes::GraspError::new_err(format!("{message}: report this"))
}

/// Any other failure.
pub(crate) fn failure(error: &(dyn Error + 'static)) -> PyErr {
    classes::GraspError::new_err(in_words(error))
}

/// Says what a picture cannot be, before anything looks at it.
pub(crate) fn not_a_picture(message: impl Into<String>) -> PyErr {
    classes::PictureError::new_err((message.into(), "not_an_image", false))
}

/// A picture without an answer; `file` is its name in messages.
pub(crate) fn picture(file: Option<&str>, error: &RecogniseError) -> PyErr {
    if let RecogniseError::Search(error) = error {
        return search(error);
    }
    let line = match file {
        Some(file) => {
            human::text(&Record::not_recognised(file.to_owned(), None, error)).trim_end().to_owned()
        }
        None => error.to_string(),
    };
    classes::PictureError::new_err((line, error.kind(), error.is_rejection()))
}

/// A search that cannot be made.
pub(crate) fn search(error: &SearchError) -> PyErr {
    parameter(error.to_string())
}

/// Queries that cannot be searched for; `place` says which value is meant.
pub(crate) fn queries(error: &SearchError, place: impl FnOnce(usize) -> String) -> PyErr {
    parameter(with_place(error, place))
}

/// Where there is no index.
pub(crate) fn no_index(path: &Path) -> PyErr {
    index_file(format!(
        "no index at {}: build one with `grasp-builder build --out grasp.idx`, or name one",
        path.display()
    ))
}

/// A file that cannot be opened as an index.
pub(crate) fn open(path: &Path, error: &OpenError) -> PyErr {
    index_file(cannot_use(path, error))
}

/// An index that was overwritten while it was in use.
pub(crate) fn changed(path: &Path, error: FileChanged) -> PyErr {
    index_file(cannot_use(path, &error))
}

/// An index that recognises nothing.
pub(crate) fn cannot_recognise(path: &Path, error: CannotRecognise) -> PyErr {
    index_file(cannot_use(path, &error))
}

/// A file that is no sound index.
pub(crate) fn index_file(message: String) -> PyErr {
    classes::IndexFileError::new_err(message)
}

fn cannot_use(path: &Path, error: &(dyn Error + 'static)) -> String {
    format!("cannot use the index {}: {}", path.display(), in_words(error))
}

/// An error with its causes.
fn in_words(error: &(dyn Error + 'static)) -> String {
    message(std::iter::successors(Some(error), |&error| error.source()))
}

/// A mask or a depth picture that cannot be read.
pub(crate) fn unusable_source(what: &str, path: &Path, error: DecodeError) -> PyErr {
    let line = format!("cannot use the {what} {}: {}", path.display(), in_words(&error));
    classes::PictureError::new_err((line, error.kind(), false))
}

/// Whether it is what a picture cannot be answered for.
pub(crate) fn is_of_picture(py: Python<'_>, error: &PyErr) -> bool {
    error.is_instance_of::<classes::PictureError>(py)
}
