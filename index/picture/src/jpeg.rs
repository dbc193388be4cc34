//! What of a JPEG its pixels follow from, how often it goes over them, and how much of it is
//! missing.

use image::DynamicImage;

use crate::limits::MAX_SCANS;
use crate::pieces::Pieces;
use crate::{DecodeError, DecodeWarning};

/// The most rows, in percent, that a JPEG without its end marker may lack to be decoded with a
/// warning. Cameras and cut connections lose the marker, or the last rows; a picture that lacks
/// more is reported as truncated.
pub const MAX_MISSING_PERCENT: u32 = 25;

/// The most bytes of what stands between scans: twice four quantization tables of 16 bits and eight
/// Huffman tables of 256 codes before each. A decoder expands each table, so many of them cost time
/// whatever the pixels.
const MAX_TABLE_BYTES: usize = 2 * MAX_SCANS * (4 * 129 + 8 * 273);

/// What a decoder needs of a JPEG.
#[derive(Debug)]
pub(crate) struct Essence<'a> {
    pub(crate) pieces: Pieces<'a>,
    /// The EXIF data, from its byte order on.
    pub(crate) exif: Option<&'a [u8]>,
    /// Whether the end marker is missing.
    pub(crate) is_cut: bool,
}

/// The segments that pixels follow from. Skipped are the application's own (colour profiles,
/// thumbnails, text, which decoders copy), comments, and what follows the end marker.
pub(crate) fn essence(bytes: &[u8]) -> Result<Essence<'_>, DecodeError> {
    let mut pieces = Pieces::default();
    let mut exif = None;
    let (mut scans, mut table_bytes) = (0, 0);
    let mut has_codes = false;
    pieces.push(bytes.get(..2).unwrap_or_default());
    for segment in Segments::of(bytes) {
        let Segment { marker, data, whole } = segment;
        match marker {
            EOI => {
                pieces.push(whole);
                return Ok(Essence { pieces, exif, is_cut: false });
            }
            SOS => {
                scans += 1;
                if scans > MAX_SCANS {
                    return Err(DecodeError::TooManyScans);
                }
                if !has_codes {
                    pieces.push(USUAL_CODES);
                    has_codes = true;
                }
            }
            APP1 if exif.is_none() => {
                exif = data.strip_prefix(b"Exif\0\0");
                continue;
            }
            SOF0..=SOF15 | DQT..=DRI => {
                has_codes |= marker == DHT;
                table_bytes += whole.len();
            }
            // How colours are stored, and that the usual Huffman tables are left out.
            APP14 if data.starts_with(b"Adobe") => table_bytes += whole.len(),
            APP0 if data.starts_with(b"AVI1") => table_bytes += whole.len(),
            _ => continue,
        }
        if table_bytes > MAX_TABLE_BYTES {
            return Err(DecodeError::TooManyTables);
        }
        pieces.push(whole);
    }
    Ok(Essence { pieces, exif, is_cut: true })
}

/// How much is missing of a JPEG without its end marker, which the decoder has filled with grey.
///
/// # Errors
/// [`DecodeError::Truncated`] where more than [`MAX_MISSING_PERCENT`] of the rows are.
pub(crate) fn missing(image: &DynamicImage) -> Result<DecodeWarning, DecodeError> {
    /// The value of each channel where nothing was decoded.
    const NOTHING: u8 = 128;
    let height = image.height() as usize;
    let row = image.as_bytes().len() / height.max(1);
    let rows = image.as_bytes().rchunks_exact(row.max(1));
    let missing = rows.take_while(|row| row.iter().all(|&value| value == NOTHING)).count();
    let missing_percent = (100 * missing).div_ceil(height.max(1)) as u32;
    match missing_percent {
        0..=MAX_MISSING_PERCENT => Ok(DecodeWarning::NoEndMarker { missing_percent }),
        _ => Err(DecodeError::Truncated),
    }
}

/// What says to a decoder that the usual Huffman tables are left out, as in Motion JPEG: many
/// cameras leave them out, and not all say so.
const USUAL_CODES: &[u8] = b"\xFF\xE0\x00\x07AVI1\0";

