//! `grasp-query search` over several indexes: the answers of the one index that they make together.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use grasp_index::npy::{NpyHeader, NpyType};
use grasp_index::{Effort, Index, SearchOptions, Segments, SegmentsError};
use grasp_tests::{Outcome, program, run, small_index};

const DIM: usize = 340;
const PARTS: [&str; 4] = ["0.idx", "1.idx", "2.idx", "3.idx"];

fn array(values: &[f32]) -> Vec<u8> {
    let rows = (values.len() / DIM) as u64;
    let mut bytes = NpyHeader { element: NpyType::F32, rows, columns: DIM as u64, offset: 0 }.to_bytes();
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

fn done(name: &str, folder: &Path, arguments: &[&str]) -> Outcome {
    let outcome = run(program(name).args(arguments).current_dir(folder));
    assert_eq!(outcome.status, 0, "{arguments:?}: {}", outcome.stderr);
    outcome
}

/// A folder with `single.idx` of all rows, its quarters, and queries: moved rows, and rows as they
/// are, of which some are alike.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let small = Index::open(small_index()).unwrap();
    let rows: Vec<f32> =
        (0..small.len() as u32).flat_map(|id| small.descriptor(id).unwrap().to_vec()).collect();
    let write = |name: &str, values: &[f32]| fs::write(folder.path().join(name), array(values)).unwrap();
    write("x.npy", &rows);
    let mut queries = rows[..DIM * 40].to_vec();
    queries.extend(
        rows.chunks_exact(DIM).step_by(5).flatten().zip(rows.iter().rev()).map(|(a, b)| 0.8 * a + 0.2 * b),
    );
    write("q.npy", &queries);
    done("grasp-builder", folder.path(), &["build", "--descriptors", "x.npy", "--out", "single.idx"]);
    let count = rows.len() / DIM;
    for (at, part) in PARTS.into_iter().enumerate() {
        write("part.npy", &rows[at * count / 4 * DIM..(at + 1) * count / 4 * DIM]);
        done("grasp-builder", folder.path(), &["build", "--descriptors", "part.npy", "--out", part]);
    }
    folder
}

fn search(folder: &Path, indexes: &[&str], more: &[&str]) -> Outcome {
    let indexes = indexes.iter().flat_map(|index| ["--index", index]);
    run(program("grasp-query").args(["search", "q.npy"]).args(indexes).args(more).current_dir(folder))
}

#[test]
fn segments_answer_as_the_index_that_they_make() {
    let folder = folder();
    let folder = folder.path();
    let arrays = |indexes: &[&str], more: &[&str]| {
        let outcome =
            search(folder, indexes, &[&["--out", "ids.npy", "--distances", "d.npy"], more].concat());
        assert_eq!(outcome.status, 0, "{}", outcome.stderr);
        ["ids.npy", "d.npy"].map(|name| fs::read(folder.join(name)).unwrap())
    };
    for more in [&["--exact"][..], &["--exact", "--k", "37", "--threads", "1"], &["--exact", "--k", "5000"]] {
        assert!(arrays(&["single.idx"], more) == arrays(&PARTS, more), "{more:?}");
    }
    // Joined, they are that index.
    let compact = [&["compact"][..], &PARTS, &["--out", "joined.idx"]].concat();
    done("grasp-builder", folder, &compact);
    assert!(arrays(&["single.idx"], &[]) == arrays(&["joined.idx"], &[]));

    // With less than exact effort, at least as near as asked.
    let record = |indexes: &[&str]| search(folder, indexes, &["--json"]).json_lines().remove(0);
    let (one, four) = (record(&["single.idx"]), record(&PARTS));
    assert_eq!((&four["entries"], &four["segments"]["of"]), (&one["entries"], &4.into()));
    assert!(four["predicted_recall"].as_f64().unwrap() >= 0.95);

    // The library's own search, and its tie-breaking: a row is found in each segment that holds it,
    // in order.
    let open = |names: &[&str]| names.iter().map(|name| Index::open(folder.join(name)).unwrap()).collect();
    let segments = Segments::new(open(&PARTS)).unwrap();
    let single = Index::open(folder.join("single.idx")).unwrap();
    let options = SearchOptions { k: 7, effort: Effort::Exact };
    let query = single.descriptor(3).unwrap().into_owned();
    let (all, own) = (segments.search(&query, &options).unwrap(), single.search(&query, &options).unwrap());
    assert_eq!((all.neighbours, all.cost.exact), (own.neighbours, true));
    let twice = Segments::new(open(&["0.idx", "0.idx"])).unwrap();
    let found = twice.search(&query, &options).unwrap().neighbours;
    assert_eq!(found[1].id, found[0].id + twice.len() as u32 / 2);
    assert_eq!(twice.locate(found[1].id).unwrap().1, found[0].id);
    assert!(twice.locate(twice.len() as u32).is_none());
}

