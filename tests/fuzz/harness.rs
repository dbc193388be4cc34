//! What is done with bytes that anyone may have made: a function for each format that is read.
//!
//! Each returns whether the bytes were accepted. What is wrong with them is for the readers to
//! find; a panic, a hang or memory without bound is what a fuzzer reports. The targets of
//! cargo-fuzz call them, and so do the bounded property tests beside them (`bounded.rs`).

// The index's own tests use files made to deceive in the same way.
#[path = "../../index/tests/support/hostile.rs"]
mod hostile;

use grasp_index::Index;
use grasp_index::npy::{NpyHeader, NpyType};
use grasp_picture::Frames;
use grasp_renders::HandModel;
use grasp_serve::form::Form;

/// Larger pictures are decoded as smaller ones are, only slower.
const MOST_PIXELS: u64 = 1 << 16;

/// An index, as it is and with its hashes made right: a fuzzer does not guess those.
pub fn index(data: &[u8]) -> bool {
    let mut is_accepted = false;
    let mut signed = data.to_vec();
    hostile::sign(&mut signed);
    for bytes in [data, &signed] {
        if let Ok(index) = Index::from_bytes(bytes) {
            hostile::use_all(&index);
            is_accepted = true;
        }
    }
    is_accepted
}

/// An array in NumPy's format: what is read has the shape that its header says.
pub fn npy(data: &[u8]) -> bool {
    let mut is_accepted = false;
    for element in [NpyType::F32, NpyType::U32] {
        let mut rest = data;
        let Ok(header) = NpyHeader::read(&mut rest, element) else { continue };
        let written = header.to_bytes();
        let again = NpyHeader::read(&mut &written[..], element).expect("what is written is read");
        assert_eq!((again.rows, again.columns), (header.rows, header.columns));
        if element == NpyType::F32
            && let Ok(values) = header.read_values(&mut rest)
        {
            assert_eq!(values.len() as u64, header.rows * header.columns);
            assert!(values.iter().all(|value| value.is_finite()));
        }
        is_accepted = true;
    }
    is_accepted
}

/// A hand model in a binary glTF file.
pub fn glb(data: &[u8]) -> bool {
    let Ok(model) = HandModel::parse("fuzz", data) else { return false };
    assert_eq!(model.shape().name, "fuzz");
    true
}

/// A stream of pictures, and each of them.
pub fn stream(data: &[u8]) -> bool {
    let mut is_accepted = false;
    let mut frames = Frames::new(data);
    for frame in frames.by_ref().map_while(Result::ok) {
        assert!(!frame.bytes.is_empty() && frame.skipped <= data.len() as u64);
        let sides = grasp_picture::dimensions(&frame.bytes);
        if sides.is_ok_and(|(width, height)| u64::from(width) * u64::from(height) <= MOST_PIXELS) {
            is_accepted |= grasp_picture::decode(&frame.bytes).is_ok();
        }
    }
    assert!(frames.skipped_at_end() <= data.len() as u64);
    is_accepted
}

/// A form that a service is sent: the first line is its content type, the rest its body.
pub fn form(data: &[u8]) -> bool {
    let end = data.iter().position(|&byte| byte == b'\n').unwrap_or(data.len());
    let (kind, body) = (&data[..end], data.get(end + 1..).unwrap_or_default());
    let Ok(mut form) = Form::new(&String::from_utf8_lossy(kind), body.to_vec().into()) else {
        return false;
    };
    let mut bytes = 0;
    let mut parts = 0;
    while let Ok(Some(part)) = form.next_part() {
        bytes += part.content.len();
        assert!(bytes <= body.len(), "no byte is in two parts");
        parts += 1;
    }
    parts > 0
}
