//! Why the service cannot use what lies at its index's path.

use std::error::Error;
use std::path::PathBuf;
use std::{io, iter};

use grasp_index::{CannotRecognise, FileChanged, OpenError, Problem};
use grasp_terminal::error::message;

/// The file at the index's path cannot be served.
#[derive(Debug, thiserror::Error)]
#[error("cannot use the index {}: {}", path.display(), text(fault))]
pub struct UnusableIndex {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it; part of the message, and so no source beside it.
    pub fault: IndexFault,
}

/// What is wrong with the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IndexFault {
    /// There is none, or it cannot be looked at.
    #[error(transparent)]
    File(#[from] io::Error),
    /// It cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// It is damaged; only an index that is to replace another is read through for that.
    #[error(transparent)]
    Damaged(#[from] Problem),
    /// It was overwritten while it was checked.
    #[error(transparent)]
    Changed(#[from] FileChanged),
    /// It cannot take the place of the one that is served.
    #[error("the index that is served can tell what pictures show")]
    RecognisesNothing(#[source] CannotRecognise),
    /// The look at it ended in a fault of the program.
    #[error("it could not be looked at, which is a fault of this program: please report it")]
    Unknown,
}

fn text(fault: &IndexFault) -> String {
    let first: &(dyn Error + 'static) = fault;
    message(iter::successors(Some(first), |&error| error.source()))
}
