//! The header `Accept`: which media types a client takes, and which it prefers (RFC 9110, 12.5.1).

use super::format::Format;

/// The format that is wanted most: of the greatest weight; of several, the one that is named most
/// exactly, and then first. A record where the header is empty; `None` where it takes none of the
/// formats.
pub(crate) fn wanted(accept: &str) -> Option<Format> {
    if accept.trim().is_empty() {
        return Some(Format::Json);
    }
    let ranges: Vec<Range<'_>> = split(accept, ',').filter_map(Range::read).collect();
    let weighed = Format::ALL.into_iter().filter_map(|format| {
        // What is said of a type itself counts for more than what is said of all of its kind.
        let of_format = ranges.iter().enumerate().filter_map(|(at, range)| {
            let exactness = range.matches(format.media_type())?;
            Some((exactness, std::cmp::Reverse(at), range.weight))
        });
        let (exactness, place, weight) = of_format.max_by_key(|&(exactness, at, _)| (exactness, at))?;
        (weight > 0).then_some(((weight, exactness, place), format))
    });
    let best = weighed.reduce(|best, next| if next.0 > best.0 { next } else { best });
    best.map(|(_, format)| format)
}

/// How exactly a range names a media type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Exactness {
    /// `*/*`.
    Any,
    /// `image/*`.
    Kind,
    /// `image/png`.
    Type,
}

/// A range of media types, and how much it is wanted.
#[derive(Debug)]
struct Range<'a> {
    kind: &'a str,
    subtype: &'a str,
    /// In thousandths, which is as fine as HTTP has it.
    weight: u16,
}

impl<'a> Range<'a> {
    /// `None` where it is none, which is as if it were not there. Parameters but the weight say
    /// nothing of the formats.
    fn read(text: &'a str) -> Option<Self> {
        let mut parts = split(text, ';').map(str::trim);
        let (kind, subtype) = parts.next()?.split_once('/')?;
        let is_range = subtype == "*" || kind != "*";
        let mut parameters = parts.filter_map(|parameter| parameter.split_once('='));
        let weight = match parameters.find(|(name, _)| name.trim().eq_ignore_ascii_case("q")) {
            Some((_, weight)) => self::weight(weight.trim())?,
            None => 1000,
        };
        is_range.then_some(Self { kind, subtype, weight })
    }

    fn matches(&self, media_type: &str) -> Option<Exactness> {
        let (kind, subtype) = media_type.split_once('/')?;
        if self.kind == "*" {
            return Some(Exactness::Any);
        }
        match self.kind.eq_ignore_ascii_case(kind) {
            true if self.subtype == "*" => Some(Exactness::Kind),
            true if self.subtype.eq_ignore_ascii_case(subtype) => Some(Exactness::Type),
            _ => None,
        }
    }
}

/// A weight in thousandths.
fn weight(text: &str) -> Option<u16> {
    let weight: f32 = text.parse().ok()?;
    (0.0..=1.0).contains(&weight).then(|| (1000.0 * weight).round() as u16)
}

/// The pieces between separators that are not within quotes.
fn split(text: &str, separator: char) -> impl Iterator<Item = &str> {
    let (mut is_quoted, mut is_escaped) = (false, false);
    text.split(move |letter| {
        match letter {
            _ if is_escaped => is_escaped = false,
            '\\' if is_quoted => is_escaped = true,
            '"' => is_quoted = !is_quoted,
            _ => {}
        }
        letter == separator && !is_quoted
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_format_is_the_one_that_is_wanted_most() {
        for (accept, format) in [
            ("", Format::Json),
            (" ", Format::Json),
            ("*/*", Format::Json),
            ("application/*", Format::Json),
            ("text/*", Format::Text),
            ("image/*", Format::Drawing),
            ("text/plain", Format::Text),
            ("TEXT/Plain; charset=utf-8", Format::Text),
            ("text/plain ;q=0.5, image/png;q=0.9", Format::Drawing),
            ("text/plain;q=0.5, image/png;Q=0.25", Format::Text),
            ("image/jpeg, application/yaml", Format::Moveit),
            // Of equal weight: the most exact, then the first.
            ("text/plain, application/json", Format::Text),
            ("*/*, image/*, text/plain", Format::Text),
            ("image/avif,image/webp,image/apng,image/*,*/*;q=0.8", Format::Drawing),
            ("text/html,application/xhtml+xml,application/xml;q=0.9,*/*;q=0.8", Format::Json),
            // The most exact says how much a type is wanted, whatever stands where.
            ("text/*, text/plain;q=0.1, image/png;q=0.2", Format::Drawing),
            ("application/json;q=0, */*;q=0.1", Format::Text),
            // What is no range is not there.
            ("json, text/plain;q=2, image/png", Format::Drawing),
            ("text/x;a=\"1, image/png\", application/yaml", Format::Moveit),
            ("text/x;a=\"\\\", image/png\", application/json", Format::Json),
        ] {
            assert_eq!(wanted(accept), Some(format), "{accept}");
        }
        for accept in ["image/jpeg", "json", "*/png", "application/json;q=0", "*/*;q=0", "text/plain;q=0.000"]
        {
            assert_eq!(wanted(accept), None, "{accept}");
        }
    }

    proptest! {
        #[test]
        fn no_header_panics(accept in "[a-z*/;,=\"\\\\ .0-9]{0,60}") {
            let _ = wanted(&accept);
        }
    }
}
