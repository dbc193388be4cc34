//! Forms of files (multipart/form-data, RFC 7578) that are in memory already: the parts are slices
//! of the body, and nothing is copied.

use axum::body::Bytes;
use memchr::memmem;

/// The most bytes of a part's head.
const MOST_HEAD: usize = 4096;

/// What is wrong with a form.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FormError {
    /// Nothing says where a part ends.
    #[error("the header Content-Type names no boundary: send the form as `curl -F picture=@FILE` does")]
    NoBoundary,
    /// The last part does not end.
    #[error("the form ends within a part: send it again, whole")]
    Cut,
    /// A boundary or a part's head is malformed.
    #[error("part {0} of the form has no head that names it: send the form as `curl -F picture=@FILE` does")]
    Head(usize),
}

/// A file of a form.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// The name that its head gives it.
    pub name: String,
    /// What it holds.
    pub content: Bytes,
}

/// The parts of a form, in their order.
#[derive(Debug)]
pub struct Form {
    /// What stands before each part but the first, and after the last.
    delimiter: Vec<u8>,
    rest: Bytes,
    /// The number of the part that comes next, from 1.
    number: usize,
}

impl Form {
    /// A form of this content type, whose body is there.
    ///
    /// # Errors
    /// [`FormError`], where no part begins.
    pub fn new(content_type: &str, body: Bytes) -> Result<Self, FormError> {
        let mut parameters = parameters(content_type);
        let boundary = parameters.find(|(name, _)| name.eq_ignore_ascii_case("boundary"));
        let (_, boundary) = boundary.ok_or(FormError::NoBoundary)?;
        if boundary.is_empty() || boundary.len() > 70 {
            return Err(FormError::NoBoundary);
        }
        let delimiter = format!("\r\n--{boundary}").into_bytes();
        // The first may stand at the very beginning; what stands before it says nothing.
        let first = match delimiter.get(2..).is_some_and(|start| body.starts_with(start)) {
            true => delimiter.len() - 2,
            false => memmem::find(&body, &delimiter).ok_or(FormError::Cut)? + delimiter.len(),
        };
        Ok(Self { delimiter, rest: body.slice(first..), number: 1 })
    }

    /// The next part, or `None` after the last.
    ///
    /// # Errors
    /// [`FormError`], where the part is malformed or does not end.
    pub fn next_part(&mut self) -> Result<Option<Part>, FormError> {
        let rest = &self.rest;
        if rest.starts_with(b"--") {
            return Ok(None);
        }
        let line = rest.iter().take_while(|byte| matches!(byte, b' ' | b'\t')).count();
        let head = rest.slice(line..);
        if !head.starts_with(b"\r\n") {
            // A line that is not there yet is cut off; another is no boundary's end.
            let is_cut = head.len() < 2 && b"\r\n".starts_with(&head);
            return Err(if is_cut { FormError::Cut } else { FormError::Head(self.number) });
        }
        let bounded = head.get(..MOST_HEAD).unwrap_or(&head);
        let end = memmem::find(bounded, b"\r\n\r\n").ok_or(match bounded.len() < MOST_HEAD {
            true => FormError::Cut,
            false => FormError::Head(self.number),
        })?;
        let name = name(&head.slice(2.min(end)..end)).ok_or(FormError::Head(self.number))?;
        // Two bytes before the content: the delimiter of an empty one begins with them.
        let content = head.slice(end + 2..);
        let length = memmem::find(&content, &self.delimiter).ok_or(FormError::Cut)?;
        self.rest = content.slice(length + self.delimiter.len()..);
        self.number += 1;
        Ok(Some(Part { name, content: content.slice(2.min(length)..length) }))
    }
}

/// The name that a part's head gives it.
fn name(head: &[u8]) -> Option<String> {
    let head = str::from_utf8(head).ok()?;
    let disposition = head.split("\r\n").find_map(|line| {
        let (name, value) = line.split_once(':')?;
        name.trim().eq_ignore_ascii_case("content-disposition").then_some(value)
    })?;
    parameters(disposition).find(|(name, _)| name.eq_ignore_ascii_case("name")).map(|(_, value)| value)
}

/// The parameters after a header's value, `; NAME=VALUE` or `; NAME="VALUE"`.
fn parameters(text: &str) -> impl Iterator<Item = (&str, String)> {
    let mut rest = text.split_once(';').map_or("", |(_, rest)| rest);
    std::iter::from_fn(move || {
        let (name, value) = rest.split_once('=')?;
        let value = value.trim_start();
        let (value, after) = match value.strip_prefix('"') {
            Some(quoted) => unquoted(quoted)?,
            None => match value.split_once(';') {
                Some((value, after)) => (value.trim().to_owned(), after),
                None => (value.trim().to_owned(), ""),
            },
        };
        rest = after;
        Some((name.trim(), value))
    })
}

