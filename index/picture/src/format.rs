//! Which format a picture has, by its first bytes.

use image::ImageFormat;

use crate::DecodeError;

/// A format that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// PNG, with or without interlacing; the still picture of an animated one.
    Png,
    /// JPEG, baseline or progressive, 8 bits a channel.
    Jpeg,
    /// WebP, lossy.
    WebP,
    /// GIF, the first frame.
    Gif,
    /// BMP.
    Bmp,
    /// PBM, PGM, PPM (text or binary) and PAM.
    Pnm,
}

impl Format {
    /// The format of an encoded picture.
    ///
    /// # Errors
    /// Where its first bytes are those of no picture, or of one that is not read.
    pub fn detect(bytes: &[u8]) -> Result<Self, DecodeError> {
        if bytes.is_empty() {
            return Err(DecodeError::Empty);
        }
        let unsupported = |what| Err(DecodeError::Unsupported { what });
        // What phones write is worth a word of its own.
        if let Some([b'f', b't', b'y', b'p', brand @ ..]) = bytes.get(4..12) {
            return match brand {
                b"heic" | b"heix" | b"hevc" | b"mif1" | b"msf1" => unsupported("a HEIC picture"),
                b"avif" | b"avis" => unsupported("an AVIF picture"),
                _ => unsupported("a video (MP4 or MOV)"),
            };
        }
        match image::guess_format(bytes) {
            Ok(ImageFormat::Png) => Ok(Self::Png),
            Ok(ImageFormat::Jpeg) => Ok(Self::Jpeg),
            Ok(ImageFormat::WebP) => Ok(Self::WebP),
            Ok(ImageFormat::Gif) => Ok(Self::Gif),
            Ok(ImageFormat::Bmp) => Ok(Self::Bmp),
            Ok(ImageFormat::Pnm) => Ok(Self::Pnm),
            Ok(ImageFormat::Tiff) => unsupported("a TIFF picture"),
            Ok(ImageFormat::OpenExr) => unsupported("an OpenEXR picture"),
            Ok(ImageFormat::Hdr) => unsupported("a Radiance HDR picture"),
            Ok(ImageFormat::Qoi) => unsupported("a QOI picture"),
            Ok(ImageFormat::Ico) => unsupported("an icon"),
            Ok(_) => unsupported("a picture of this format"),
            Err(_) => Err(DecodeError::NotAnImage),
        }
    }
}
