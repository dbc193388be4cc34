//! The targets of cargo-fuzz as property tests: sound files, changed here and there, and noise.
//!
//! `PROPTEST_CASES=100000 cargo test --release -p grasp-tests --test fuzz` looks for longer.

#[allow(unreachable_pub, reason = "the library of the package of cargo-fuzz")]
mod harness;
mod mutated;

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use grasp_index::npy::{NpyHeader, NpyType};
use grasp_tests::{boxes, pictures, workspace};
use mutated::mutated;
use proptest::prelude::*;

/// A format: its target, what reads it, and sound files in it.
struct Format {
    target: &'static str,
    read: fn(&[u8]) -> bool,
    seeds: Vec<Vec<u8>>,
}

fn formats() -> &'static [Format; 5] {
    static FORMATS: OnceLock<[Format; 5]> = OnceLock::new();
    FORMATS.get_or_init(|| {
        [
            Format { target: "index", read: harness::index, seeds: indexes() },
            Format { target: "npy", read: harness::npy, seeds: arrays() },
            Format { target: "glb", read: harness::glb, seeds: vec![boxes::hand()] },
            Format { target: "stream", read: harness::stream, seeds: streams() },
            Format { target: "form", read: harness::form, seeds: vec![form()] },
        ]
    })
}

/// One index of each format that is read.
fn indexes() -> Vec<Vec<u8>> {
    let folder = workspace().join("index/tests/fixtures");
    ["v2", "v2-learned", "v3", "v3-learned", "v4", "v4-learned", "v5-network", "v6-network", "v7-learned"]
        .map(|name| fs::read(folder.join(name).with_extension("idx")).unwrap())
        .into()
}

fn arrays() -> Vec<Vec<u8>> {
    let array = |element, values: Vec<u8>| {
        let header = NpyHeader { element, rows: 3, columns: 4, offset: 0 };
        [header.to_bytes(), values].concat()
    };
    let floats = (0..12u8).flat_map(|value| f32::from(value).to_le_bytes()).collect();
    vec![array(NpyType::F32, floats), array(NpyType::U32, (0..48).collect())]
}

fn streams() -> Vec<Vec<u8>> {
    let pnm = b"P6 4 2 255\n0123456789abcdefghijklmn".repeat(2);
    let y4m = b"YUV4MPEG2 W2 H2 Cmono\nFRAME\n\x10\x10\xEB\xEBFRAME\n\x10\x10\xEB\xEB".to_vec();
    let png = fs::read(pictures().join("segmented/09-pinch.png")).unwrap();
    let part = b"--x\r\nContent-Type: image/png\r\n\r\n";
    let multipart = [part, &png[..], b"\r\n", part, &png, b"\r\n--x--\r\n"].concat();
    vec![pnm, y4m, png, multipart]
}

fn form() -> Vec<u8> {
    let head = "--B\r\nContent-Disposition: form-data; name=";
    format!(
        "multipart/form-data; boundary=B\n{head}\"object\"\r\n\r\nname = 'x'\r\n{head}mask; \
         filename=\"a\\\"b\"\r\nContent-Type: image/png\r\n\r\n\r\n--B--\r\n"
    )
    .into_bytes()
}

fn format_and_input() -> impl Strategy<Value = (&'static Format, Vec<u8>)> {
    (0..formats().len()).prop_flat_map(|number| {
        let format = &formats()[number];
        (Just(format), mutated(&format.seeds))
    })
}

impl std::fmt::Debug for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.target)
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(5 * ProptestConfig::default().cases))]

    #[test]
    fn whatever_is_read_does_no_harm((format, bytes) in format_and_input()) {
        (format.read)(&bytes);
    }
}

#[test]
fn sound_files_are_read() {
    for format in formats() {
        for (number, seed) in format.seeds.iter().enumerate() {
            assert!((format.read)(seed), "{} {number}", format.target);
        }
    }
}

/// Writes the sound files to where cargo-fuzz looks for them.
#[test]
#[ignore = "for cargo-fuzz alone: see README.md"]
fn write_corpus() {
    for format in formats() {
        let folder = workspace().join("tests/fuzz/corpus").join(format.target);
        fs::create_dir_all(&folder).unwrap();
        for (number, seed) in format.seeds.iter().enumerate() {
            fs::write(folder.join(Path::new(&number.to_string())), seed).unwrap();
        }
    }
}
