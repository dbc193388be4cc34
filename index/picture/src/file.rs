//! Reading a picture's file, no further than a picture of its size can reach.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use crate::limits::MAX_OVERHEAD;
use crate::size::{check_size, max_bytes};
use crate::{DecodeError, Format, dimensions};

/// The bytes of a picture's file.
///
/// # Errors
/// Where the file cannot be read, and where it is longer than any picture of its size can be; of
/// that much, no more than the first [`MAX_OVERHEAD`] bytes are held.
pub fn read(path: &Path) -> Result<Vec<u8>, DecodeError> {
    let cannot = |reason| DecodeError::Read { path: path.to_owned(), reason };
    let mut file = File::open(path).map_err(cannot)?;
    // A device or a pipe has no honest length.
    let metadata = file.metadata().map_err(cannot)?;
    if metadata.is_dir() {
        return Err(cannot(io::Error::new(io::ErrorKind::IsADirectory, "a folder is no picture")));
    }
    let length = metadata.len();
    let mut bytes = Vec::with_capacity(usize::try_from(length.min(MAX_OVERHEAD)).unwrap_or(0));
    read_up_to(&mut file, &mut bytes, MAX_OVERHEAD).map_err(cannot)?;
    if (bytes.len() as u64) < MAX_OVERHEAD {
        return Ok(bytes);
    }
    let (width, height) = dimensions(&bytes)?;
    let most = max_bytes(Format::detect(&bytes)?, check_size(width, height)?);
    if length > most {
        return Err(DecodeError::TooLong { most, width, height });
    }
    bytes.reserve_exact(usize::try_from(length.saturating_sub(MAX_OVERHEAD)).unwrap_or(0));
    read_up_to(&mut file, &mut bytes, most + 1).map_err(cannot)?;
    Ok(bytes)
}

/// Reads until `bytes` has `most`.
fn read_up_to(file: &mut File, bytes: &mut Vec<u8>, most: u64) -> io::Result<()> {
    file.take(most.saturating_sub(bytes.len() as u64)).read_to_end(bytes)?;
    Ok(())
}
