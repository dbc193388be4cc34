//! What is wrong with a text before it is parsed as XML.
//!
//! The parser of URDFs calls itself for elements in elements, copies all namespaces for each
//! element, and panics where the prefix `xmlns` is taken for another one. So the text's markup is
//! walked first, by the parser's own rules: what it would reject ends the walk, because it reads no
//! further either.

use crate::UrdfFault;

/// No gripper's URDF is longer, in bytes: meshes are not in it.
const LONGEST: usize = 4_000_000;
/// No URDF has elements in elements so deep.
const DEEPEST: usize = 100;
/// Twice as many as the largest hand's links and joints have.
const MOST_ELEMENTS: usize = 50_000;
/// Names and values of all namespaces, and of attributes with a prefix, together, in bytes: several
/// times as long as those of URDFs that were made for a simulator.
const MOST_NAMESPACES: usize = 2_000;

/// What the parser cannot be given, if anything.
pub(super) fn fault(text: &str) -> Option<UrdfFault> {
    if text.len() > LONGEST {
        return Some(UrdfFault::TooLong { most: LONGEST });
    }
    let mut walk = Walk { rest: text, depth: 0, elements: 0, namespaces: 0 };
    while let Some(step) = walk.next() {
        if step.is_err() {
            return step.err();
        }
        if walk.depth > DEEPEST {
            return Some(UrdfFault::TooDeep { most: DEEPEST });
        }
        if walk.elements > MOST_ELEMENTS {
            return Some(UrdfFault::TooManyElements { most: MOST_ELEMENTS });
        }
        if walk.namespaces > MOST_NAMESPACES {
            return Some(UrdfFault::Namespaces);
        }
    }
    None
}

/// A way through the markup of a text, and what has been met on it.
struct Walk<'a> {
    rest: &'a str,
    /// Elements that are open.
    depth: usize,
    elements: usize,
    /// Names and values of namespaces and of attributes with a prefix, in bytes.
    namespaces: usize,
}

impl<'a> Walk<'a> {
    /// Goes behind the next markup; `None` where nothing more can be read.
    fn next(&mut self) -> Option<Result<(), UrdfFault>> {
        let (_, markup) = self.rest.split_once('<')?;
        self.rest = markup;
        if markup.starts_with("!--") {
            self.skip(3)?;
            self.behind("-->")?;
        } else if markup.starts_with("![") {
            return Some(Err(UrdfFault::CharacterData));
        } else if markup.starts_with('!') {
            self.behind(">")?;
        } else if markup.starts_with('?') {
            self.skip(1)?;
            // The parser ends it at the first `>` behind any `?`.
            self.behind("?")?;
            self.behind(">")?;
        } else if markup.starts_with('/') {
            self.depth = self.depth.saturating_sub(1);
            self.behind(">")?;
        } else {
            return self.element();
        }
        Some(Ok(()))
    }

    /// Goes behind the tag that begins an element.
    fn element(&mut self) -> Option<Result<(), UrdfFault>> {
        self.elements += 1;
        // A name has at least one character, whichever that is.
        self.skip(self.rest.chars().next()?.len_utf8())?;
        let end = self.rest.find(|c| is_space(c) || c == '/' || c == '>')?;
        self.skip(end)?;
        loop {
            self.rest = self.rest.trim_start_matches(is_space);
            if self.rest.starts_with('/') {
                return self.behind("/>").map(Ok);
            }
            if self.rest.starts_with('>') {
                self.depth += 1;
                return self.behind(">").map(Ok);
            }
            let (name, value) = self.attribute()?;
            let name = name.trim_end_matches(is_space);
            if name == "xmlns:xmlns" {
                return Some(Err(UrdfFault::Namespaces));
            }
            // A prefix may stand for that of namespaces.
            if name.starts_with("xmlns") || name.contains(':') {
                self.namespaces += name.len() + value.len();
            }
        }
    }

    /// Goes behind an attribute, of which these are name and value.
    fn attribute(&mut self) -> Option<(&'a str, &'a str)> {
        let (name, rest) = self.rest.split_once('=')?;
        let rest = rest.trim_start_matches(is_space);
        let quote = rest.chars().next().filter(|quote| matches!(quote, '"' | '\''))?;
        let (value, rest) = rest.get(1..)?.split_once(quote)?;
        self.rest = rest;
        Some((name, value))
    }

    fn skip(&mut self, bytes: usize) -> Option<()> {
        self.rest = self.rest.get(bytes..)?;
        Some(())
    }

    fn behind(&mut self, end: &str) -> Option<()> {
        self.rest = self.rest.split_once(end)?.1;
        Some(())
    }
}

/// White space as XML has it, which is less than Unicode's.
fn is_space(c: char) -> bool {
    matches!(c, ' ' | '\t' | '\r' | '\n')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_only_looks_like_the_end_of_an_element_is_none() {
        let robot = |element: &str| format!("<robot>{}", element.repeat(DEEPEST));
        for element in [
            "<a>",
            "<a><!--</b>-->",
            "<a><?p</b?>",
            "<a><?p ? </b>",
            "<a x='</b>'>",
            "<a x=\"'>\" y = '/></b>' >",
            "<a'>",
            "<>>",
        ] {
            assert_eq!(fault(&robot(element)), Some(UrdfFault::TooDeep { most: DEEPEST }), "{element}");
        }
        for element in ["<a/>", "<a></a>", "<a b='>' c=\"/\" />", "<!-- <a> -->", "<?p <a>?>", "<a\n></a\n>"]
        {
            assert_eq!(fault(&robot(element)), None, "{element}");
        }
    }

    #[test]
    fn what_costs_too_much_is_refused() {
        let elements = "<a/>".repeat(MOST_ELEMENTS + 1);
        assert_eq!(fault(&elements), Some(UrdfFault::TooManyElements { most: MOST_ELEMENTS }));
        assert_eq!(fault(&" ".repeat(LONGEST + 1)), Some(UrdfFault::TooLong { most: LONGEST }));
        let declared =
            |count| format!("<a{}/>", " xmlns:simulator='http://example.org/simulator'".repeat(count));
        assert_eq!(fault(&declared(10)), None);
        assert_eq!(fault(&declared(100)), Some(UrdfFault::Namespaces));
        assert_eq!(fault("<a xmlns:xmlns ='b'/>"), Some(UrdfFault::Namespaces));
        let prefixed: String = (0..500).map(|number| format!(" p:a{number}='u'")).collect();
        let bound = format!("<a xmlns:p='http://www.w3.org/2000/xmlns/'{prefixed}/>");
        assert_eq!(fault(&bound), Some(UrdfFault::Namespaces));
        assert_eq!(fault("<a><![CDATA[b]]></a>"), Some(UrdfFault::CharacterData));
    }
}
