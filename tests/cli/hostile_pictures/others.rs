//! GIF, BMP, WebP and PNM, and what is not read at all.

use super::{BULK, Hostile};

fn gif(width: u16, height: u16, blocks: &[u8]) -> Vec<u8> {
    let size = [width.to_le_bytes(), height.to_le_bytes()].concat();
    // A table of two colours.
    [b"GIF89a".as_slice(), &size, &[0x80, 0, 0], &[0, 0, 0, 255, 255, 255], blocks, b";"].concat()
}

/// An image block whose codes repeat one colour ever longer: the n-th stands for n pixels.
fn gif_image(width: u16, height: u16, pixels: usize) -> Vec<u8> {
    let size = [width.to_le_bytes(), height.to_le_bytes()].concat();
    let mut codes = Bits::default();
    let mut left = pixels;
    while left > 0 {
        codes.push(4, 3);
        let (mut next, mut length) = (6u32, 1);
        codes.push(0, 3);
        left = left.saturating_sub(1);
        while left > 0 && next < 4095 {
            let width = 32 - next.leading_zeros();
            codes.push(next, width as usize);
            next += 1;
            length += 1;
            left = left.saturating_sub(length);
        }
    }
    codes.push(5, 12);
    let data: Vec<u8> =
        codes.bytes.chunks(255).flat_map(|part| [&[part.len() as u8], part].concat()).collect();
    [&[b',', 0, 0, 0, 0][..], &size, &[0, 2], &data, &[0]].concat()
}

#[derive(Default)]
struct Bits {
    bytes: Vec<u8>,
    used: usize,
}

impl Bits {
    fn push(&mut self, value: u32, bits: usize) {
        for at in 0..bits {
            if self.used.is_multiple_of(8) {
                self.bytes.push(0);
            }
            *self.bytes.last_mut().unwrap() |= ((value >> at & 1) as u8) << (self.used % 8);
            self.used += 1;
        }
    }
}

fn gifs() -> Vec<Hostile> {
    let sub_blocks = |length: usize| [&[255][..], &[1; 255]].concat().repeat(length / 256);
    let extension = |head: &[u8]| [&[b'!'][..], head, &sub_blocks(BULK), &[0]].concat();
    let image = gif_image(64, 48, 64 * 48);
    let small = 64 * 48;
    let with = |extension: &[u8]| gif(64, 48, &[extension, &image].concat());
    vec![
        Hostile::new("GIF", 3000 * 2000, gif(3000, 2000, &gif_image(3000, 2000, 3000 * 2000))),
        Hostile::new("GIF of a huge frame", 0, gif(8, 8, &gif_image(65_535, 65_535, 1000))),
        Hostile::new("GIF of a larger frame", 0, gif(8, 8, &gif_image(9000, 9000, 81_000_000))),
        Hostile::new("GIF forged", 0, gif(65_535, 65_535, &gif_image(65_535, 65_535, 1000))),
        Hostile::new("GIF of 10,000 frames", small, gif(64, 48, &image.repeat(10_000))),
        Hostile::new("GIF without end", small, gif(64, 48, &gif_image(64, 48, 300_000_000))),
        Hostile::new("GIF comment", small, with(&extension(&[0xFE]))),
        Hostile::new("GIF XMP", small, with(&extension(b"\xFF\x0BXMP DataXMP"))),
        Hostile::new("GIF ICC", small, with(&extension(b"\xFF\x0BICCRGBG1012"))),
        Hostile::new("GIF extensions", small, with(&b"!\xFE\x00".repeat(BULK / 3))),
        Hostile::new("GIF no frame", 0, gif(64, 48, &[])),
    ]
}

fn bmp(width: i32, height: i32, bits: u16, compression: u32, colours: u32, body: &[u8]) -> Vec<u8> {
    let palette = vec![0; 4 * if bits <= 8 { 1 << bits } else { 0 }];
    let offset = 54 + palette.len() as u32;
    let length = offset + body.len() as u32;
    let mut file = [b"BM".as_slice(), &length.to_le_bytes(), &[0; 4], &offset.to_le_bytes()].concat();
    file.extend([40u32.to_le_bytes(), width.to_le_bytes(), height.to_le_bytes()].concat());
    file.extend([1u16.to_le_bytes(), bits.to_le_bytes()].concat());
    file.extend([compression, 0, 0, 0, colours, 0].map(u32::to_le_bytes).concat());
    [file, palette, body.to_vec()].concat()
}

