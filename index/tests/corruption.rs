//! A broken index is told from a sound one: no truncation and no flipped byte panics, hangs or
//! passes `verify`.

mod support;

use grasp_index::{
    Effort, Index, IndexParams, IndexWriter, KeptFields, NewEntry, OpenError, SearchOptions, VoteOptions,
};

fn small() -> Vec<u8> {
    support::small().finish_bytes().expect("the index is built")
}

/// The same behind a learned hash.
fn learned() -> Vec<u8> {
    support::writer(support::small_learned_params(), 4, 3).finish_bytes().expect("the index is built")
}

/// Uses everything that an index offers. What comes out does not matter here, only that something
/// does.
fn use_all(index: &Index) {
    let query = vec![0.1; index.dim()];
    for options in [
        SearchOptions::default(),
        SearchOptions { effort: Effort::Probes(3), ..SearchOptions::default() },
        SearchOptions { effort: Effort::Exact, ..SearchOptions::default() },
    ] {
        let found = index.search(&query, &options).expect("the query fits");
        index.vote(&found.neighbours, &VoteOptions::default());
        index.vote(&found.neighbours, &VoteOptions { euler_mean: true, ..VoteOptions::default() });
        for neighbour in &found.neighbours {
            let _ = index.entry(neighbour.id);
            let _ = index.thumbnail(neighbour.id);
        }
    }
    for id in 0..=index.len() as u32 {
        let _ = index.entry(id);
        let _ = index.descriptor(id);
    }
}

#[test]
fn a_sound_index_verifies() {
    for bytes in [small(), learned()] {
        let index = Index::from_bytes(&bytes).expect("the index opens");
        use_all(&index);
        let verification = index.verify();
        assert_eq!(verification.problems, []);
        assert_eq!(verification.bytes, bytes.len() as u64);
    }
}

#[test]
fn every_truncation_is_told() {
    let bytes = small();
    for length in 0..bytes.len() {
        match Index::from_bytes(&bytes[..length]) {
            Err(OpenError::Empty) => assert_eq!(length, 0),
            Err(OpenError::Truncated { expected, found }) => {
                assert_eq!(found, length as u64);
                assert_eq!(expected, if length < 64 { 64 } else { bytes.len() as u64 });
            }
            other => panic!("truncated to {length} bytes it gives {other:?}"),
        }
    }
}

/// The same vectors, and nothing that is known of them.
fn vectors_alone() -> Vec<u8> {
    let params = IndexParams {
        kept: KeptFields::nothing(),
        classes: Vec::new(),
        thumbnail_side: 0,
        ..support::small_params()
    };
    let mut writer = IndexWriter::new(params).expect("the parameters are sound");
    let whole = Index::from_bytes(&small()).expect("the index opens");
    for id in 0..whole.len() as u32 {
        let descriptor = whole.descriptor(id).expect("the entry is there").into_owned();
        writer.push(NewEntry { descriptor, ..NewEntry::default() }).expect("the entry fits");
    }
    writer.finish_bytes().expect("the index is built")
}

#[test]
fn every_flipped_byte_is_found_and_none_does_harm() {
    flip_every_byte(small());
}

#[test]
fn nor_does_one_of_a_learned_hash() {
    flip_every_byte(learned());
}

#[test]
fn nor_does_one_of_vectors_alone() {
    flip_every_byte(vectors_alone());
}

fn flip_every_byte(sound: Vec<u8>) {
    let mut bytes = sound.clone();
    for at in 0..bytes.len() {
        for flip in [0xff, 0x01, 0x80] {
            bytes[at] ^= flip;
            if let Ok(index) = Index::from_bytes(&bytes) {
                use_all(&index);
                assert!(!index.verify().is_sound(), "byte {at} flipped by {flip:#x} passes");
            }
            bytes[at] = sound[at];
        }
    }
}

#[test]
fn two_bytes_more_are_told() {
    let mut bytes = small();
    bytes.extend([0, 0]);
    assert!(matches!(Index::from_bytes(&bytes), Err(OpenError::TooLong { .. })));
}

/// A section of noise under a catalogue that is right: what a hostile file, whose hashes fit, looks
/// like to a search.
#[test]
fn noise_in_the_sections_does_no_harm() {
    for sound in [small(), learned()] {
        let index = Index::from_bytes(&sound).expect("the index opens");
        for section in &index.catalogue().sections {
            let range = section.offset as usize..(section.offset + section.length) as usize;
            for fill in [0x00u8, 0x7f, 0x80, 0xff] {
                let mut bytes = sound.clone();
                bytes[range.clone()].fill(fill);
                use_all(&Index::from_bytes(&bytes).expect("opening reads no section"));
            }
            let mut bytes = sound.clone();
            for (at, byte) in bytes[range].iter_mut().enumerate() {
                *byte = (at.wrapping_mul(2_654_435_761) >> 7) as u8;
            }
            use_all(&Index::from_bytes(&bytes).expect("opening reads no section"));
        }
    }
}
