//! PNGs: every chunk that a decoder knows as a bomb, every kind of pixel, and forged headers.

use std::io::Write as _;
use std::sync::OnceLock;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::{BOMB, BULK, Hostile};

const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Colour types and bit depths, and how many bits a pixel has.
const KINDS: [(u8, u8, usize); 15] = [
    (0, 1, 1),
    (0, 2, 2),
    (0, 4, 4),
    (0, 8, 8),
    (0, 16, 16),
    (2, 8, 24),
    (2, 16, 48),
    (3, 1, 1),
    (3, 2, 2),
    (3, 4, 4),
    (3, 8, 8),
    (4, 8, 16),
    (4, 16, 32),
    (6, 8, 32),
    (6, 16, 64),
];

pub(super) fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut crc = flate2::Crc::new();
    crc.update(kind);
    crc.update(data);
    let length = (data.len() as u32).to_be_bytes();
    [&length, kind.as_slice(), data, &crc.sum().to_be_bytes()].concat()
}

fn zeros(length: usize) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    let block = vec![0; 1 << 20];
    for at in (0..length).step_by(block.len()) {
        encoder.write_all(&block[..block.len().min(length - at)]).unwrap();
    }
    encoder.finish().unwrap()
}

/// Half a gigabyte of zeros in two megabytes.
pub(super) fn bomb() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| zeros(BOMB))
}

fn header(width: u32, height: u32, colour: u8, depth: u8, interlaced: bool) -> Vec<u8> {
    let numbers = [width.to_be_bytes(), height.to_be_bytes()].concat();
    chunk(b"IHDR", &[&numbers[..], &[depth, colour, 0, 0, u8::from(interlaced)]].concat())
}

/// A small picture with chunks before and behind its pixels.
fn with(before: &[Vec<u8>], behind: &[Vec<u8>]) -> Vec<u8> {
    let pixels = chunk(b"IDAT", &zeros(48 * (64 + 1)));
    let end = chunk(b"IEND", b"");
    [SIGNATURE, &header(64, 48, 0, 8, false), &before.concat(), &pixels, &behind.concat(), &end].concat()
}

const SMALL: u64 = 64 * 48;

/// What unpacks to far more than it is.
pub(super) fn bombs() -> Vec<Hostile> {
    let text = |head: &[u8]| [head, bomb()].concat();
    let packed = [
        ("iCCP", chunk(b"iCCP", &text(b"profile\0\0"))),
        ("zTXt", chunk(b"zTXt", &text(b"Comment\0\0"))),
        ("iTXt", chunk(b"iTXt", &text(b"XML:com.adobe.xmp\0\x01\0\0\0"))),
        ("zTXt Raw profile type iptc", chunk(b"zTXt", &text(b"Raw profile type iptc\0\0"))),
        ("zTXt Raw profile type exif", chunk(b"zTXt", &text(b"Raw profile type exif\0\0"))),
    ];
    let mut all = Vec::new();
    for (name, chunk) in packed {
        all.push(Hostile::new(format!("PNG {name}"), SMALL, with(std::slice::from_ref(&chunk), &[])));
        all.push(Hostile::new(format!("PNG {name} behind"), SMALL, with(&[], std::slice::from_ref(&chunk))));
        let three = vec![chunk; 3];
        all.push(Hostile::new(format!("PNG 3 {name}"), SMALL, with(&three, &[])));
    }
    // More pixels than the header says.
    let header = header(64, 48, 0, 8, false);
    let file = [SIGNATURE, &header, &chunk(b"IDAT", bomb()), &chunk(b"IEND", b"")].concat();
    all.push(Hostile::new("PNG IDAT", SMALL, file));
    all
}

/// An animation of a frame that is drawn and of others that are bombs.
fn animations() -> Vec<Hostile> {
    let control = |frames: u32| chunk(b"acTL", &[frames.to_be_bytes(), [0; 4]].concat());
    let frame = |number: u32, width: u32, height: u32| {
        let numbers = [number, width, height, 0, 0].map(u32::to_be_bytes).concat();
        chunk(b"fcTL", &[&numbers[..], &[0, 1, 0, 10, 0, 0]].concat())
    };
    let data = |number: u32| chunk(b"fdAT", &[&number.to_be_bytes(), bomb()].concat());
    let before = [control(u32::MAX >> 1), frame(0, 64, 48)];
    vec![
        Hostile::new("APNG", SMALL, with(&before, &[frame(1, 64, 48), data(2)])),
        Hostile::new("APNG of a huge frame", SMALL, with(&before, &[frame(1, 60_000, 60_000), data(2)])),
        Hostile::new("APNG of a frame before", SMALL, with(&[control(2), frame(0, 1, 1), data(1)], &[])),
        Hostile::new(
            "APNG of 100,000 frames",
            SMALL,
            with(&[control(100_000)], &(0..100_000).map(|at| frame(at, 64, 48)).collect::<Vec<_>>()),
        ),
    ]
}

