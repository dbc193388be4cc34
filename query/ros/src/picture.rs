//! Pixels of the pictures that cameras publish.

use grasp_recognise::picture::{self, Decoded, MAX_PIXELS, Picture};

use crate::messages::sensor::{CompressedImage, Image};

/// Why a picture cannot be read. Its messages say what to publish instead.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub(crate) enum Unreadable {
    /// An encoding of other channels.
    #[error(
        "pictures are encoded as {0:?}: publish rgb8, bgr8, rgba8, bgra8 or mono8, or convert them, e.g. by the camera's \
         driver or image_proc"
    )]
    Encoding(String),
    /// A size without pixels, or beyond all reason.
    #[error(
        "a picture of {width} x {height} pixels: at least one and at most {} megapixels are needed",
        MAX_PIXELS / 1_000_000
    )]
    Size {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Rows that overlap.
    #[error(
        "a row of {width} pixels of {encoding} needs {needed} bytes, but step says {step}: mend the publisher"
    )]
    Step {
        /// Pixels in a row.
        width: u32,
        /// Of the picture.
        encoding: String,
        /// Bytes of a row's pixels.
        needed: usize,
        /// Bytes of a row, as the message says.
        step: u32,
    },
    /// Rows that are missing.
    #[error("{height} rows of {step} bytes are announced, but {found} bytes came: mend the publisher")]
    Short {
        /// Rows.
        height: u32,
        /// Bytes of a row, as the message says.
        step: u32,
        /// Bytes that came.
        found: usize,
    },
    /// A format that is neither of both.
    #[error("compressed pictures of the format {0:?} are neither JPEGs nor PNGs: publish one of these")]
    Format(String),
    /// A picture that cannot be decoded.
    #[error("a compressed picture cannot be read: {0}")]
    Damaged(String),
}

impl Unreadable {
    /// A short, stable name.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Encoding(_) => "encoding",
            Self::Size { .. } => "size",
            Self::Step { .. } => "step",
            Self::Short { .. } => "short",
            Self::Format(_) => "format",
            Self::Damaged(_) => "damaged",
        }
    }
}

/// How many bytes a pixel has, and which of them are red, green and blue.
fn channels(encoding: &str) -> Option<(usize, [usize; 3])> {
    match encoding {
        "rgb8" => Some((3, [0, 1, 2])),
        "bgr8" => Some((3, [2, 1, 0])),
        "rgba8" => Some((4, [0, 1, 2])),
        "bgra8" => Some((4, [2, 1, 0])),
        "mono8" => Some((1, [0, 0, 0])),
        _ => None,
    }
}

/// The pixels of a picture; a fourth channel is left out. Rows may be padded.
///
/// # Errors
/// [`Unreadable`]: where the encoding is another one, or the bytes are not what the fields
/// announce.
pub(crate) fn of_image(image: &Image) -> Result<Decoded, Unreadable> {
    let Image { width, height, step, .. } = *image;
    let (bytes, order) =
        channels(&image.encoding).ok_or_else(|| Unreadable::Encoding(image.encoding.clone()))?;
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 || pixels > MAX_PIXELS {
        return Err(Unreadable::Size { width, height });
    }
    let (row, stride) = (width as usize * bytes, step as usize);
    if stride < row {
        let encoding = image.encoding.clone();
        return Err(Unreadable::Step { width, encoding, needed: row, step });
    }
    let short = || Unreadable::Short { height, step, found: image.data.len() };
    // The last row may lack its padding.
    let needed = stride.checked_mul(height as usize - 1).and_then(|start| start.checked_add(row));
    let data = needed.and_then(|needed| image.data.get(..needed)).ok_or_else(short)?;
    let [red, green, blue] = order;
    let rows = data.chunks(stride).map(|line| line.get(..row).unwrap_or_default());
    let rgb =
        rows.flat_map(|line| line.chunks_exact(bytes)).map(|pixel| [pixel[red], pixel[green], pixel[blue]]);
    let picture = Picture::new(width as usize, height as usize, rgb.collect()).ok_or_else(short)?;
    Ok(Decoded { picture, is_jpeg: false, warnings: Vec::new() })
}

/// How the formats that are read begin.
const BEGINNINGS: [&[u8]; 2] = [b"\xFF\xD8\xFF", b"\x89PNG\r\n\x1A\n"];

