//! What a message repeats of a request.

/// The most letters of a value that a message repeats.
const MOST_SHOWN: usize = 40;

/// A value of the asker, short and on one line.
pub(super) fn shown(value: &str) -> String {
    let mut letters = value.chars();
    let start: String = letters.by_ref().take(MOST_SHOWN).flat_map(char::escape_debug).collect();
    let rest = if letters.next().is_some() { ".." } else { "" };
    format!("`{start}{rest}`")
}
