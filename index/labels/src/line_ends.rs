//! Tables of any system: `\r\n` is read as `\n`, so that lines are counted where they end.

use std::io::{self, BufRead, BufReader, Read};

/// A reader of the same bytes, but for each `\r` that a `\n` follows.
#[derive(Debug)]
pub(crate) struct LineEnds<R> {
    inner: BufReader<R>,
    /// A `\r` has been read and not yet given.
    holds_cr: bool,
}

impl<R: Read> LineEnds<R> {
    pub(crate) fn new(inner: R) -> Self {
        Self { inner: BufReader::new(inner), holds_cr: false }
    }
}

impl<R: Read> Read for LineEnds<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let mut given = 0;
        while given < into.len() {
            let bytes = self.inner.fill_buf()?;
            let Some(&byte) = bytes.first() else {
                // A `\r` at the very end is followed by nothing.
                if std::mem::take(&mut self.holds_cr) {
                    into[given] = b'\r';
                    given += 1;
                }
                break;
            };
            if std::mem::take(&mut self.holds_cr) && byte != b'\n' {
                into[given] = b'\r';
                given += 1;
                continue;
            }
            let plain = bytes.iter().take(into.len() - given).take_while(|byte| **byte != b'\r').count();
            into[given..given + plain].copy_from_slice(&bytes[..plain]);
            given += plain;
            self.holds_cr = plain == 0;
            self.inner.consume(plain.max(1));
        }
        Ok(given)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Gives so many bytes at a time.
    struct Slowly<'a>(&'a [u8], usize);

    impl Read for Slowly<'_> {
        fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
            let most = self.1.min(into.len());
            self.0.read(&mut into[..most])
        }
    }

    proptest! {
        #[test]
        fn it_is_a_replacement(text in "[a\r\n]{0,40}", slow in 1usize..5, room in 1usize..5) {
            let mut reader = LineEnds::new(Slowly(text.as_bytes(), slow));
            let (mut read, mut part) = (Vec::new(), vec![0; room]);
            loop {
                let count = reader.read(&mut part).unwrap();
                if count == 0 {
                    break;
                }
                read.extend_from_slice(&part[..count]);
            }
            prop_assert_eq!(String::from_utf8(read).unwrap(), text.replace("\r\n", "\n"));
        }
    }
}
