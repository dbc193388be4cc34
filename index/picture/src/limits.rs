//! What is read: how large a picture may be, encoded and decoded, and in which formats.

/// The most pixels a picture may have, 134 megapixels: those of cameras of 108 pass, those of 200
/// must be shrunk first, and a forged header costs nothing.
pub const MAX_PIXELS: u64 = 1 << 27;

/// The most pixels a side may have: what JPEG and GIF can say at all. Decoders hold several rows at
/// a time, so that a picture of a single row would cost several times its pixels.
pub const MAX_SIDE: u32 = 65_535;

/// The most encoded bytes that a pixel may take where pixels may be stored as they are: 16-bit
/// RGBA, the widest.
pub const MAX_BYTES_A_PIXEL: u64 = 8;

/// The most encoded bytes that a pixel may take where it always is compressed. A JPEG of noise at
/// the highest quality has three.
pub const MAX_COMPRESSED_BYTES_A_PIXEL: u64 = 4;

/// The bytes that an encoded picture may have besides: headers, colour profile, text, thumbnails.
pub const MAX_OVERHEAD: u64 = 32 << 20;

/// The most scans a JPEG may have. Each is a pass over all pixels that may take no more than a
/// hundred bytes.
///
/// libjpeg's own progressive script has 10 and mozjpeg's longest 11; this is twice that.
pub const MAX_SCANS: usize = 22;

/// The formats that are read, as messages name them.
///
/// Left out is what has no bound on memory: in a TIFF a strip may be a JPEG of any size, and a
/// lossless WebP may ask for 65,536 groups of decoding tables, some 20 kB each, in two megabytes,
/// whatever its pixels.
pub const FORMATS: &str = "PNG, JPEG, WebP (lossy, without transparency), GIF (its first frame), BMP, PNM";
