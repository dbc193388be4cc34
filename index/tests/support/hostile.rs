//! Files made to deceive: how one is made to be believed, and everything that is done with one.

use grasp_index::{Effort, Index, SearchOptions, VoteOptions};
use xxhash_rust::xxh3::xxh3_64;

/// The header's length.
pub(crate) const HEADER: usize = 64;

/// Where the catalogue begins, as the header has it.
pub(crate) fn catalogue_offset(bytes: &[u8]) -> Option<u64> {
    Some(u64::from_le_bytes(bytes.get(24..32)?.try_into().ok()?))
}

/// Makes length, catalogue and hashes agree with the bytes, as one does who wants the file to be
/// believed. What is shorter than a header stays as it is.
pub(crate) fn sign(bytes: &mut [u8]) {
    let length = bytes.len() as u64;
    if bytes.len() < HEADER {
        return;
    }
    let Some(offset) = catalogue_offset(bytes).map(|offset| offset.min(length)) else { return };
    let hash = xxh3_64(&bytes[offset as usize..]);
    let fields = [(16, length), (24, offset), (32, length - offset), (40, hash)];
    for (at, value) in fields {
        bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
    }
    let hash = xxh3_64(&bytes[..56]);
    bytes[56..HEADER].copy_from_slice(&hash.to_le_bytes());
}

/// Everything that a program does with an index.
pub(crate) fn use_all(index: &Index) {
    index.verify();
    let _ = index.check_recognises();
    // A hostile index may want many neighbours; a program that is careful bounds them, as the
    // service does.
    let k = index.search_options().k.clamp(1, 100);
    let query = vec![0.1; index.dim()];
    let mut searcher = index.searcher();
    for effort in [SearchOptions::default().effort, Effort::Probes(3), Effort::Exact] {
        let options = SearchOptions { k, effort };
        let _ = searcher.shortlist(&query, &options);
        let _ = searcher.batch(&[&query[..], &query].concat(), &options, &mut Vec::new());
        if let Ok(found) = index.search(&query, &SearchOptions { k, effort }) {
            for euler_mean in [false, true] {
                index.vote(&found.neighbours, &VoteOptions { euler_mean, ..VoteOptions::default() });
            }
        }
    }
    for id in (0..=index.len() as u32).take(100).chain([u32::MAX]) {
        let _ = index.entry(id);
        let _ = index.thumbnail(id);
        let _ = index.descriptor(id);
    }
}
