//! A hand whose joints were found by a tracker (`--landmarks-json`).

use std::fs;
use std::path::Path;

use grasp_tests::service::{Service, request};
use grasp_tests::{Outcome, pictures, program, run, small_index};
use serde_json::{Value, json};

fn recognise(file: &Path, arguments: &[&str]) -> Outcome {
    run(program("grasp-query")
        .args(["recognise", "--index"])
        .arg(small_index())
        .arg(pictures().join("camera/09-pinch.jpg"))
        .arg("--landmarks-json")
        .arg(file)
        .args(arguments))
}

#[test]
fn places_in_pixels_in_shares_and_by_name_are_the_same_hand() {
    let file = pictures().join("landmarks/09-pinch.json");
    let folder = tempfile::tempdir().unwrap();
    let mut record: Value = serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    let places = record["landmarks"].as_array().unwrap().clone();
    let share = |place: &Value, at: usize, side: f64| place[at].as_f64().unwrap() / side;
    let named = places
        .iter()
        .map(|place| json!({ "x": share(place, 0, 640.0), "y": share(place, 1, 480.0), "z": 0.1 }));
    record["landmarks"] = named.collect();
    record["unit"] = "share".into();
    let shares = folder.path().join("shares.json");
    fs::write(&shares, record.to_string()).unwrap();
    let [pixels, shares] = [file, shares].map(|file| {
        let answer = recognise(&file, &["--json"]).json_lines().remove(0);
        (answer["classes"].clone(), answer["orientation"].clone())
    });
    assert_eq!(pixels, shares);
    assert!(pixels.0.as_array().is_some_and(|classes| !classes.is_empty()));
}

#[test]
fn files_that_name_no_hand_are_rejected_with_what_would_be_right() {
    let folder = tempfile::tempdir().unwrap();
    let refuse = |text: &str| {
        let file = folder.path().join("landmarks.json");
        fs::write(&file, text).unwrap();
        let refused = recognise(&file, &[]);
        assert_ne!(refused.status, 0, "{text}");
        let shown = refused.stderr.replace(&folder.path().display().to_string(), "FOLDER");
        shown.replace(&pictures().display().to_string(), "PICTURES")
    };
    let all = |x: f64| json!({ "unit": "pixel", "landmarks": vec![[x, 2.0 * x]; 21] }).to_string();
    insta::assert_snapshot!(refuse(r#"{"landmarks": []}"#));
    insta::assert_snapshot!(refuse(r#"{"unit": "pixel", "landmarks": [[1, 2], [3, 4]]}"#));
    insta::assert_snapshot!(refuse(&all(-5.0)));
    insta::assert_snapshot!(refuse(&all(7.0)));
    insta::assert_snapshot!(refuse("nothing"));
}

#[test]
fn a_service_takes_them_beside_the_picture() {
    let service = Service::start(|command| {
        command.arg("--index").arg(small_index());
    });
    let file = pictures().join("landmarks/09-pinch.json");
    let own = recognise(&file, &["--json"]);
    let server = format!("http://{}", service.address());
    let other = run(program("grasp-query")
        .args(["recognise", "--json", "--server", &server])
        .arg(pictures().join("camera/09-pinch.jpg"))
        .arg("--landmarks-json")
        .arg(&file));
    assert_eq!((own.stdout, own.status), (other.stdout, other.status), "{}", other.stderr);

    let form = |landmarks: &str| {
        let picture = fs::read(pictures().join("camera/09-pinch.jpg")).unwrap();
        let part = |name: &str, content: &[u8]| {
            let head = format!("--x\r\nContent-Disposition: form-data; name=\"{name}\"\r\n\r\n");
            [head.as_bytes(), content, b"\r\n"].concat()
        };
        let body =
            [part("picture", &picture), part("landmarks", landmarks.as_bytes()), b"--x--\r\n".to_vec()];
        let kind = "Content-Type: multipart/form-data; boundary=x\r\n";
        let answer = service.send(&request("POST", "/v1/recognise", kind, &body.concat()));
        (answer.status, answer.text())
    };
    assert_eq!(form(&fs::read_to_string(&file).unwrap()).0, 200);
    let (status, told) = form(r#"{"unit": "pixel", "landmarks": [[1, 2], [3, 4]]}"#);
    assert!(status == 400 && told.contains("cannot use the landmarks: 2 landmarks, 21 expected"), "{told}");
    let away = json!({ "unit": "pixel", "landmarks": vec![[-5.0, -9.0]; 21] }).to_string();
    let (status, told) = form(&away);
    assert!(status == 400 && told.contains("no landmark lies in the picture of 640 x 480 pixels"), "{told}");
}

#[test]
fn networks_of_ones_own_are_asked_for_together_with_their_folder() {
    let folder = tempfile::tempdir().unwrap();
    let refuse = |arguments: &[&str]| {
        let refused = run(program("grasp-query")
            .args(["recognise", "--index"])
            .arg(small_index())
            .arg(pictures().join("camera/09-pinch.jpg"))
            .args(arguments)
            .current_dir(folder.path()));
        assert_eq!(refused.status, 2, "{arguments:?}");
        refused.stderr
    };
    let alone = refuse(&["--segment", "landmarks"]);
    assert!(alone.contains("--landmarks-models <DIR>"), "{alone}");
    let unused = refuse(&["--landmarks-models", "networks"]);
    insta::assert_snapshot!(unused);
    // The feature is off by default.
    let both = ["--segment", "landmarks", "--landmarks-models", "networks"];
    insta::assert_snapshot!(refuse(&both));
    let served =
        refuse(&["--server", "http://127.0.0.1:9", "--segment", "landmarks", "--landmarks-models", "."]);
    insta::assert_snapshot!(served);
}
