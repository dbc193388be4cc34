//! Where the bytes of an index go on their way: in order, hashed as they come, to a file or to
//! memory.

use crate::file::align::{ALIGNMENT, align};
use crate::file::bytes::Written;
use crate::file::sections::{ElementType, Section, SectionKind};
use rkyv::util::AlignedVec;
use std::fs::File;
use std::io::{self, BufWriter, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::Path;
use xxhash_rust::xxh3::Xxh3;

/// What a file's buffer holds, and how many bytes are written between two looks at whether to go
/// on.
const PIECE: usize = 1 << 20;

/// Bytes written one after the other, of which a section may be open.
pub(super) struct Sink {
    to: Target,
    length: u64,
    /// Of the open section.
    start: u64,
    hash: Xxh3,
}

enum Target {
    Memory(AlignedVec<{ ALIGNMENT as usize }>),
    File(BufWriter<File>),
}

impl Sink {
    /// Into memory.
    pub(super) fn memory() -> Self {
        Self::to(Target::Memory(AlignedVec::new()))
    }

    /// Into an empty file that nobody else writes.
    pub(super) fn file(file: File) -> Self {
        Self::to(Target::File(BufWriter::with_capacity(PIECE, file)))
    }

    /// Into a file without a name in `folder`: the operating system removes it, however the program
    /// ends.
    pub(super) fn unnamed(folder: &Path) -> io::Result<Self> {
        Ok(Self::file(tempfile::tempfile_in(folder)?))
    }

    fn to(to: Target) -> Self {
        Self { to, length: 0, start: 0, hash: Xxh3::new() }
    }

    /// How many bytes were written.
    pub(super) fn len(&self) -> u64 {
        self.length
    }

    /// Writes bytes after the others. They belong to the open section.
    pub(super) fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        match &mut self.to {
            Target::Memory(held) => held.extend_from_slice(bytes),
            Target::File(file) => file.write_all(bytes)?,
        }
        self.hash.update(bytes);
        self.length += bytes.len() as u64;
        Ok(())
    }

    /// Opens a section: at the next multiple of 64, with zeros up to there.
    pub(super) fn open(&mut self) -> io::Result<()> {
        let start = align(self.length).ok_or_else(|| io::Error::from(io::ErrorKind::FileTooLarge))?;
        self.append(&[0; ALIGNMENT as usize][..(start - self.length) as usize])?;
        self.start = start;
        self.hash.reset();
        Ok(())
    }

    /// Closes the open section: what was written since [`Self::open`].
    pub(super) fn close(&self, kind: SectionKind, element: ElementType) -> Section {
        Section {
            kind,
            element,
            offset: self.start,
            length: self.length - self.start,
            xxh3: self.hash.digest(),
        }
    }

    /// Writes many bytes after the others. `wrote` hears of every piece how many bytes it had, and
    /// stops the work by an error.
    pub(super) fn append_all<E: From<io::Error>>(
        &mut self,
        bytes: &[u8],
        wrote: &mut dyn FnMut(usize) -> Result<(), E>,
    ) -> Result<(), E> {
        for piece in bytes.chunks(PIECE) {
            self.append(piece)?;
            wrote(piece.len())?;
        }
        Ok(())
    }

    /// All that was written, to look at. Nothing more is written meanwhile.
    pub(super) fn written(&mut self) -> io::Result<Written<'_>> {
        match &mut self.to {
            Target::Memory(held) => Ok(Written::Held(held)),
            Target::File(file) => {
                file.flush()?;
                Written::map(file.get_mut())
            }
        }
    }

    /// Passes on what was written from a byte on, in pieces that numbers can be read from. Only one
    /// of them is in memory, where a mapping would keep all.
    pub(super) fn pass_on<E: From<io::Error>>(
        &mut self,
        from: usize,
        take: &mut dyn FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        match &mut self.to {
            Target::Memory(held) => held.get(from..).unwrap_or(&[]).chunks(PIECE).try_for_each(take),
            Target::File(file) => {
                let mut piece = vec![0u64; PIECE / size_of::<u64>()];
                let piece: &mut [u8] = bytemuck::cast_slice_mut(&mut piece);
                file.seek(SeekFrom::Start(from as u64))?;
                let mut left = self.length.saturating_sub(from as u64);
                while left > 0 {
                    let piece = &mut piece[..left.min(PIECE as u64) as usize];
                    file.get_mut().read_exact(piece)?;
                    left -= piece.len() as u64;
                    take(piece)?;
                }
                // Whatever is written next comes after all.
                file.seek(SeekFrom::Start(self.length))?;
                Ok(())
            }
        }
    }

    /// Writes over the first bytes, which were zeros, as the last thing of all.
    pub(super) fn finish(&mut self, first: &[u8]) -> io::Result<()> {
        match &mut self.to {
            Target::Memory(held) => held.iter_mut().zip(first).for_each(|(to, from)| *to = *from),
            Target::File(file) => {
                file.flush()?;
                file.seek(SeekFrom::Start(0))?;
                file.write_all(first)?;
                file.flush()?;
            }
        }
        Ok(())
    }
}

impl std::fmt::Debug for Sink {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let to = match self.to {
            Target::Memory(_) => "memory",
            Target::File(_) => "a file",
        };
        write!(f, "{} bytes in {to}", self.length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_what_was_written_and_more_can_follow() {
        let bytes: Vec<u8> = (0..2 * PIECE + 12).map(|at| (at % 251) as u8).collect();
        let folder = tempfile::tempdir().unwrap();
        for mut sink in [Sink::memory(), Sink::unnamed(folder.path()).unwrap()] {
            sink.append(&bytes).unwrap();
            let mut pieces = Vec::new();
            let mut take = |piece: &[u8]| -> io::Result<()> {
                pieces.push(piece.len());
                assert_eq!(bytemuck::cast_slice::<u8, u32>(piece).len() * 4, piece.len());
                Ok(())
            };
            sink.pass_on(8, &mut take).unwrap();
            assert_eq!(pieces, [PIECE, PIECE, 4]);
            sink.append(b"more").unwrap();
            let mut all = Vec::new();
            let mut take = |piece: &[u8]| -> io::Result<()> {
                all.extend_from_slice(piece);
                Ok(())
            };
            sink.pass_on(0, &mut take).unwrap();
            assert!(all == [&bytes, &b"more"[..]].concat());
            // Past the end there is nothing, and an error stops it.
            sink.pass_on(all.len() + 8, &mut |_| Err(io::Error::other("called"))).unwrap();
            assert!(sink.pass_on(0, &mut |_| Err(io::Error::other("full"))).is_err());
        }
    }
}