fn bmps() -> Vec<Hostile> {
    let mut all = Vec::new();
    for bits in [1u16, 4, 8, 16, 24, 32] {
        let body = vec![0; (2000 * usize::from(bits)).div_ceil(32) * 4 * 1000];
        all.push(Hostile::new(format!("BMP {bits} bits"), 2_000_000, bmp(2000, -1000, bits, 0, 0, &body)));
        let forged = bmp(60_000, 60_000, bits, 0, 0, &[0; 1000]);
        all.push(Hostile::new(format!("BMP {bits} bits forged"), 0, forged));
        let cut = bmp(4000, 3000, bits, 0, 0, &[0; 1000]);
        all.push(Hostile::new(format!("BMP {bits} bits cut"), 12_000_000, cut));
    }
    let runs = [255, 0].repeat(BULK / 2);
    all.push(Hostile::new("BMP RLE8", 12_000_000, bmp(4000, 3000, 8, 1, 0, &runs)));
    all.push(Hostile::new("BMP RLE4", 12_000_000, bmp(4000, 3000, 4, 2, 0, &runs)));
    let steps = [0, 2, 0, 0].repeat(BULK / 4);
    all.push(Hostile::new("BMP RLE8 of steps", 12_000_000, bmp(4000, 3000, 8, 1, 0, &steps)));
    all.push(Hostile::new("BMP of a huge palette", 64 * 48, bmp(64, 48, 8, 0, u32::MAX, &[0; 64 * 48])));
    all
}

fn webp(chunks: &[(&[u8; 4], Vec<u8>)]) -> Vec<u8> {
    let mut body = Vec::new();
    for (name, data) in chunks {
        body.extend(name.iter().chain(&(data.len() as u32).to_le_bytes()).chain(data));
        body.resize(body.len().next_multiple_of(2), 0);
    }
    [b"RIFF".as_slice(), &(body.len() as u32 + 4).to_le_bytes(), b"WEBP", &body].concat()
}

/// A key frame whose bits are all 0.
fn vp8(width: u16, height: u16, length: usize) -> Vec<u8> {
    let first_partition = (length as u32 / 2) << 5 | 0x10;
    let head = [&first_partition.to_le_bytes()[..3], &[0x9D, 0x01, 0x2A]].concat();
    [&head[..], &width.to_le_bytes(), &height.to_le_bytes(), &vec![0; length]].concat()
}

fn webps() -> Vec<Hostile> {
    let extended = |flags: u8| [&[flags, 0, 0, 0][..], &[63, 0, 0, 47, 0, 0]].concat();
    let small = || vp8(64, 48, 4000);
    let lossless = [&[0x2F][..], &(63u32 | 47 << 14).to_le_bytes(), &[0xFF; 4000]].concat();
    vec![
        Hostile::new("WebP", 3000 * 2000, webp(&[(b"VP8 ", vp8(3000, 2000, 200_000))])),
        Hostile::new("WebP cut", 3000 * 2000, webp(&[(b"VP8 ", vp8(3000, 2000, 100))])),
        Hostile::new("WebP forged", 0, webp(&[(b"VP8 ", vp8(16_383, 16_383, 4000))])),
        Hostile::new("WebP large", 64 * 48, webp(&[(b"VP8 ", vp8(64, 48, 500_000))])),
        Hostile::new("WebP lossless", 0, webp(&[(b"VP8L", lossless.clone())])),
        Hostile::new(
            "WebP alpha",
            0,
            webp(&[(b"VP8X", extended(0x10)), (b"ALPH", lossless), (b"VP8 ", small())]),
        ),
        Hostile::new(
            "WebP ICC",
            64 * 48,
            webp(&[(b"VP8X", extended(0x20)), (b"ICCP", vec![1; BULK]), (b"VP8 ", small())]),
        ),
        Hostile::new(
            "WebP EXIF",
            64 * 48,
            webp(&[(b"VP8X", extended(8)), (b"EXIF", vec![1; BULK]), (b"VP8 ", small())]),
        ),
        Hostile::new(
            "WebP XMP",
            64 * 48,
            webp(&[(b"VP8X", extended(4)), (b"VP8 ", small()), (b"XMP ", vec![1; BULK])]),
        ),
        Hostile::new("WebP of many chunks", 64 * 48, {
            let mut chunks: Vec<(&[u8; 4], Vec<u8>)> = vec![(b"VP8X", extended(0))];
            chunks.extend((0..1_000_000).map(|_| (b"junk", Vec::new())));
            chunks.push((b"VP8 ", small()));
            webp(&chunks)
        }),
        Hostile::new("WebP of no picture", 0, webp(&[(b"VP8X", extended(2)), (b"ANIM", vec![0; 6])])),
    ]
}

