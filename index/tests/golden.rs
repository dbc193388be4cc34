//! Golden values of descriptors and of a file: whoever changes them raises a version.

mod support;

use grasp_index::{DescriptorParams, FORMAT_VERSION, HandImage};
use xxhash_rust::xxh3::xxh3_64;

/// A lopsided oval in shades that follow from integers alone.
fn hand() -> HandImage {
    const SIDE: i32 = 60;
    let grey: Vec<u8> = (0..SIDE * SIDE)
        .map(|at| {
            let (x, y) = (at % SIDE - 27, at / SIDE - 31);
            let inside = 4 * x * x + 3 * x * y + 2 * y * y + x * y * y / 20 < 1500;
            if inside { (40 + (x * x + 3 * y * y + 7 * x * y).rem_euclid(200)) as u8 } else { 0 }
        })
        .collect();
    HandImage::from_segmented(SIDE as usize, SIDE as usize, &grey, 0).expect("a hand")
}

#[test]
fn descriptors_are_pinned_to_their_fingerprint() {
    let found = DescriptorParams::NAMES.map(|name| {
        let params = DescriptorParams::by_name(name).expect("a descriptor");
        let values = params.describe(&hand()).expect("sound parameters");
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let some = [0, values.len() / 2, values.len() - 1].map(|at| values[at]);
        format!("{name} {:016x}: {:016x} {some:?}", params.fingerprint(), xxh3_64(&bytes))
    });
    assert_eq!(
        found,
        [
            "default 37d64ccf78cc6931: ee80c2d217341641 [0.0, 0.04842036, 0.37390795]",
            "upright 574dc73fef69bc85: 1422a566325ecaa1 [0.0, 0.15968613, 0.44366646]",
            "paper 31918b4e272fe731: df5917f5b4188a5b [0.0, 0.13690476, 0.22862923]",
        ],
        "the same picture has another descriptor: raise REVISION in index/src/descriptor/params.rs, \
         so that it is compared with no descriptor of before, and pin these"
    );
    // Of vectors that came from elsewhere nothing else changes, and indexes of them are to open.
    assert_eq!(format!("{:016x}", DescriptorParams::raw(16).fingerprint()), "3156c0ed88c48311");
}

#[test]
fn a_file_is_pinned_to_the_version_of_the_format() {
    let bytes = support::small().finish_bytes().expect("the index is built");
    assert_eq!(
        (FORMAT_VERSION, bytes.len(), format!("{:016x}", xxh3_64(&bytes)).as_str()),
        (7, 66544, "ca47400e99f86faa"),
        "the same entries make another file: where an older reader would misread it, raise FORMAT_VERSION \
         and keep a fixture of the format of before; where only the fit changed, pin these"
    );
}