/// The first and the last of the frame headers, between which the Huffman tables lie.
const SOF0: u8 = 0xC0;
const SOF15: u8 = 0xCF;
/// Huffman tables.
const DHT: u8 = 0xC4;
const SOI: u8 = 0xD8;
const EOI: u8 = 0xD9;
const SOS: u8 = 0xDA;
/// Quantization tables; the number of lines and the restart interval follow.
const DQT: u8 = 0xDB;
const DRI: u8 = 0xDD;
const APP0: u8 = 0xE0;
const APP1: u8 = 0xE1;
const APP14: u8 = 0xEE;

/// A marker and what belongs to it.
#[derive(Debug)]
struct Segment<'a> {
    marker: u8,
    /// What follows its length.
    data: &'a [u8],
    /// Marker, length and data, and a scan's entropy-coded data.
    whole: &'a [u8],
}

/// The segments of a JPEG behind its start marker, up to its end marker, another picture's start,
/// or a segment that is cut.
#[derive(Debug)]
struct Segments<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Segments<'a> {
    fn of(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 2 }
    }
}

impl<'a> Iterator for Segments<'a> {
    type Item = Segment<'a>;

    fn next(&mut self) -> Option<Segment<'a>> {
        loop {
            let (start, marker) = next_marker(self.bytes, self.at)?;
            match marker {
                // Nothing belongs to these.
                0x00 | 0x01 | 0xD0..=0xD7 => self.at = start + 2,
                SOI => return None,
                EOI => {
                    self.at = self.bytes.len();
                    return Some(Segment { marker, data: &[], whole: self.bytes.get(start..start + 2)? });
                }
                _ => {
                    let &[high, low] = self.bytes.get(start + 2..start + 4)? else { return None };
                    let length = usize::from(u16::from_be_bytes([high, low]));
                    let data = self.bytes.get(start + 4..start + 2 + length)?;
                    self.at = start + 2 + length;
                    if marker == SOS {
                        self.at = end_of_scan(self.bytes, self.at).unwrap_or(self.bytes.len());
                    }
                    return Some(Segment { marker, data, whole: self.bytes.get(start..self.at)? });
                }
            }
        }
    }
}

/// The place and the code of the next marker at or behind `at`, whatever stands before it.
fn next_marker(bytes: &[u8], mut at: usize) -> Option<(usize, u8)> {
    loop {
        at += bytes.get(at..)?.iter().position(|&byte| byte == 0xFF)?;
        match bytes.get(at + 1)? {
            0xFF => at += 1,
            &code => return Some((at, code)),
        }
    }
}

/// The place of the marker that ends a scan's entropy-coded data from `at` on: neither a stuffed
/// byte (FF 00) nor a restart.
fn end_of_scan(bytes: &[u8], mut at: usize) -> Option<usize> {
    loop {
        match next_marker(bytes, at)? {
            (place, 0x00 | 0xD0..=0xD7) => at = place + 2,
            (place, _) => return Some(place),
        }
    }
}

/// Where a JPEG ends in a stream. It remembers where it stopped, so that each byte is looked at
/// once.
#[derive(Debug, Default)]
pub(crate) struct EndScan {
    at: usize,
}

impl EndScan {
    /// The end of the JPEG that `bytes` begins with: behind its end marker, or where the next one
    /// begins. `None` where more bytes are needed.
    pub(crate) fn end(&mut self, bytes: &[u8]) -> Option<usize> {
        self.at = self.at.max(2);
        loop {
            let Some((place, marker)) = next_marker(bytes, self.at) else {
                // A lone FF at the end may be half a marker.
                let half = usize::from(bytes.last() == Some(&0xFF));
                self.at = self.at.max(bytes.len().saturating_sub(half));
                return None;
            };
            self.at = place;
            match marker {
                EOI => return Some(place + 2),
                // The next frame: this one was cut short, and decoding reports it.
                SOI => return Some(place),
                0x00 | 0x01 | 0xD0..=0xD7 => self.at = place + 2,
                _ => {
                    let &[high, low] = bytes.get(place + 2..place + 4)? else { return None };
                    self.at = place + 2 + usize::from(u16::from_be_bytes([high, low])).max(2);
                }
            }
        }
    }
}