fn pnms() -> Vec<Hostile> {
    let of = |head: &str, body: Vec<u8>| [head.as_bytes(), &body].concat();
    let mut all = Vec::new();
    let pixels = 2000 * 1000;
    for (head, bytes) in [
        ("P4\n2000 1000\n", pixels / 8),
        ("P5\n2000 1000\n255\n", pixels),
        ("P5\n2000 1000\n65535\n", 2 * pixels),
        ("P6\n2000 1000\n255\n", 3 * pixels),
        ("P6\n2000 1000\n65535\n", 6 * pixels),
        ("P7\nWIDTH 2000\nHEIGHT 1000\nDEPTH 4\nMAXVAL 65535\nTUPLTYPE RGB_ALPHA\nENDHDR\n", 8 * pixels),
    ] {
        let name = head.replace('\n', " ");
        all.push(Hostile::new(format!("PNM {name}"), pixels as u64, of(head, vec![0; bytes])));
        all.push(Hostile::new(format!("PNM {name} cut"), pixels as u64, of(head, vec![0; 1000])));
        let forged = head.replace("2000", "65000").replace("1000", "65000");
        all.push(Hostile::new(format!("PNM {name} forged"), 0, of(&forged, vec![0; 1000])));
    }
    for (head, samples) in [("P1\n2000 1000\n", 1), ("P2\n2000 1000\n255\n", 1), ("P3\n2000 1000\n255\n", 3)]
    {
        let body = b"0 ".repeat(samples * pixels);
        all.push(Hostile::new(format!("PNM {}", &head[..2]), pixels as u64, of(head, body)));
    }
    let comment = format!("P5\n#{}\n64 48\n255\n", "x".repeat(BULK));
    all.push(Hostile::new("PNM comment", 64 * 48, of(&comment, vec![0; 64 * 48])));
    all.push(Hostile::new("PNM number", 0, format!("P5\n{} 48\n255\n", "0".repeat(BULK)).into_bytes()));
    let tuple = format!("P7\nWIDTH 64\nHEIGHT 48\nDEPTH 1\nMAXVAL 255\nTUPLTYPE {}\n", "X".repeat(BULK));
    all.push(Hostile::new("PAM tuple type", 0, tuple.into_bytes()));
    all
}

/// A TIFF whose one strip is a JPEG of its own size, an icon, and what phones write.
fn not_read() -> Vec<Hostile> {
    let tiff = [b"II*\0\x08\0\0\0\xFF\xFF".as_slice(), &vec![1; BULK]].concat();
    vec![
        Hostile::new("TIFF", 0, tiff),
        Hostile::new("HEIC", 0, [b"\0\0\0\x18ftypheic".as_slice(), &vec![0; BULK]].concat()),
        Hostile::new("icon", 0, [&[0, 0, 1, 0, 255, 255][..], &vec![0; BULK]].concat()),
        Hostile::new("zeros", 0, vec![0; BULK]),
        Hostile::new("text", 0, b"picture ".repeat(BULK / 8)),
    ]
}

pub(super) fn all() -> Vec<Hostile> {
    [gifs(), bmps(), webps(), pnms(), not_read()].into_iter().flatten().collect()
}
