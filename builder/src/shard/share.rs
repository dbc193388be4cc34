//! Which part of how many.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// How the names of parts end.
pub(crate) const EXTENSION: &str = "shard";
/// More parts than that are a slip of the keyboard.
const MOST: u32 = 1_000_000;

/// Part `shard` (from 1) of `of`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// Which part, from 1.
    pub shard: u32,
    /// Of how many.
    pub of: u32,
}

impl Share {
    /// Part `shard` of `of`; `None` where there can be no such part.
    pub(crate) fn new(shard: u32, of: u32) -> Option<Self> {
        ((1..=of).contains(&shard) && of <= MOST).then_some(Self { shard, of })
    }

    /// Which of `pieces` are this part's. The parts of all shards are all pieces, in order.
    #[must_use]
    pub fn of_pieces(self, pieces: usize) -> Range<usize> {
        let end = |shard: u32| (u128::from(shard) * pieces as u128 / u128::from(self.of.max(1))) as usize;
        end(self.shard.saturating_sub(1))..end(self.shard)
    }

    /// The name of the part's file.
    #[must_use]
    pub fn file_name(self) -> String {
        let width = self.of.to_string().len();
        format!("{:0width$}-of-{}.{EXTENSION}", self.shard, self.of)
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.shard, self.of)
    }
}

/// A text that names no part.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` does not name a part: write I/N, e.g. 3/12, with I from 1 to N and N at most {MOST}")]
pub struct NotAShare(String);

impl FromStr for Share {
    type Err = NotAShare;

    fn from_str(text: &str) -> Result<Self, NotAShare> {
        let parsed = || {
            let (shard, of) = text.split_once('/')?;
            Self::new(shard.parse().ok()?, of.parse().ok()?)
        };
        parsed().ok_or_else(|| NotAShare(text.to_owned()))
    }
}