/// Much metadata, in one chunk and in many.
fn bulk() -> Vec<Hostile> {
    let names: [&[u8; 4]; 22] = [
        b"tEXt", b"iTXt", b"zTXt", b"iCCP", b"eXIf", b"sPLT", b"hIST", b"bKGD", b"pHYs", b"tIME", b"sBIT",
        b"gAMA", b"cHRM", b"sRGB", b"cICP", b"mDCV", b"cLLI", b"caBX", b"fdAT", b"acTL", b"fcTL", b"vpAg",
    ];
    let mut all = Vec::new();
    for name in names {
        let title = String::from_utf8_lossy(name).into_owned();
        let large = chunk(name, &[b"Title\0".as_slice(), &vec![1; BULK]].concat());
        all.push(Hostile::new(format!("PNG large {title}"), SMALL, with(&[large], &[])));
        let many = vec![chunk(name, b"Title\0\0x"); 200_000];
        all.push(Hostile::new(format!("PNG many {title}"), SMALL, with(&many, &[])));
    }
    all.push(Hostile::new("PNG empty IDATs", SMALL, with(&vec![chunk(b"IDAT", b""); 1_000_000], &[])));
    all.push(Hostile::new("PNG large PLTE", 0, with(&[chunk(b"PLTE", &vec![1; BULK - 1])], &[])));
    all.push(Hostile::new("PNG large tRNS", SMALL, with(&[chunk(b"tRNS", &vec![1; BULK])], &[])));
    all.push(Hostile::new("PNG unknown critical", 0, with(&[chunk(b"HUGE", &vec![1; BULK])], &[])));
    all.push(Hostile::new("PNG junk behind", SMALL, [with(&[], &[]), vec![7; BULK]].concat()));
    all
}

/// As many pixels as are said, in every kind, and sides that are all there is.
fn pixels() -> Vec<Hostile> {
    let picture = |width: u32, height: u32, (colour, depth, bits): (u8, u8, usize), interlaced: bool| {
        let rows = if interlaced { 2 } else { 1 } * height as usize;
        let raw = rows * ((width as usize * bits).div_ceil(8) + 1);
        let palette = if colour == 3 { chunk(b"PLTE", &[0; 768][..3 << depth]) } else { Vec::new() };
        let header = header(width, height, colour, depth, interlaced);
        let pixels = chunk(b"IDAT", &zeros(raw));
        [SIGNATURE, &header, &palette, &pixels, &chunk(b"IEND", b"")].concat()
    };
    let mut all = Vec::new();
    for kind @ (colour, depth, _) in KINDS {
        for interlaced in [false, true] {
            let name = format!("PNG colour {colour} depth {depth} interlaced {interlaced}");
            all.push(Hostile::new(name, 3000 * 2000, picture(3000, 2000, kind, interlaced)));
        }
    }
    for (width, height) in [(65_535, 1), (1, 65_535), (65_535, 64), (64, 65_535)] {
        let pixels = u64::from(width) * u64::from(height);
        let file = picture(width, height, (6, 16, 64), height > 1);
        all.push(Hostile::new(format!("PNG {width} x {height}"), pixels, file));
    }
    for (width, height) in [(1 << 26, 1), (1 << 30, 1), (u32::MAX >> 1, u32::MAX >> 1), (65_535, 65_535)] {
        let header = header(width, height, 6, 16, false);
        let file = [SIGNATURE, &header, &chunk(b"IDAT", bomb()), &chunk(b"IEND", b"")].concat();
        all.push(Hostile::new(format!("PNG forged {width} x {height}"), 0, file));
    }
    all
}

pub(super) fn all() -> Vec<Hostile> {
    [bombs(), animations(), bulk(), pixels()].into_iter().flatten().collect()
}
