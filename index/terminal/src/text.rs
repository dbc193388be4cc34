//! Numbers and names in sentences.

use std::borrow::Cow;
use std::path::Path;
use std::time::Duration;

use indicatif::HumanCount;

/// A number of things: `1 picture`, `5,396 pictures`. `names` are the singular and the plural.
pub fn counted(count: impl TryInto<u64>, names: [&str; 2]) -> String {
    // What does not fit into 64 bits is not a count of anything that a program holds.
    let count = count.try_into().unwrap_or(u64::MAX);
    let [one, several] = names;
    format!("{} {}", HumanCount(count), if count == 1 { one } else { several })
}

/// A share from 0 to 1 in percent, with more decimals the smaller it is: `62 %`, `1.5 %`, `0.03 %`.
/// `0 %` is written for nothing at all, and `100 %` for everything.
pub fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent {
        _ if percent <= 0.0 => "0 %".to_owned(),
        _ if percent < 0.001 => "under 0.001 %".to_owned(),
        // The limits are those at which rounding adds a digit.
        _ if percent < 0.00995 => format!("{percent:.3} %"),
        _ if percent < 0.995 => format!("{percent:.2} %"),
        _ if percent < 9.95 => format!("{percent:.1} %"),
        // All but a little is not all.
        _ if (99.5..100.0).contains(&percent) => "over 99 %".to_owned(),
        _ => format!("{percent:.0} %"),
    }
}

/// A number with `decimals` decimals, where what rounds to nothing has no sign.
pub fn fixed(number: f64, decimals: usize) -> String {
    let text = format!("{number:.decimals$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.bytes().all(|byte| matches!(byte, b'0' | b'.')) => zero.to_owned(),
        _ => text,
    }
}

/// A span of time to the precision that matters to who waits: `7 s`, `4 min`, `2 h 10 min`.
pub fn duration(span: Duration) -> String {
    let seconds = span.as_secs_f64().round() as u64;
    let minutes = (span.as_secs_f64() / 60.0).round() as u64;
    match seconds {
        0..100 => format!("{seconds} s"),
        100..6000 => format!("{minutes} min"),
        _ if minutes < 48 * 60 => format!("{} h {} min", minutes / 60, minutes % 60),
        _ => format!("{} days", (minutes + 12 * 60) / (24 * 60)),
    }
}

/// Several lines of text, each [`printable`].
pub fn printable_lines(text: &str) -> String {
    text.split('\n').map(printable).collect::<Vec<_>>().join("\n")
}

/// The name of a file, [`printable`].
pub fn shown(path: &Path) -> String {
    printable(&path.display().to_string()).into_owned()
}

/// Text from input, such as the name of a file, with control characters escaped: a terminal would
/// obey them.
///
/// So are the characters that change the direction of what follows, which make a name look like
/// another.
pub fn printable(text: &str) -> Cow<'_, str> {
    let is_unsafe = |c: char| {
        c.is_control()
            || matches!(c, '\u{061c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if !text.contains(is_unsafe) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        if is_unsafe(c) { escaped.extend(c.escape_default()) } else { escaped.push(c) }
    }
    Cow::Owned(escaped)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_singular_and_thousands_are_grouped() {
        let pictures = ["picture", "pictures"];
        assert_eq!(
            [0, 1, 5396].map(|n: u64| counted(n, pictures)),
            ["0 pictures", "1 picture", "5,396 pictures"]
        );
    }

    #[test]
    fn percent_is_never_nothing_for_something_nor_all_for_less() {
        let shares = [0.0, 1e-9, 0.00003, 0.0003, 0.003, 0.0151, 0.0996, 0.62, 0.997, 1.0];
        let texts = [
            "0 %",
            "under 0.001 %",
            "0.003 %",
            "0.03 %",
            "0.30 %",
            "1.5 %",
            "10 %",
            "62 %",
            "over 99 %",
            "100 %",
        ];
        assert_eq!(shares.map(percent), texts);
    }

    #[test]
    fn what_rounds_to_nothing_has_no_sign() {
        assert_eq!(
            [fixed(-0.2, 0), fixed(-0.0, 1), fixed(-0.06, 1), fixed(3.0, 2)],
            ["0", "0.0", "-0.1", "3.00"]
        );
    }

    #[test]
    fn a_wait_is_written_as_it_is_said() {
        let spans = [7, 99, 100, 3600, 7800, 200_000].map(|seconds| duration(Duration::from_secs(seconds)));
        assert_eq!(spans, ["7 s", "99 s", "2 min", "60 min", "2 h 10 min", "2 days"]);
    }

    #[test]
    fn control_characters_are_escaped_and_letters_are_not() {
        assert!(matches!(printable("Tür-手.png"), Cow::Borrowed(_)));
        assert_eq!(
            printable("a\u{1b}]0;x\u{7}\r\n\u{9b}\u{202e}gnp"),
            "a\\u{1b}]0;x\\u{7}\\r\\n\\u{9b}\\u{202e}gnp"
        );
    }
}