/// The pixels of a JPEG or PNG, upright as its EXIF data says.
///
/// # Errors
/// [`Unreadable`]: where it is neither, or depths, or damaged.
pub(crate) fn of_compressed(image: &CompressedImage) -> Result<Decoded, Unreadable> {
    let is_known = BEGINNINGS.iter().any(|beginning| image.data.starts_with(beginning));
    // Depths are PNGs behind a header, or, by some publishers, without one.
    if !is_known || image.format.contains("compressedDepth") {
        return Err(Unreadable::Format(image.format.clone()));
    }
    picture::decode(&image.data).map_err(|error| Unreadable::Damaged(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two pixels in a row, three rows, each row padded by two bytes.
    fn image(encoding: &str, pixel: &[u8]) -> Image {
        let row = [pixel, pixel, &[7, 7]].concat();
        let step = row.len() as u32;
        Image {
            encoding: encoding.into(),
            width: 2,
            height: 3,
            step,
            data: row.repeat(3),
            ..Image::default()
        }
    }

    fn pixels(image: &Image) -> Vec<[u8; 3]> {
        of_image(image).unwrap().picture.rgb().to_vec()
    }

    #[test]
    fn every_encoding_comes_out_as_rgb_without_its_padding() {
        let pixel: &[(&str, &[u8], [u8; 3])] = &[
            ("rgb8", &[1, 2, 3], [1, 2, 3]),
            ("bgr8", &[1, 2, 3], [3, 2, 1]),
            ("rgba8", &[1, 2, 3, 9], [1, 2, 3]),
            ("bgra8", &[1, 2, 3, 9], [3, 2, 1]),
            ("mono8", &[5], [5, 5, 5]),
        ];
        for (encoding, bytes, rgb) in pixel {
            assert_eq!(pixels(&image(encoding, bytes)), vec![*rgb; 6], "{encoding}");
        }
    }

    #[test]
    fn rows_keep_their_order_and_their_pixels() {
        let data = vec![1, 2, 0, 3, 4, 0];
        let mono = Image { encoding: "mono8".into(), width: 2, height: 2, step: 3, data, ..Image::default() };
        assert_eq!(pixels(&mono), [[1; 3], [2; 3], [3; 3], [4; 3]]);
    }

    #[test]
    fn the_order_of_bytes_means_nothing_where_a_channel_is_a_byte() {
        let little = image("bgr8", &[1, 2, 3]);
        assert_eq!(pixels(&Image { is_bigendian: 1, ..little.clone() }), pixels(&little));
    }

    #[test]
    fn the_last_row_may_lack_its_padding_but_no_pixel() {
        let mut image = image("mono8", &[5]);
        image.data.truncate(image.data.len() - 2);
        assert_eq!(pixels(&image).len(), 6);
        image.data.pop();
        assert_eq!(of_image(&image).unwrap_err(), Unreadable::Short { height: 3, step: 4, found: 9 });
    }

    #[test]
    fn fields_that_cannot_be_are_errors() {
        let sound = image("rgb8", &[1, 2, 3]);
        let of = |change: &dyn Fn(&mut Image)| {
            let mut image = sound.clone();
            change(&mut image);
            of_image(&image).unwrap_err()
        };
        assert!(matches!(of(&|image| image.width = 0), Unreadable::Size { .. }));
        assert!(matches!(of(&|image| image.width = u32::MAX), Unreadable::Size { .. }));
        assert!(matches!(of(&|image| image.step = 5), Unreadable::Step { needed: 6, .. }));
        assert!(matches!(of(&|image| image.step = u32::MAX), Unreadable::Short { .. }));
        let message = of(&|image| image.encoding = "yuv422_yuy2".into()).to_string();
        assert!(message.contains("yuv422_yuy2") && message.contains("rgb8"), "{message}");
    }

    #[test]
    fn only_jpeg_and_png_are_decoded() {
        let of = |format: &str, data: &[u8]| {
            of_compressed(&CompressedImage {
                format: format.into(),
                data: data.to_vec(),
                ..CompressedImage::default()
            })
        };
        assert_eq!(of("tiff", b"II*\0").unwrap_err(), Unreadable::Format("tiff".into()));
        let depth = of("16UC1; compressedDepth png", b"\x89PNG\r\n\x1A\n");
        assert!(matches!(depth, Err(Unreadable::Format(_))));
        assert!(matches!(of("jpeg", b"\xFF\xD8\xFF\xE0"), Err(Unreadable::Damaged(_))));
    }
}
