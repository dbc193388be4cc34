//! Parts of a file, read as if nothing had been between them: a decoder sees what pixels follow
//! from, and nothing is copied.

use std::io::{self, BufRead, Read, Seek, SeekFrom};

/// Slices, one behind the other, as one reader.
#[derive(Debug, Default)]
pub(crate) struct Pieces<'a> {
    pieces: Vec<&'a [u8]>,
    /// The piece that is read next, and how much of it has been.
    at: (usize, usize),
}

impl<'a> Pieces<'a> {
    /// Adds what follows. Empty pieces would look like the end.
    pub(crate) fn push(&mut self, piece: &'a [u8]) {
        if !piece.is_empty() {
            self.pieces.push(piece);
        }
    }

    fn length(&self) -> u64 {
        self.pieces.iter().map(|piece| piece.len() as u64).sum()
    }

    fn position(&self) -> u64 {
        let (piece, offset) = self.at;
        self.pieces.iter().take(piece).map(|piece| piece.len() as u64).sum::<u64>() + offset as u64
    }

    fn rest(&self) -> &'a [u8] {
        let (piece, offset) = self.at;
        self.pieces.get(piece).and_then(|piece| piece.get(offset..)).unwrap_or_default()
    }
}

impl<'a> FromIterator<&'a [u8]> for Pieces<'a> {
    fn from_iter<I: IntoIterator<Item = &'a [u8]>>(pieces: I) -> Self {
        let mut all = Self::default();
        pieces.into_iter().for_each(|piece| all.push(piece));
        all
    }
}

impl Read for Pieces<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.rest().read(buffer)?;
        self.consume(read);
        Ok(read)
    }
}

impl BufRead for Pieces<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        Ok(self.rest())
    }

    fn consume(&mut self, amount: usize) {
        self.at.1 += amount;
        if self.rest().is_empty() && self.at.0 < self.pieces.len() {
            self.at = (self.at.0 + 1, 0);
        }
    }
}

impl Seek for Pieces<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let to = match to {
            SeekFrom::Start(to) => Some(to),
            SeekFrom::End(by) => self.length().checked_add_signed(by),
            SeekFrom::Current(by) => self.position().checked_add_signed(by),
        };
        let to = to.ok_or_else(|| io::Error::from(io::ErrorKind::InvalidInput))?;
        let mut left = to;
        let mut piece = 0;
        while let Some(length) = self.pieces.get(piece).map(|piece| piece.len() as u64)
            && left >= length
        {
            left -= length;
            piece += 1;
        }
        // Beyond the last piece there is nothing to read, wherever it is.
        self.at = (piece, usize::try_from(left).unwrap_or(usize::MAX));
        Ok(to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_read_as_one_file() {
        let mut pieces: Pieces<'_> = [b"ab".as_slice(), b"", b"cde", b"f"].into_iter().collect();
        let mut all = String::new();
        pieces.read_to_string(&mut all).unwrap();
        assert_eq!(all, "abcdef");
        for (to, rest) in [(SeekFrom::Start(2), "cdef"), (SeekFrom::End(-1), "f"), (SeekFrom::Start(9), "")] {
            pieces.seek(to).unwrap();
            all.clear();
            pieces.read_to_string(&mut all).unwrap();
            assert_eq!(all, rest, "{to:?}");
        }
        pieces.rewind().unwrap();
        pieces.seek(SeekFrom::Current(4)).unwrap();
        assert_eq!((pieces.stream_position().unwrap(), pieces.fill_buf().unwrap()), (4, b"e".as_slice()));
        assert!(pieces.seek(SeekFrom::Current(-5)).is_err());
    }
}
