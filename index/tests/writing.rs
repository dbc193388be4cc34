//! Writing an index: the same bytes every time, and never half a file.

mod support;

use grasp_index::{
    AtomicFile, BuildError, DescriptorParams, Effort, FileChanged, Index, IndexParams, IndexWriter, NewEntry,
    OpenError, SearchError, SearchOptions, Segments, WriteError,
};
use std::ops::ControlFlow;

fn files_in(folder: &std::path::Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder can be read");
    let mut names: Vec<_> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn the_number_of_threads_does_not_change_a_byte() {
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            support::writer(support::params(4), 15, 6).finish_bytes().expect("the index is built")
        })
    };
    let one = build(1);
    assert!(build(2) == one, "2 threads give other bytes than 1");
    assert!(build(5) == one, "5 threads give other bytes than 1");
    let other = IndexParams { seed: 8, ..support::params(4) };
    assert!(
        support::writer(other, 15, 6).finish_bytes().expect("the index is built") != one,
        "the seed does nothing"
    );
}

#[test]
fn a_file_holds_the_bytes_that_are_built_in_memory() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("small.idx");
    let summary = support::write_small(&path).expect("the index is written");
    let bytes = std::fs::read(&path).expect("the index is there");
    assert_eq!(summary.bytes, bytes.len() as u64);
    assert!(bytes == support::small().finish_bytes().expect("the index is built"));
    assert_eq!(files_in(folder.path()), ["small.idx"]);
}

#[test]
fn mapped_read_and_copied_indexes_answer_alike() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("small.idx");
    support::write_small(&path).expect("the index is written");
    let bytes = std::fs::read(&path).expect("the index is there");
    let answers = [Index::open(&path), Index::read(&path), Index::from_bytes(&bytes)].map(|index| {
        let index = index.expect("the index opens");
        index.search(&vec![0.2; index.dim()], &SearchOptions::default()).expect("the query fits")
    });
    assert_eq!(answers[0], answers[1]);
    assert_eq!(answers[0], answers[2]);
}

#[test]
fn an_entry_has_the_picture_that_came_with_it_or_none() {
    let descriptor = DescriptorParams::raw(1);
    let params = IndexParams { descriptor, thumbnail_side: 2, ..support::small_params() };
    let mut writer = IndexWriter::new(params).expect("the parameters are sound");
    let pictures = [Some(vec![255; 4]), None, Some(vec![0, 0, 0, 1])];
    for (n, thumbnail) in pictures.iter().cloned().enumerate() {
        let entry = NewEntry { descriptor: vec![n as f32], thumbnail, ..NewEntry::default() };
        writer.push(entry).expect("the entry fits");
    }
    let index = Index::from_bytes(&writer.finish_bytes().expect("the index is built")).expect("it opens");
    let found: Vec<_> = (0..4).map(|id| index.thumbnail(id).map(<[u8]>::to_vec)).collect();
    assert_eq!(found, [&pictures[..], &[None]].concat());
}

/// What the mapping relies on: see `Bytes::map`.
#[test]
fn a_reader_goes_on_with_the_old_index_while_a_new_one_takes_its_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("grasp.idx");
    support::write_small(&path).expect("the index is written");
    let old = Index::open(&path).expect("the index opens");
    let again = IndexWriter::create(&path, support::params(2)).expect("a part beside the old index");
    support::finish(support::fill(again, 3, 2)).expect("the index is written again");
    assert_eq!(old.len(), 36);
    assert!(old.verify().is_sound());
    assert_eq!(old.check_unchanged(), Ok(()));
    assert_eq!(Index::open(&path).expect("the index opens").len(), 12);
}

/// What `cp` over an index does to those who have it mapped.
#[cfg(unix)]
#[test]
fn an_index_that_is_cut_short_or_overwritten_says_so_and_does_no_harm() {
    grasp_index::guard_against_truncation().expect("a handler is installed");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("grasp.idx");
    support::write_small(&path).expect("the index is written");
    let whole = std::fs::read(&path).expect("the index is there");
    let query = |index: &Index| index.search(&vec![0.2; index.dim()], &SearchOptions::default());
    let expected = query(&Index::open(&path).expect("the index opens")).expect("the query fits");
    for length in [0, 100, whole.len() / 2, whole.len() - 1] {
        std::fs::write(&path, &whole).expect("the index is written again");
        let (mapped, read) = (Index::open(&path).expect("it opens"), Index::read(&path).expect("it opens"));
        assert_eq!(mapped.check_unchanged(), Ok(()));
        let file = std::fs::File::options().write(true).open(&path).expect("the file can be written");
        file.set_len(length as u64).expect("the file can be cut");
        let _ = (query(&mapped), mapped.verify(), mapped.entry(0));
        assert_eq!(mapped.check_unchanged(), Err(FileChanged), "cut to {length}");
        assert_eq!((query(&read).as_ref(), read.check_unchanged()), (Ok(&expected), Ok(())));
    }
    std::fs::write(&path, &whole).expect("the index is written again");
    let segments = Segments::new(vec![Index::open(&path).expect("it opens")]).expect("one goes with itself");
    let other: Vec<u8> = whole.iter().rev().copied().collect();
    std::fs::write(&path, other).expect("the index is overwritten");
    assert_eq!(segments.check_unchanged(), Err(FileChanged));
}

