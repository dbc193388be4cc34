//! JPEGs: many scans, every sampling, every application segment, and tables without end.

use super::{BULK, Hostile};

const SOI: [u8; 2] = [0xFF, 0xD8];
const EOI: [u8; 2] = [0xFF, 0xD9];

fn segment(marker: u8, data: &[u8]) -> Vec<u8> {
    let length = (data.len() as u16 + 2).to_be_bytes();
    [&[0xFF, marker], &length[..], data].concat()
}

/// As many segments as hold so many bytes.
fn bulk(marker: u8, head: &[u8], length: usize) -> Vec<u8> {
    let one = segment(marker, &[head, &vec![1; 65_000 - head.len()]].concat());
    one.repeat(length / one.len())
}

/// A quantization table, and Huffman tables of a code each: 0, the end of a block, or of 2^14 of
/// them and more.
fn tables(is_progressive: bool) -> Vec<u8> {
    let code = |class: u8, symbol: u8| {
        let mut counts = [0; 16];
        counts[0] = 1;
        segment(0xC4, &[&[class << 4][..], &counts, &[symbol]].concat())
    };
    let end_of_blocks = if is_progressive { 0xE0 } else { 0x00 };
    [segment(0xDB, &[&[0][..], &[1; 64]].concat()), code(0, 0), code(1, end_of_blocks)].concat()
}

/// How a JPEG is laid out.
#[derive(Clone, Copy)]
struct Layout {
    is_progressive: bool,
    width: u16,
    height: u16,
    components: u8,
    /// Samples of the first component, of which the others have one.
    sampling: (u8, u8),
}

impl Layout {
    fn frame(self) -> Vec<u8> {
        let [width, height] = [self.width, self.height].map(u16::to_be_bytes);
        let mut data = [&[8][..], &height, &width, &[self.components]].concat();
        for id in 1..=self.components {
            let (across, down) = if id == 1 { self.sampling } else { (1, 1) };
            data.extend([id, across << 4 | down, 0]);
        }
        segment(if self.is_progressive { 0xC2 } else { 0xC0 }, &data)
    }

    fn blocks(self) -> usize {
        let (across, down) = self.sampling;
        let mcus = |pixels: u16, samples: u8| usize::from(pixels).div_ceil(8 * usize::from(samples));
        let in_mcu = usize::from(across) * usize::from(down) + usize::from(self.components) - 1;
        mcus(self.width, across) * mcus(self.height, down) * in_mcu
    }

    /// A scan of components, of some coefficients, with all bits 0: each block differs from the one
    /// before in nothing.
    fn scan(self, components: &[u8], band: (u8, u8), approximation: u8, bits: usize) -> Vec<u8> {
        let mut data = vec![components.len() as u8];
        components.iter().for_each(|&id| data.extend([id, 0]));
        data.extend([band.0, band.1, approximation]);
        [segment(0xDA, &data), vec![0; bits.div_ceil(8)]].concat()
    }

    fn all_components(self) -> Vec<u8> {
        (1..=self.components).collect()
    }

    /// A whole, flat picture with `more` before its frame.
    fn file(self, more: &[u8]) -> Vec<u8> {
        let head = [&SOI[..], more, &tables(self.is_progressive), &self.frame()].concat();
        let bits = self.blocks() * if self.is_progressive { 1 } else { 2 };
        let band = if self.is_progressive { (0, 0) } else { (0, 63) };
        [head, self.scan(&self.all_components(), band, 0, bits), EOI.to_vec()].concat()
    }

    /// A progressive picture that goes over its pixels so many times; a scan of the higher
    /// coefficients is but a few bytes.
    fn of_scans(self, scans: usize) -> Vec<u8> {
        let head = [&SOI[..], &tables(true), &self.frame()].concat();
        let first = self.scan(&self.all_components(), (0, 0), 0, self.blocks());
        let blocks = usize::from(self.width).div_ceil(8) * usize::from(self.height).div_ceil(8);
        // A code of one bit and 14 bits of how many more.
        let again = self.scan(&[1], (1, 63), 0, 15 * blocks.div_ceil(1 << 14));
        [head, first, again.repeat(scans - 1), EOI.to_vec()].concat()
    }