/// What stands before the closing quote, and what comes after the semicolon behind it.
fn unquoted(text: &str) -> Option<(String, &str)> {
    let mut value = String::new();
    let mut letters = text.char_indices();
    loop {
        match letters.next()? {
            (_, '\\') => value.push(letters.next()?.1),
            (at, '"') => {
                let after = text.get(at + 1..)?;
                return Some((value, after.split_once(';').map_or("", |(_, after)| after)));
            }
            (_, letter) => value.push(letter),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn parts(kind: &str, body: &[u8]) -> Result<Vec<(String, Vec<u8>)>, FormError> {
        let mut form = Form::new(kind, Bytes::copy_from_slice(body))?;
        let mut parts = Vec::new();
        while let Some(part) = form.next_part()? {
            parts.push((part.name, part.content.to_vec()));
        }
        Ok(parts)
    }

    const KIND: &str = "multipart/form-data; boundary=x1x";

    #[test]
    fn forms_are_read_as_programs_send_them() {
        let body = b"a preamble\r\n--x1x \r\nContent-Disposition: form-data; filename=\"a;b\\\".png\"; name=\"mask\"\r\nContent-Type: image/png\r\n\r\n\r\n--x1\r\n--x1x\r\ncontent-disposition:form-data;name=picture\r\n\r\n\r\n--x1x--\r\nan epilogue";
        let expected = vec![("mask".into(), b"\r\n--x1".to_vec()), ("picture".into(), Vec::new())];
        assert_eq!(parts(KIND, body), Ok(expected.clone()));
        assert_eq!(parts("multipart/form-data; charset=x; Boundary=\"x1x\"", body), Ok(expected));
        assert_eq!(parts(KIND, b"--x1x--"), Ok(Vec::new()));
    }

    #[test]
    fn what_is_no_form_is_refused() {
        let head = "--x1x\r\nContent-Disposition: form-data; name=\"a\"\r\n\r\n";
        for (body, error) in [
            ("", FormError::Cut),
            ("x1x", FormError::Cut),
            ("--x1x", FormError::Cut),
            ("--x1x\r\n", FormError::Cut),
            (head, FormError::Cut),
            (&format!("{head}content\r\n--x1"), FormError::Cut),
            (&format!("{head}content\r\n--x1x"), FormError::Cut),
            ("--x1xyz\r\n", FormError::Head(1)),
            ("--x1x\r\n\r\n\r\n--x1x--", FormError::Head(1)),
            (
                &format!("{head}content\r\n--x1x\r\nContent-Disposition: form-data\r\n\r\n"),
                FormError::Head(2),
            ),
            (&format!("--x1x\r\n{}", "x".repeat(5000)), FormError::Head(1)),
        ] {
            assert_eq!(parts(KIND, body.as_bytes()), Err(error), "{body}");
        }
        for kind in
            ["multipart/form-data", "multipart/form-data; boundary=", "multipart/form-data; boundary=\"x"]
        {
            assert_eq!(parts(kind, b"--x1x--"), Err(FormError::NoBoundary), "{kind}");
        }
    }

    proptest! {
        #[test]
        fn any_content_survives(contents in proptest::collection::vec(proptest::collection::vec(any::<u8>(), 0..64), 0..5)) {
            let mut body = Vec::new();
            let boundary = "grasp-0123456789";
            for content in &contents {
                body.extend(format!("--{boundary}\r\nContent-Disposition: form-data; name=\"n\"\r\n\r\n").bytes());
                body.extend(content);
                body.extend(b"\r\n");
            }
            body.extend(format!("--{boundary}--").bytes());
            let found = parts(&format!("multipart/form-data; boundary={boundary}"), &body).unwrap();
            prop_assert_eq!(found.into_iter().map(|(_, content)| content).collect::<Vec<_>>(), contents);
        }

        #[test]
        fn no_body_panics(body in proptest::collection::vec(proptest::sample::select(b"-x1\r\n;=\":an e".to_vec()), 0..200)) {
            let _ = parts(KIND, &body);
            let _ = parts(KIND, &[b"--x1x\r\nContent-Disposition: x; name=a\r\n\r\n".as_slice(), &body].concat());
        }
    }
}