#[test]
fn segments_that_another_run_is_writing_are_left_to_it() {
    let folder = tempfile::tempdir().unwrap();
    let split = || {
        let segments = ["split", "--segments", "2", "--out-dir", "."];
        run(program("grasp-builder").args(segments).arg(small_index()).current_dir(folder.path()))
    };
    assert_eq!(split().status, 0);
    // The other run has written the first, and is writing the second.
    let part = fs::File::create(folder.path().join(".2-of-2.idx.part")).unwrap();
    part.lock().unwrap();
    let refused = split();
    assert_eq!(refused.status, 2, "{}", refused.stderr);
    assert!(refused.stderr.contains("another program is writing"), "{}", refused.stderr);
    assert!(folder.path().join("1-of-2.idx").exists());
}

#[test]
fn segments_of_one_index_answer_as_it_does_at_any_effort() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let hands = ["--step", "30", "--hands", "5"];
    for shard in ["1/2", "2/2"] {
        done("grasp-builder", folder, &[&["shard", "--shard", shard, "--out", "parts"], &hands[..]].concat());
    }
    done("grasp-builder", folder, &["merge", "parts", "--out", "single.idx"]);
    done("grasp-builder", folder, &["export", "single.idx", "--descriptors", "x.npy"]);
    let queries = ["queries", "--count", "120", "--preset", "paper", "--out", "q.npy"];
    done("grasp-builder", folder, &queries);
    let single = Index::open(folder.join("single.idx")).unwrap();
    for count in ["2", "3", "4"] {
        let said =
            done("grasp-builder", folder, &["merge", "parts", "--segments", count, "--out-dir", count]);
        done("grasp-builder", folder, &["split", "single.idx", "--segments", count, "--out-dir", "split"]);
        let names: Vec<String> =
            (1..=count.parse().unwrap()).map(|at: u32| format!("{at}-of-{count}.idx")).collect();
        let mut files: Vec<String> = fs::read_dir(folder.join(count))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        files.sort();
        assert_eq!(files, names, "{}", said.stdout);
        for name in &names {
            done("grasp-builder", folder, &["verify", &format!("{count}/{name}")]);
            let [merged, split] = [count, "split"].map(|of| fs::read(folder.join(of).join(name)).unwrap());
            assert!(merged == split, "{name}");
        }
        // Whole hand shapes, in order.
        let hands = |index: &Index| {
            let name = |id| index.entry(id).unwrap().hand_shape.to_owned();
            (name(0), name(index.len() as u32 - 1))
        };
        let indexes: Vec<Index> =
            names.iter().map(|name| Index::open(folder.join(count).join(name)).unwrap()).collect();
        assert!(indexes.windows(2).all(|pair| hands(&pair[0]).1 != hands(&pair[1]).0));
        assert_eq!(indexes.iter().map(Index::len).sum::<usize>(), single.len());

        let paths: Vec<String> = names.iter().map(|name| format!("{count}/{name}")).collect();
        let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
        for effort in [&[][..], &["--recall", "0.9"], &["--recall", "0.99"], &["--probes", "3"], &["--exact"]]
        {
            for k in ["1", "10", "50"] {
                let answer = |indexes: &[&str]| {
                    let more = [effort, &["--k", k, "--neighbours"]].concat();
                    let outcome = search(folder, indexes, &more);
                    assert_eq!(outcome.status, 0, "{}", outcome.stderr);
                    outcome.stdout
                };
                assert!(answer(&["single.idx"]) == answer(&paths), "{count} segments, {effort:?}, k = {k}");
            }
        }
        let cost = |indexes: &[&str]| search(folder, indexes, &["--json"]).json_lines().remove(0);
        let (one, all) = (cost(&["single.idx"]), cost(&paths));
        for key in ["entries", "candidates", "predicted_recall", "effort"] {
            assert_eq!(one[key], all[key], "{key}");
        }
    }
    let refused = |arguments: &[&str]| {
        let outcome = run(program("grasp-builder").args(arguments).current_dir(folder));
        assert_eq!(outcome.status, 2);
        outcome.stderr
    };
    let said = refused(&["split", "single.idx", "--segments", "9999", "--out-dir", "none"]);
    assert!(said.contains("segments at most, not 9999"), "{said}");
    assert!(refused(&["merge", "parts", "--segments", "2"]).contains("--out-dir"));
}

