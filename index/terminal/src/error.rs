//! An error with its causes as text.

use std::error::Error;

use crate::text::printable_lines;

/// The messages of an error and its causes, outermost first, joined by colons.
///
/// Some errors repeat their cause in their own message (as `{source}`) and others leave it to the
/// reader of the chain; a cause that the text says already is left out. Control characters are
/// escaped, as they can only come from input; ends of lines stay, because some parsers show the
/// place of a mistake in lines of their own.
pub fn message<'e>(chain: impl IntoIterator<Item = &'e (dyn Error + 'static)>) -> String {
    let mut line = String::new();
    for cause in chain {
        let cause = cause.to_string();
        if line.is_empty() {
            line = cause;
        } else if !line.contains(&cause) {
            line = format!("{line}: {cause}");
        }
    }
    printable_lines(&line)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{fmt, io};

    #[derive(Debug)]
    struct Outer(&'static str, io::Error);

    impl fmt::Display for Outer {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str(self.0)
        }
    }

    impl Error for Outer {
        fn source(&self) -> Option<&(dyn Error + 'static)> {
            Some(&self.1)
        }
    }

    fn line(own: &'static str) -> String {
        let outer = Outer(own, io::Error::other("disk full"));
        message([&outer as &(dyn Error + 'static), outer.source().unwrap()])
    }

    #[test]
    fn a_cause_is_written_once() {
        assert_eq!(line("cannot write a.idx"), "cannot write a.idx: disk full");
        assert_eq!(
            line("cannot write a.idx: disk full: free some space"),
            "cannot write a.idx: disk full: free some space"
        );
    }

    #[test]
    fn a_hostile_name_does_not_reach_the_terminal() {
        assert_eq!(line("cannot read \u{1b}[2J\r.png"), "cannot read \\u{1b}[2J\\r.png: disk full");
    }
}
