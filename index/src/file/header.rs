//! The first 64 bytes, the same in every version of the format. Little-endian.
//!
//! | bytes | |
//! |---|---|
//! | 0..8 | magic |
//! | 8..12 | the least reader version that can read the file |
//! | 12..16 | the version that wrote it |
//! | 16..24 | the file's length in bytes |
//! | 24..32 | the catalogue's offset |
//! | 32..40 | the catalogue's length |
//! | 40..48 | xxh3 of the catalogue |
//! | 48..56 | 0 |
//! | 56..64 | xxh3 of bytes 0..56 |

use super::align::{ALIGNMENT, align};
use super::corruption::Corruption;
use super::error::OpenError;
use xxhash_rust::xxh3::xxh3_64;

/// Not valid text, so that transfers that rewrite line endings break it visibly.
const MAGIC: [u8; 8] = *b"\x89GRSP\r\n\x1a";
/// The header's length in bytes.
pub(crate) const LENGTH: usize = 64;
/// The version of the format that this crate reads and writes. It grows when older readers cannot
/// read new files.
pub(crate) const VERSION: u32 = 7;
/// The oldest version that this crate reads. Version 1 was written by no release.
const OLDEST: u32 = 2;

/// Where the catalogue lies, and the hash of its bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Header {
    /// The least version of a reader that can read the file.
    pub(crate) least_reader: u32,
    /// The version that wrote the file.
    pub(crate) version: u32,
    pub(crate) file_length: u64,
    pub(crate) catalogue_offset: u64,
    pub(crate) catalogue_length: u64,
    pub(crate) catalogue_hash: u64,
}

impl Header {
    pub(crate) fn to_bytes(self) -> [u8; LENGTH] {
        let mut bytes = [0; LENGTH];
        bytes[0..8].copy_from_slice(&MAGIC);
        bytes[8..12].copy_from_slice(&self.least_reader.to_le_bytes());
        bytes[12..16].copy_from_slice(&self.version.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.file_length.to_le_bytes());
        bytes[24..32].copy_from_slice(&self.catalogue_offset.to_le_bytes());
        bytes[32..40].copy_from_slice(&self.catalogue_length.to_le_bytes());
        bytes[40..48].copy_from_slice(&self.catalogue_hash.to_le_bytes());
        let hash = xxh3_64(&bytes[..56]);
        bytes[56..64].copy_from_slice(&hash.to_le_bytes());
        bytes
    }

    /// Reads the header of a whole file and checks all that can be checked without the catalogue's
    /// bytes.
    pub(crate) fn read(file: &[u8]) -> Result<Self, OpenError> {
        Self::parse(file, file.len() as u64)
    }

    /// The same from the first bytes of a file of `found` bytes: at least its header, or all of it.
    pub(crate) fn parse(file: &[u8], found: u64) -> Result<Self, OpenError> {
        if file.is_empty() {
            return Err(OpenError::Empty);
        }
        if !file.starts_with(&MAGIC) {
            let is_start_of_magic = MAGIC.starts_with(file);
            let expected = LENGTH as u64;
            return Err(if is_start_of_magic {
                OpenError::Truncated { expected, found }
            } else {
                OpenError::NotAnIndex
            });
        }
        let Some(bytes) = file.first_chunk::<LENGTH>() else {
            return Err(OpenError::Truncated { expected: LENGTH as u64, found });
        };
        // Before the version: a version is believed only where the header is whole.
        if xxh3_64(&bytes[..56]) != u64_at(bytes, 56) {
            return Err(Corruption::Header.into());
        }
        let needs = (u64_at(bytes, 8) & u64::from(u32::MAX)) as u32;
        if needs > VERSION {
            return Err(OpenError::TooNew { needs, reader: VERSION });
        }
        let wrote = (u64_at(bytes, 8) >> 32) as u32;
        if wrote < OLDEST {
            return Err(OpenError::TooOld { wrote, oldest: OLDEST });
        }
        let header = Self {
            least_reader: needs,
            version: wrote,
            file_length: u64_at(bytes, 16),
            catalogue_offset: u64_at(bytes, 24),
            catalogue_length: u64_at(bytes, 32),
            catalogue_hash: u64_at(bytes, 40),
        };
        if found < header.file_length {
            return Err(OpenError::Truncated { expected: header.file_length, found });
        }
        if found > header.file_length {
            return Err(OpenError::TooLong { expected: header.file_length, found });
        }
        let end = header.catalogue_offset.checked_add(header.catalogue_length);
        let in_order = header.catalogue_offset >= LENGTH as u64
            && align(header.catalogue_offset) == Some(header.catalogue_offset);
        if end != Some(header.file_length) || !in_order {
            return Err(Corruption::CataloguePlace { alignment: ALIGNMENT }.into());
        }
        Ok(header)
    }
}

fn u64_at(bytes: &[u8; LENGTH], at: usize) -> u64 {
    let mut value = [0; 8];
    value.copy_from_slice(&bytes[at..at + 8]);
    u64::from_le_bytes(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a file of two sections' room and a catalogue of 100 bytes.
    const SOUND: Header = Header {
        least_reader: 3,
        version: VERSION,
        file_length: 292,
        catalogue_offset: 192,
        catalogue_length: 100,
        catalogue_hash: 5,
    };

    /// What is read of a whole file with this header.
    fn read(header: Header) -> Result<Header, OpenError> {
        let mut file = Vec::from(header.to_bytes());
        file.resize(SOUND.file_length as usize, 0);
        Header::read(&file)
    }

    #[test]
    fn a_header_is_read_as_it_was_written() {
        let at_once = Header { catalogue_offset: 64, catalogue_length: 228, ..SOUND };
        let empty = Header { file_length: 64, catalogue_offset: 64, catalogue_length: 0, ..SOUND };
        for header in [SOUND, at_once] {
            assert_eq!(read(header).expect("it is sound"), header);
        }
        assert_eq!(Header::read(&empty.to_bytes()).expect("it is sound"), empty);
    }

    /// The catalogue starts after the header, at a multiple of 64, and is the file's end.
    #[test]
    fn a_catalogue_elsewhere_is_refused() {
        for (catalogue_offset, catalogue_length) in
            [(0, 292), (192, 99), (192, 101), (128, 100), (191, 101), (224, 68), (u64::MAX - 63, 356)]
        {
            let refused = read(Header { catalogue_offset, catalogue_length, ..SOUND });
            let is_told =
                matches!(refused, Err(OpenError::Corrupt(Corruption::CataloguePlace { alignment: 64 })));
            assert!(is_told, "{catalogue_offset} and {catalogue_length}: {refused:?}");
        }
    }

    #[test]
    fn the_ends_of_the_versions_are_read_and_none_beyond() {
        let of = |least_reader, version| read(Header { least_reader, version, ..SOUND });
        assert!(of(VERSION, VERSION + 1).is_ok(), "a newer writer wrote what this reader reads");
        assert!(of(OLDEST, OLDEST).is_ok());
        assert!(matches!(of(VERSION + 1, VERSION + 1), Err(OpenError::TooNew { needs: 8, reader: 7 })));
        assert!(matches!(of(1, 1), Err(OpenError::TooOld { wrote: 1, oldest: 2 })));
    }
}
