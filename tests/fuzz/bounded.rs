//! The targets of cargo-fuzz as property tests: sound files, changed here and there, and noise.
//!
//! `PROPTEST_CASES=100000 cargo test --release -p grasp-tests --test fuzz` looks for longer.

#[allow(unreachable_pub, reason = "the library of the package of cargo-fuzz")]
mod harness;
mod mutated;
mod reworded;

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use grasp_index::npy::{NpyHeader, NpyType};
use grasp_network::{Architecture, Convolution, Masks, Network};
use grasp_tests::{boxes, pictures, workspace};
use mutated::mutated;
use proptest::prelude::*;
use reworded::reworded;

/// A format: its target, what reads it, and sound files in it.
struct Format {
    target: &'static str,
    read: fn(&[u8]) -> bool,
    seeds: Vec<Vec<u8>>,
    /// Whether it is written by hand, word by word.
    is_text: bool,
}

/// Formats of bytes, then those of text.
fn formats() -> &'static [Format] {
    static FORMATS: OnceLock<Vec<Format>> = OnceLock::new();
    FORMATS.get_or_init(|| {
        let bytes = |target, read, seeds| Format { target, read, seeds, is_text: false };
        let text = |target, read, seeds| Format { target, read, seeds, is_text: true };
        vec![
            bytes("index", harness::index, indexes()),
            bytes("npy", harness::npy, arrays()),
            bytes("glb", harness::glb, vec![boxes::hand()]),
            bytes("stream", harness::stream, streams()),
            bytes("form", harness::form, vec![form()]),
            bytes("network", harness::network, networks()),
            text("labels", harness::labels, tables()),
            text("landmarks", harness::landmarks, landmarks()),
            text("robot", harness::robot, descriptions()),
            text("urdf", harness::urdf, grippers()),
            text("grasps", harness::grasps, vec![shipped("renders/data/grasps.toml")]),
        ]
    })
}

/// A file of the project.
fn shipped(path: &str) -> Vec<u8> {
    fs::read(workspace().join(path)).unwrap()
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

/// One of each version of the format.
fn networks() -> Vec<Vec<u8>> {
    let plain = Architecture {
        side: 6,
        planes: 2,
        convolutions: vec![
            Convolution { kernel: 3, stride: 2, outputs: 5 },
            Convolution { kernel: 1, stride: 1, outputs: 34 },
        ],
        embedding: 4,
        heads: 3,
        masks: None,
    };
    let masked = Architecture { masks: Some(Masks { convolution: 0, count: 2, cells: 3 }), ..plain.clone() };
    let network = |architecture: Architecture| {
        let count = architecture.parameters().unwrap();
        let weights = (0..count).map(|at| (at as f32 * 0.7).sin() * 0.3).collect();
        Network::from_weights(architecture, weights).unwrap()
    };
    let floats = [network(plain), network(masked)];
    let integers = floats.each_ref().map(|network| network.clone().in_integers().to_bytes());
    [floats.map(|network| network.to_bytes()), integers].concat()
}

fn tables() -> Vec<Vec<u8>> {
    let manifest = "file,hand_shape,grasp,cutkosky,stage,azimuth,elevation,roll,qx,qy,qz,qw,object,seed\r\n\
        a/b.png,mean,pinch,9,grasp,1.5,-60,0,0,0,0.6,0.8,sphere,18446744073709551615\r\n\
        \"c,\"\"d\",hand-7,large-diameter,1,reach,,,,1,0,0,0,,\n";
    vec![shipped("tests/pictures/labels.csv"), manifest.into()]
}

fn landmarks() -> Vec<Vec<u8>> {
    let deep = (0..21).map(|at| format!("[0.{at}, 0.5, -1e-3]")).collect::<Vec<_>>().join(", ");
    let named = (0..21).map(|at| format!("{{\"x\": {at}.5, \"y\": 7.5, \"visibility\": 1}}"));
    let named = named.collect::<Vec<_>>().join(", ");
    vec![
        shipped("tests/pictures/landmarks/09-pinch.json"),
        format!("{{\"unit\": \"share\", \"landmarks\": [{deep}]}}").into(),
        format!("{{\"unit\": \"pixel\", \"landmarks\": [{named}]}}").into(),
    ]
}

fn descriptions() -> Vec<Vec<u8>> {
    let folders = ["arms", "objects", "robots"].map(|name| workspace().join("query/data").join(name));
    let files = folders.iter().flat_map(|folder| fs::read_dir(folder).unwrap());
    let mut paths: Vec<_> = files.map(|file| file.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|path| fs::read(path).unwrap()).collect()
}

fn grippers() -> Vec<Vec<u8>> {
    let slider = |ending| shipped(&format!("query/robot/tests/urdf/slider.{ending}"));
    let [urdf, beside] = ["urdf", "toml"].map(slider);
    let versioned = String::from_utf8_lossy(&urdf).replace("<robot ", "<robot version='1.2' xmlns:a='b' ");
    [urdf, versioned.into()].map(|urdf| [&urdf[..], harness::BESIDE.as_bytes(), &beside].concat()).into()
}

fn input(format: &'static Format) -> BoxedStrategy<Vec<u8>> {
    match format.is_text {
        true => prop_oneof![1 => mutated(&format.seeds), 3 => reworded(&format.seeds)].boxed(),
        false => mutated(&format.seeds).boxed(),
    }
}

fn format_and_input() -> impl Strategy<Value = (&'static Format, Vec<u8>)> {
    (0..formats().len()).prop_flat_map(|number| (Just(&formats()[number]), input(&formats()[number])))
}

impl std::fmt::Debug for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.target)
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(formats().len() as u32 * ProptestConfig::default().cases))]

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