fn files_in(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<String> = entries.map(|name| name.into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_merge_that_is_killed_or_stopped_leaves_nothing_to_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    done(
        "grasp-builder",
        folder,
        &["shard", "--shard", "1/1", "--out", "parts", "--step", "30", "--hands", "5"],
    );
    let merge = |count: &str| ["merge", "parts", "--segments", count, "--out-dir", "out"].map(str::to_owned);
    let out = folder.join("out");
    let names = |count: u32| (1..=count).map(|at| format!("{at}-of-{count}.idx")).collect::<Vec<_>>();
    done("grasp-builder", folder, &["merge", "parts", "--out", "single.idx"]);
    done("grasp-builder", folder, &["split", "single.idx", "--segments", "3", "--out-dir", "expected"]);
    let are_right = || {
        assert_eq!(files_in(&out), names(3));
        for name in names(3) {
            let [found, expected] =
                ["out", "expected"].map(|of| fs::read(folder.join(of).join(&name)).unwrap());
            assert!(found == expected, "{name}");
        }
    };
    // While the index is on its way, when it is there, and when segments are; the program's end may
    // come before.
    for begun in ["..whole.idx.part", ".whole.idx", ".1-of-4.idx.part", ".3-of-4.idx.part"] {
        for signal in ["-KILL", "-INT"] {
            let _ = fs::remove_dir_all(&out);
            let mut command = program("grasp-builder");
            command.args(merge("4")).current_dir(folder).stdout(Stdio::null()).stderr(Stdio::null());
            let mut merging = command.spawn().unwrap();
            while !out.join(begun).exists() && merging.try_wait().unwrap().is_none() {
                std::hint::spin_loop();
            }
            let told =
                Command::new("kill").args([signal, &merging.id().to_string()]).stderr(Stdio::null()).status();
            told.unwrap();
            let status = merging.wait().unwrap();
            match signal {
                "-INT" if status.success() => assert_eq!(files_in(&out), names(4), "{begun}"),
                "-INT" => assert_eq!((status.code(), files_in(&out)), (Some(130), Vec::new()), "{begun}"),
                _ => {
                    names(4).iter().for_each(|name| drop(fs::remove_file(out.join(name))));
                    done("grasp-builder", folder, &merge("3").each_ref().map(String::as_str));
                    are_right();
                }
            }
        }
    }
    let _ = fs::remove_dir_all(&out);
    fs::create_dir(&out).unwrap();
    // All that could be left at once: an index of other parts, and rubbish.
    fs::copy(small_index(), out.join(".whole.idx")).unwrap();
    for rubbish in ["..whole.idx.part", ".1-of-4.idx.part", ".17-of-99.idx.part", ".2-of-3.idx.part"] {
        fs::write(out.join(rubbish), "rubbish").unwrap();
    }
    done("grasp-builder", folder, &merge("3").each_ref().map(String::as_str));
    are_right();
    // What is nobody's leftover stays.
    fs::write(out.join(".1-of-4.txt.part"), "notes").unwrap();
    fs::write(out.join(".4-of-9.idx.part"), "rubbish").unwrap();
    done("grasp-builder", folder, &["split", "single.idx", "--segments", "3", "--out-dir", "out"]);
    assert_eq!(files_in(&out), [&[".1-of-4.txt.part".to_owned()][..], &names(3)].concat());
    fs::remove_file(out.join(".1-of-4.txt.part")).unwrap();
    are_right();
    // A disk that is full: nothing of this merge, and what was there before.
    let builder = program("grasp-builder").get_program().to_owned();
    let script = "trap '' XFSZ; ulimit -f 16; exec \"$0\" \"$@\"";
    let full = run(Command::new("sh").args(["-c", script]).arg(builder).args(merge("4")).current_dir(folder));
    assert!(full.status == 2 && full.stderr.contains("cannot write"), "{}", full.stderr);
    are_right();
}

#[test]
fn a_missing_segment_is_an_error_or_told() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("2.idx"), "no index").unwrap();
    let outcome = search(folder, &PARTS, &["--exact"]);
    assert_eq!(outcome.status, 2);
    assert!(outcome.stderr.contains("cannot use the index 2.idx"), "{}", outcome.stderr);
    let outcome = search(folder, &PARTS, &["--exact", "--json", "--allow-missing"]);
    assert_eq!(outcome.status, 0);
    assert!(outcome.stderr.contains("3 of 4 indexes are searched"), "{}", outcome.stderr);
    let segments = &outcome.json_lines()[0]["segments"];
    assert_eq!((&segments["searched"], &segments["of"]), (&3.into(), &4.into()));

    fs::write(folder.join("y.npy"), array(&[0.5; DIM * 4])).unwrap();
    done(
        "grasp-builder",
        folder,
        &["build", "--descriptors", "y.npy", "--descriptor", "default", "--out", "other.idx"],
    );
    let outcome = search(folder, &[PARTS[0], PARTS[1], "other.idx"], &[]);
    assert!(outcome.stderr.contains("index 2 (counted from 0) has other descriptors"), "{}", outcome.stderr);
    assert_eq!(Segments::new(Vec::new()).unwrap_err(), SegmentsError::None);
}

