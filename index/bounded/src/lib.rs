//! Reading small files, however large the file of that name is.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

/// The most bytes that a file of text is read of: descriptions, tables and landmarks, which people
/// or small programs write.
const MOST_TEXT: u64 = 16 << 20;

/// The text of a file.
///
/// # Errors
/// Those of reading, where the bytes are not UTF-8, and [`io::ErrorKind::FileTooLarge`] beyond
/// 16 MiB: a device has no end.
pub fn read_text(path: &Path) -> io::Result<String> {
    let bytes = read(path, MOST_TEXT)?;
    String::from_utf8(bytes).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error.utf8_error()))
}

/// The bytes of a file.
///
/// # Errors
/// Those of reading, and [`io::ErrorKind::FileTooLarge`] beyond `most` bytes.
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        let why = format!("it is larger than {} MiB: is it the right file?", most >> 20);
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, why));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_to_its_end_and_a_larger_one_is_rejected() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, "abcd").unwrap();
        assert_eq!((read(&path, 4).unwrap(), read_text(&path).unwrap()), (b"abcd".to_vec(), "abcd".into()));
        assert_eq!(read(&path, 3).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        std::fs::write(&path, [0xff]).unwrap();
        assert_eq!(read_text(&path).unwrap_err().kind(), io::ErrorKind::InvalidData);
    }
}
