//! Where an index is found that nobody names.

use std::fs;
use std::path::Path;

use grasp_tests::{Outcome, pictures, program, run, small_index};

/// The command in a folder of its own, with a data folder of its own.
fn recognise(work: &Path, data: &Path) -> Outcome {
    run(program("grasp-query")
        .args(["recognise", "--segmented", "--json"])
        .arg(pictures().join("segmented/09-pinch.png"))
        .env_remove("GRASP_INDEX")
        .env("XDG_DATA_HOME", data)
        .current_dir(work))
}

#[cfg(target_os = "linux")]
#[test]
fn an_index_among_the_users_data_is_found_and_one_at_hand_comes_first() {
    let folder = tempfile::tempdir().unwrap();
    let (work, data) = (folder.path().join("work"), folder.path().join("data"));
    fs::create_dir_all(data.join("grasp")).unwrap();
    fs::create_dir_all(&work).unwrap();
    let missing = recognise(&work, &data);
    assert_eq!(missing.status, 2);
    assert!(
        missing.stderr.contains("no index at grasp.idx: put a release's grasp.idx at"),
        "{}",
        missing.stderr
    );
    let users = data.join("grasp/grasp.idx");
    assert!(missing.stderr.contains(users.to_str().unwrap()), "{}", missing.stderr);
    assert!(missing.stderr.contains("`grasp-builder build --out grasp.idx`"), "{}", missing.stderr);
    fs::copy(small_index(), users).unwrap();
    let found = recognise(&work, &data);
    assert!(found.status < 2, "{}", found.stderr);
    fs::write(work.join("grasp.idx"), "no index").unwrap();
    let at_hand = recognise(&work, &data);
    assert_eq!(at_hand.status, 2);
    assert!(at_hand.stderr.contains("cannot use the index grasp.idx"), "{}", at_hand.stderr);
}