    fn pixels(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

const PLAIN: Layout =
    Layout { is_progressive: false, width: 64, height: 48, components: 3, sampling: (1, 1) };

pub(super) fn many_scans() -> Vec<Hostile> {
    let layout = Layout { is_progressive: true, width: 3000, height: 2000, ..PLAIN };
    let of =
        |scans: usize, pixels| Hostile::new(format!("JPEG of {scans} scans"), pixels, layout.of_scans(scans));
    vec![of(10, layout.pixels()), of(22, layout.pixels()), of(23, 0), of(99, 0), of(2000, 0)]
}

fn layouts() -> Vec<Hostile> {
    let mut all = Vec::new();
    for is_progressive in [false, true] {
        for components in [1, 3, 4] {
            for sampling in [(1, 1), (2, 1), (1, 2), (2, 2), (4, 1), (1, 4), (4, 4)] {
                let layout = Layout { is_progressive, width: 2000, height: 1500, components, sampling };
                let name = format!("JPEG {is_progressive} {components} {sampling:?}");
                all.push(Hostile::new(name, layout.pixels(), layout.file(&[])));
            }
        }
        for (width, height) in [(65_535, 1), (1, 65_535), (65_535, 33), (33, 65_535)] {
            let layout = Layout { is_progressive, width, height, components: 4, sampling: (4, 4) };
            let name = format!("JPEG {is_progressive} {width} x {height}");
            all.push(Hostile::new(name, layout.pixels(), layout.file(&[])));
        }
        let huge = Layout { is_progressive, width: 65_000, height: 65_000, ..PLAIN };
        let head = [&SOI[..], &tables(is_progressive), &huge.frame()].concat();
        let file = [head, huge.scan(&[1, 2, 3], (0, 0), 0, 800), EOI.to_vec()].concat();
        all.push(Hostile::new(format!("JPEG {is_progressive} forged"), 0, file));
        // A component a scan: none can be drawn before the last has come.
        let layout = Layout { is_progressive, width: 2000, height: 1500, ..PLAIN };
        let head = [&SOI[..], &tables(is_progressive), &layout.frame()].concat();
        let scans = [1, 2, 3].map(|id| layout.scan(&[id], (0, 0), 0, 2 * layout.blocks() / 3));
        let file = [head, scans.concat(), EOI.to_vec()].concat();
        all.push(Hostile::new(format!("JPEG {is_progressive} a scan a component"), layout.pixels(), file));
    }
    all
}

fn metadata() -> Vec<Hostile> {
    let small = PLAIN.pixels();
    let mut all = Vec::new();
    for marker in (0xE0..=0xEF).chain([0xFE]) {
        let file = PLAIN.file(&bulk(marker, b"Exif\0\0", BULK));
        all.push(Hostile::new(format!("JPEG bulk {marker:X}"), small, file));
    }
    let xmp = b"http://ns.adobe.com/xmp/extension/\0";
    let guid = [b'0'; 32];
    // Four gigabytes in all, says each.
    let extended = [&xmp[..], &guid, &u32::MAX.to_be_bytes(), &0u32.to_be_bytes()].concat();
    let heads: [(&str, u8, &[u8]); 6] = [
        ("extended XMP", 0xE1, &extended),
        ("XMP", 0xE1, b"http://ns.adobe.com/xap/1.0/\0"),
        ("ICC", 0xE2, b"ICC_PROFILE\0\x01\xFF"),
        ("MPF", 0xE2, b"MPF\0"),
        ("IPTC", 0xED, b"Photoshop 3.0\08BIM\x04\x04"),
        ("Adobe", 0xEE, b"Adobe\0\x64\0\0\0\0\x01"),
    ];
    for (name, marker, head) in heads {
        let file = PLAIN.file(&bulk(marker, head, BULK));
        all.push(Hostile::new(format!("JPEG {name}"), small, file));
    }
    // An EXIF directory that says it has 65,535 entries, and one that begins at itself.
    for directory in [&[0xFF, 0xFF][..], &[1, 0, 0x12, 1]] {
        let exif = [b"Exif\0\0II*\0\x08\0\0\0", directory, &[0; 64]].concat();
        all.push(Hostile::new("JPEG EXIF", small, PLAIN.file(&segment(0xE1, &exif))));
    }
    let tiny = |marker: u8, data: &[u8]| segment(marker, data).repeat(BULK / (data.len() + 4));
    let huffman = [&[0, 1][..], &[0; 15], &[0]].concat();
    let quantization = [&[0][..], &[1; 64]].concat();
    let whole = PLAIN.file(&[]);
    all.extend([
        Hostile::new("JPEG Huffman tables", 0, PLAIN.file(&tiny(0xC4, &huffman))),
        Hostile::new("JPEG quantization tables", 0, PLAIN.file(&tiny(0xDB, &quantization))),
        Hostile::new("JPEG restart intervals", 0, PLAIN.file(&tiny(0xDD, &[0, 1]))),
        Hostile::new("JPEG empty comments", small, PLAIN.file(&tiny(0xFE, b""))),
        Hostile::new("JPEG restart markers", small, PLAIN.file(&[0xFF, 0xD0].repeat(BULK / 2))),
        Hostile::new("JPEG fill bytes", small, PLAIN.file(&vec![0xFF; BULK])),
        Hostile::new("JPEG garbage", small, PLAIN.file(&vec![0x11; BULK])),
        Hostile::new("JPEG junk behind", small, [&whole[..], &vec![0xAB; BULK]].concat()),
        Hostile::new("JPEG frames", 0, PLAIN.file(&PLAIN.frame().repeat(BULK / PLAIN.frame().len()))),
        Hostile::new("JPEG long scan", small, [&whole[..whole.len() - 2], &vec![0; BULK], &EOI].concat()),
    ]);
    all
}

pub(super) fn all() -> Vec<Hostile> {
    [many_scans(), layouts(), metadata()].into_iter().flatten().collect()
}
