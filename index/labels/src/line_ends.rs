//! Tables of any system: `\r\n` and `\r` are read as `\n`, so that lines are counted where they
//! end; and lines that do not end are those of another file, or of a device.

use std::io::{self, BufRead, BufReader, Read};

/// The longest line in bytes: a reader of tables holds each of them.
const LONGEST: usize = 1 << 20;

/// A reader of the same bytes, with each `\r\n`, and each `\r` alone, as `\n`.
#[derive(Debug)]
pub(crate) struct LineEnds<R> {
    inner: BufReader<R>,
    /// The last byte was a `\r`, which has been given as `\n`.
    behind_cr: bool,
    /// The bytes that have been given of a line that has not ended.
    line: usize,
}

impl<R: Read> LineEnds<R> {
    pub(crate) fn new(inner: R) -> Self {
        Self { inner: BufReader::new(inner), behind_cr: false, line: 0 }
    }
}

impl<R: Read> Read for LineEnds<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.line > LONGEST {
            let why = format!("a line has more than {} MiB: is it a table?", LONGEST >> 20);
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, why));
        }
        let mut given = 0;
        while given < into.len() {
            let bytes = self.inner.fill_buf()?;
            let Some(&byte) = bytes.first() else { break };
            let plain = bytes.iter().take(into.len() - given).take_while(|byte| **byte != b'\r').count();
            let ended = std::mem::replace(&mut self.behind_cr, plain == 0);
            if ended && byte == b'\n' {
                self.inner.consume(1);
                continue;
            }
            match plain {
                0 => into[given] = b'\n',
                _ => into[given..given + plain].copy_from_slice(&bytes[..plain]),
            }
            given += plain.max(1);
            self.inner.consume(plain.max(1));
        }
        self.line = match into[..given].iter().rposition(|byte| *byte == b'\n') {
            Some(end) => given - end - 1,
            None => self.line + given,
        };
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

    #[test]
    fn a_line_without_end_is_an_error_and_many_short_ones_are_none() {
        let mut sink = io::sink();
        let error = io::copy(&mut LineEnds::new(io::repeat(0)), &mut sink).unwrap_err();
        assert_eq!(error.to_string(), "a line has more than 1 MiB: is it a table?");
        let lines = "a line\r\n".repeat(1 << 18);
        assert_eq!(io::copy(&mut LineEnds::new(lines.as_bytes()), &mut sink).unwrap(), 7 << 18);
        let lines = "a line\r".repeat(1 << 18);
        assert_eq!(io::copy(&mut LineEnds::new(lines.as_bytes()), &mut sink).unwrap(), 7 << 18);
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
            prop_assert_eq!(String::from_utf8(read).unwrap(), text.replace("\r\n", "\n").replace('\r', "\n"));
        }
    }
}
