//! What of a WebP its pixels follow from.

use crate::DecodeError;
use crate::pieces::Pieces;

/// `RIFF`, the length, `WEBP`.
const HEADER: usize = 12;
/// The type and the length of a chunk.
const CHUNK_HEADER: usize = 8;
/// What an animation's frame has before its own chunks.
const FRAME_HEADER: usize = 16;

/// The lossy picture in a WebP, the first where it is animated, as a file of its own; and the EXIF
/// data.
///
/// Lossless pictures and compressed transparency are refused, because their decoder cannot be
/// bounded.
pub(crate) fn essence(bytes: &[u8]) -> Result<(Pieces<'_>, Option<&[u8]>), DecodeError> {
    let mut lossy = None;
    let mut exif = None;
    let mut at = HEADER;
    while let Some(&[ref kind @ .., a, b, c, d]) = bytes.get(at..at + CHUNK_HEADER) {
        let length = u32::from_le_bytes([a, b, c, d]) as usize;
        let end = at.saturating_add(length).saturating_add(CHUNK_HEADER);
        match kind {
            b"VP8L" | b"ALPH" if lossy.is_none() => {
                return Err(DecodeError::Unsupported {
                    what: "a WebP picture that is lossless or transparent",
                });
            }
            b"ANMF" if lossy.is_none() => {
                at += CHUNK_HEADER + FRAME_HEADER;
                continue;
            }
            b"VP8 " if lossy.is_none() => lossy = bytes.get(at..end.min(bytes.len())),
            b"EXIF" if exif.is_none() => {
                // Some writers put JPEG's name for it in front.
                exif = bytes
                    .get(at + CHUNK_HEADER..end)
                    .map(|exif| exif.strip_prefix(b"Exif\0\0").unwrap_or(exif));
            }
            _ => {}
        }
        // Chunks begin at even places.
        at = end.saturating_add(length & 1);
    }
    let lossy = lossy.ok_or(DecodeError::Truncated)?;
    Ok(([bytes.get(..HEADER).unwrap_or_default(), lossy].into_iter().collect(), exif))
}