#[test]
fn two_merges_do_not_write_segments_into_one_folder() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("segments");
    fs::create_dir(&out).unwrap();
    done("grasp-builder", folder.path(), &["shard", "--shard", "1/1", "--out", "parts", "--step", "60"]);
    let merge = |count: &str| {
        let arguments = ["merge", "parts", "--segments", count, "--out-dir", "segments"];
        run(program("grasp-builder").args(arguments).current_dir(folder.path()))
    };
    let names = || {
        let names = fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name());
        names.filter_map(|name| name.into_string().ok()).collect::<BTreeSet<_>>()
    };
    // The other run is at work, on however many segments: no index of this one takes the place of
    // the other's.
    let lock = fs::File::create(out.join("..whole.part")).unwrap();
    lock.lock().unwrap();
    let before = names();
    let refused = merge("2");
    assert_eq!(refused.status, 2, "{}", refused.stderr);
    assert!(refused.stderr.contains("another `merge --segments` is writing into"), "{}", refused.stderr);
    assert_eq!(names(), before);
    // It was killed.
    drop(lock);
    let outcome = merge("3");
    assert_eq!(outcome.status, 0, "{}", outcome.stderr);
    assert_eq!(names().into_iter().collect::<Vec<_>>(), ["1-of-3.idx", "2-of-3.idx", "3-of-3.idx"]);
}
