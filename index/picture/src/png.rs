//! What of a PNG its pixels follow from.

use crate::pieces::Pieces;

/// The bytes before the first chunk.
pub(crate) const SIGNATURE: &[u8; 8] = b"\x89PNG\r\n\x1a\n";
/// What a chunk has besides its data: length, type and checksum, four bytes each.
pub(crate) const CHUNK_OVERHEAD: usize = 12;

/// Width and height, as the header chunk says, which comes first.
pub(crate) fn size(bytes: &[u8]) -> Option<(u32, u32)> {
    let &[a, b, c, d, e, f, g, h] = bytes.get(16..24)? else { return None };
    Some((u32::from_be_bytes([a, b, c, d]), u32::from_be_bytes([e, f, g, h])))
}

/// The chunks that pixels follow from, and the EXIF data.
///
/// Skipped are colour profiles and compressed text, which inflate a thousandfold, the later frames
/// of an animation, and whatever else a file may carry beside its pixels. A chunk that a decoder
/// must understand is left for it to refuse.
pub(crate) fn essence(bytes: &[u8]) -> (Pieces<'_>, Option<&[u8]>) {
    let mut exif = None;
    let mut pieces = Pieces::default();
    let mut kept_from = 0;
    let mut at = SIGNATURE.len();
    while let Some(&[a, b, c, d, ref kind @ ..]) = bytes.get(at..at + 8) {
        let length = u32::from_be_bytes([a, b, c, d]) as usize;
        let end = at.saturating_add(length).saturating_add(CHUNK_OVERHEAD);
        let is_critical = kind.first().is_some_and(u8::is_ascii_uppercase);
        if !is_critical && kind != b"tRNS" {
            pieces.push(bytes.get(kept_from..at).unwrap_or_default());
            kept_from = end;
            if kind == b"eXIf" && exif.is_none() {
                exif = bytes.get(at + 8..at + 8 + length);
            }
        }
        at = end;
        if kind == b"IEND" {
            break;
        }
    }
    pieces.push(bytes.get(kept_from..at.min(bytes.len())).unwrap_or_default());
    (pieces, exif)
}