#[test]
fn a_second_writer_is_told_and_the_first_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("grasp.idx");
    let first = AtomicFile::create(&path).expect("nobody writes yet");
    let second = support::write_small(&path).expect_err("somebody writes already");
    assert!(second.to_string().contains("another program is writing"), "{second}");
    assert!(AtomicFile::create(&folder.path().join("other.idx")).is_ok(), "another file is free");
    let first = IndexWriter::create_in(first, support::params(2)).expect("the parameters are sound");
    support::finish(support::fill(first, 3, 2)).expect("the first writer ends");
    assert_eq!(files_in(folder.path()), ["grasp.idx"]);
    AtomicFile::create(&path).expect("the lock is gone");
}

/// What is written before the header is no index, should anybody look.
#[test]
fn a_part_is_no_index() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("grasp.idx");
    let writer = IndexWriter::create(&path, support::small_params()).expect("the file can be written");
    // As many as no buffer holds.
    let writer = support::fill(writer, 60, 30);
    let part = folder.path().join(".grasp.idx.part");
    assert!(
        std::fs::metadata(&part).expect("the part is there").len() > 1 << 19,
        "descriptors are not held back"
    );
    assert!(matches!(Index::open(&part), Err(OpenError::NotAnIndex)));
    // Thumbnails wait in a file without a name.
    assert_eq!(files_in(folder.path()), [".grasp.idx.part"]);
    drop(writer);
    assert_eq!(files_in(folder.path()), [""; 0]);
}

#[test]
fn an_index_in_memory_has_no_file_to_finish() {
    let error = support::finish(support::small()).expect_err("there is no path");
    assert!(matches!(error, BuildError::InMemory), "{error:?}");
}

#[test]
fn a_writer_that_gives_up_leaves_the_old_file_and_no_other() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("grasp.idx");
    support::write_small(&path).expect("the index is written");
    let before = std::fs::read(&path).expect("the index is there");
    let stop_at = |stop| {
        move |phase, _: f64| if phase == stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    for phase in [grasp_index::Phase::Tune, grasp_index::Phase::Write] {
        let writer = IndexWriter::create(&path, support::params(2)).expect("a part beside the old index");
        let stopped = support::fill(writer, 3, 2).finish(&stop_at(phase));
        assert!(matches!(stopped, Err(BuildError::Stopped)), "{stopped:?}");
    }
    assert!(std::fs::read(&path).expect("the index is there") == before);
    assert_eq!(files_in(folder.path()), ["grasp.idx"]);
}

#[test]
fn the_part_of_a_writer_that_was_killed_is_taken_over() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("grasp.idx");
    std::fs::write(folder.path().join(".grasp.idx.part"), vec![7; 1 << 20]).expect("a part is left behind");
    support::write_small(&path).expect("the index is written");
    assert!(Index::open(&path).expect("the index opens").verify().is_sound());
    assert_eq!(files_in(folder.path()), ["grasp.idx"]);
}

/// A full disk, made by a limit on the size of files: the test runs itself once more under that
/// limit.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_the_old_file_and_no_other() {
    if let Some(folder) = std::env::var_os("GRASP_INDEX_FULL_DISK") {
        let path = std::path::Path::new(&folder).join("grasp.idx");
        let failed = support::write_small(&path).expect_err("the disk is full");
        assert!(matches!(failed, BuildError::Write(WriteError::Io { .. })), "{failed:?}");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("grasp.idx");
    std::fs::write(&path, b"old").expect("a file");
    // Ignoring the signal makes the write fail instead, as it does on a full disk.
    let child = std::process::Command::new("sh")
        .args([
            "-c",
            "trap '' XFSZ; ulimit -f 8; exec \"$0\" --exact a_full_disk_leaves_the_old_file_and_no_other",
        ])
        .arg(std::env::current_exe().expect("this program has a path"))
        .env("GRASP_INDEX_FULL_DISK", folder.path())
        .output()
        .expect("the shell runs");
    assert!(child.status.success(), "{}", String::from_utf8_lossy(&child.stdout));
    assert_eq!(std::fs::read(&path).expect("the file is there"), b"old");
    assert_eq!(files_in(folder.path()), ["grasp.idx"]);
}

#[test]
fn a_batch_finds_what_single_searches_find_and_fills_its_rows() {
    let index = Index::from_bytes(&support::small().finish_bytes().expect("built")).expect("the index opens");
    let queries: Vec<f32> = (0..3).flat_map(|id| index.descriptor(id).expect("an entry").to_vec()).collect();
    for effort in [SearchOptions::default().effort, Effort::Probes(2), Effort::Exact] {
        let options = SearchOptions { k: index.len() + 2, effort };
        let mut found = Vec::new();
        index.searcher().batch(&queries, &options, &mut found).expect("the queries fit");
        assert_eq!(found.len(), 3 * options.k);
        for (query, row) in queries.chunks(index.dim()).zip(found.chunks(options.k)) {
            let single = index.search(query, &options).expect("the query fits").neighbours;
            assert_eq!(single, row[..index.len()]);
            assert!(
                row[index.len()..].iter().all(|none| none.id == u32::MAX && none.distance == f32::INFINITY)
            );
        }
        let ragged =
            index.searcher().batch(&queries[1..], &options, &mut found).expect_err("a value is missing");
        assert!(matches!(ragged, SearchError::WrongLength { .. }), "{ragged}");
    }
}
