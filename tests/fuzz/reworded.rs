//! Sound texts that are changed a word at a time: of bytes that are changed at random, few are still
//! text that anything reads.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index as Place, select};

/// What stands in few files.
const STRANGE: [&str; 32] = [
    "",
    "0",
    "-0.0",
    "1",
    "-1",
    "1e-320",
    "1e308",
    "-1e308",
    "1e999",
    "nan",
    "NaN",
    "inf",
    "-inf",
    "255",
    "4294967296",
    "9223372036854775808",
    "99999999999999999999999",
    "0x7f",
    "true",
    "null",
    "''",
    "\"",
    "[]",
    "{}",
    "[[",
    "]",
    "=",
    ",",
    "\n",
    "\0",
    "\u{feff}",
    "\u{1f590}",
];
/// What may stand in itself.
const NESTED: [&str; 5] = ["[", "{\"a\":", "<a>", "a.", "(("];

/// How a word is changed.
#[derive(Clone, Debug)]
enum Change {
    /// Another one stands there.
    To(String),
    /// Another one of the text stands there.
    Like(Place),
    /// It stands there so many times.
    Times(usize),
}

/// One of the seeds, with some of its words changed.
pub(super) fn reworded(seeds: &'static [Vec<u8>]) -> impl Strategy<Value = Vec<u8>> {
    let change = prop_oneof![
        3 => select(&STRANGE[..]).prop_map(|word| Change::To(word.into())),
        4 => (-2.0..2.0).prop_map(|number: f64| Change::To(number.to_string())),
        1 => any::<f64>().prop_map(|number| Change::To(number.to_string())),
        2 => any::<Place>().prop_map(Change::Like),
        1 => (2..50usize).prop_map(Change::Times),
        1 => (select(&NESTED[..]), 1..5_000usize).prop_map(|(word, times)| Change::To(word.repeat(times))),
    ];
    let changes = vec((any::<bool>(), any::<Place>(), change), 1..5);
    (any::<Place>(), changes).prop_map(|(seed, changes)| {
        let text = String::from_utf8_lossy(seed.get::<Vec<u8>>(seeds)).into_owned();
        let words = words(&text);
        let numbers: Vec<usize> = (0..words.len()).filter(|at| words[*at].parse::<f64>().is_ok()).collect();
        let mut changed: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
        for (is_number, place, change) in changes {
            // Numbers by themselves: what has another one is read more often than not.
            let at = if is_number { *place.get(&numbers) } else { place.index(words.len()) };
            changed[at] = match change {
                Change::To(word) => word,
                Change::Like(other) => (*other.get(&words)).to_owned(),
                Change::Times(times) => words[at].repeat(times),
            };
        }
        changed.concat().into_bytes()
    })
}

/// The parts of a text: words and numbers, and each sign by itself.
fn words(text: &str) -> Vec<&str> {
    let is_word = |c: char| c.is_alphanumeric() || matches!(c, '.' | '-' | '+' | '_');
    let (mut words, mut rest) = (Vec::new(), text);
    while let Some(first) = rest.chars().next() {
        let end = match is_word(first) {
            true => rest.find(|c| !is_word(c)).unwrap_or(rest.len()),
            false => first.len_utf8(),
        };
        let (word, behind) = rest.split_at(end);
        words.push(word);
        rest = behind;
    }
    words
}
