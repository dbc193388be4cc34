//! The headers between the pictures of an HTTP `multipart/x-mixed-replace` response, as network
//! cameras send it.
//!
//! Each part is a boundary line, header lines and an empty line, then the picture, whose own format
//! says where it ends: a `Content-Length` is left out by some cameras and wrong in others. With
//! `curl -i` the response's own header comes first.

/// The longest header of a part or a response.
const MAX_HEADER: usize = 8192;

/// Whether a part's header stands at the beginning of some bytes.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum PartHeader {
    /// It does, and has so many bytes.
    Whole(usize),
    /// It may; more bytes are needed.
    NeedsMore,
    /// It does not.
    None,
}

/// The header that `bytes` begins with, with the line break that ends the part before.
pub(super) fn header(bytes: &[u8]) -> PartHeader {
    let breaks = bytes.iter().take_while(|&&byte| matches!(byte, b'\r' | b'\n')).count();
    if breaks > MAX_HEADER {
        return PartHeader::None;
    }
    let text = &bytes[breaks..];
    let begins = |with: &[u8]| text.starts_with(with) || with.starts_with(text);
    if !begins(b"--") && !begins(b"HTTP/1.") {
        return PartHeader::None;
    }
    let line_ends = |line: &[u8]| line == b"\n" || line == b"\r\n";
    let mut length = breaks;
    for line in text.split_inclusive(|&byte| byte == b'\n') {
        length += line.len();
        if line_ends(line) {
            return PartHeader::Whole(length);
        }
        if length > MAX_HEADER {
            return PartHeader::None;
        }
    }
    PartHeader::NeedsMore
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_ends_with_an_empty_line() {
        let part = b"\r\n--frame\r\nContent-Type: image/jpeg\r\nContent-Length: 5\r\n\r\n\xFF\xD8";
        assert_eq!(header(part), PartHeader::Whole(part.len() - 2));
        assert_eq!(header(b"HTTP/1.0 200 OK\nServer: camera\n\n--x"), PartHeader::Whole(32));
        for cut in 0..part.len() - 2 {
            assert_eq!(header(&part[..cut]), PartHeader::NeedsMore, "{cut} bytes");
        }
        assert_eq!(header(b"not a picture"), PartHeader::None);
        assert_eq!(header(&[b"--".as_slice(), &[b'-'; MAX_HEADER]].concat()), PartHeader::None);
        assert_eq!(header(&[b'\n'; MAX_HEADER]), PartHeader::NeedsMore);
        assert_eq!(header(&[b'\n'; MAX_HEADER + 1]), PartHeader::None);
    }
}
