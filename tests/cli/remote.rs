//! `grasp-query recognise --server`: what a running service says is what the program would have
//! said.

use std::path::Path;

use grasp_tests::service::Service;
use grasp_tests::{Outcome, pictures, program, run, run_with_input, small_index, workspace};

fn service(more: &[&str]) -> Service {
    Service::start(|command| {
        command.arg("--index").arg(small_index()).args(more);
    })
}

/// The program in the folder of the sample pictures.
fn recognise(by: &[&str], arguments: &[&str], input: &[u8]) -> Outcome {
    let mut command = program("grasp-query");
    command.current_dir(pictures()).arg("recognise").args(by).args(arguments);
    run_with_input(&mut command, input)
}

/// Runs both ways and compares all that is printed.
fn compare(server: &str, arguments: &[&str], input: &[u8]) -> Outcome {
    let own = recognise(&["--index", small_index().to_str().unwrap()], arguments, input);
    let other = recognise(&["--server", server], arguments, input);
    assert_eq!(other.stdout, own.stdout, "{arguments:?}");
    assert_eq!(other.stderr, own.stderr, "{arguments:?}");
    assert_eq!(other.status, own.status, "{arguments:?}");
    other
}

#[test]
fn a_search_is_answered_as_by_the_own_index() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let index = small_index().display().to_string();
    let exported =
        run(program("grasp-builder").args(["export", &index, "--descriptors", "x.npy"]).current_dir(folder));
    assert_eq!(exported.status, 0, "{}", exported.stderr);
    let service = service(&[]);
    let server = format!("http://{}", service.address());
    let search = |by: [&str; 2], more: &[&str]| {
        run(program("grasp-query").args(["search", "x.npy"]).args(by).args(more).current_dir(folder))
    };
    // 500 neighbours of so many rows are more than one request may ask for.
    for more in [
        &["--neighbours"][..],
        &[],
        &["--exact", "--k", "3", "--neighbours"],
        &["--k", "500", "--neighbours"],
    ] {
        let (own, other) = (search(["--index", &index], more), search(["--server", &server], more));
        assert!(own.status == 0 && other.status == 0, "{more:?}: {}{}", own.stderr, other.stderr);
        assert!(own.stdout == other.stdout && own.stderr == other.stderr, "{more:?}");
    }
    let arrays = |by| {
        let outcome = search(by, &["--out", "ids.npy", "--distances", "d.npy", "--recall", "0.9"]);
        assert_eq!(outcome.status, 0, "{}", outcome.stderr);
        ["ids.npy", "d.npy"].map(|name| std::fs::read(folder.join(name)).unwrap())
    };
    assert!(arrays(["--index", &index]) == arrays(["--server", &server]));
    let refused = search(["--server", &server], &["--json"]);
    assert_eq!(refused.status, 2);
    let refused = search(["--server", &server], &["--k", "5000"]);
    assert!(refused.status == 2 && refused.stderr.contains("k is 5000"), "{}", refused.stderr);
}

#[test]
fn shortlists_of_segments_are_the_candidates_of_their_index() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let index = small_index().display().to_string();
    for arguments in [
        &["split", &index, "--segments", "2", "--out-dir", "."][..],
        &["export", &index, "--descriptors", "x.npy"],
    ] {
        let done = run(program("grasp-builder").args(arguments).current_dir(folder));
        assert_eq!(done.status, 0, "{}", done.stderr);
    }
    let segments = ["1-of-2.idx", "2-of-2.idx"].map(|name| {
        Service::start(|command| {
            command.arg("--index").arg(folder.join(name));
        })
    });
    let body = std::fs::read(folder.join("x.npy")).unwrap();
    let start = segments[0].get("/v1/index").json()["entries"].as_u64().unwrap();
    for (parameters, options) in
        [("recall=0.9&k=4", ["--recall", "0.9", "--k", "4"]), ("probes=2&k=7", ["--probes", "2", "--k", "7"])]
    {
        let target = format!("/v1/search?shortlist=true&{parameters}");
        let [first, second] = [0, 1].map(|at| {
            let answer = segments[at].post(&target, &body);
            let lines = answer.text();
            lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect::<Vec<serde_json::Value>>()
        });
        let own = run(program("grasp-query")
            .args(["search", "x.npy", "--neighbours", "--index", &index])
            .args(options)
            .current_dir(folder));
        let own = own.json_lines();
        assert_eq!((first.len(), second.len()), (own.len(), own.len()));
        for ((first, second), own) in first.iter().zip(&second).zip(own) {
            let near = |line: &serde_json::Value, start: u64| -> Vec<(u64, u64, f64)> {
                let each = line["neighbours"].as_array().unwrap().iter();
                each.map(|near| {
                    let [key, id] = ["key", "id"].map(|name| near[name].as_u64().unwrap());
                    (key, id + start, near["distance"].as_f64().unwrap())
                })
                .collect()
            };
            assert_eq!(first["keep"], second["keep"]);
            let mut all = [near(first, 0), near(second, start)].concat();
            all.sort_by_key(|&(key, id, _)| (key, id));
            all.truncate(first["keep"].as_u64().unwrap() as usize);
            all.sort_by(|a, b| a.2.total_cmp(&b.2).then(a.1.cmp(&b.1)));
            let own = own["neighbours"].as_array().unwrap().clone();
            let own =
                own.iter().map(|near| (near["id"].as_u64().unwrap(), near["distance"].as_f64().unwrap()));
            assert!(own.eq(
                all.into_iter().take(options[3].parse().unwrap()).map(|(_, id, distance)| (id, distance))
            ));
        }
    }
}

#[test]
fn output_and_exit_status_are_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let socket = folder.path().join("s");
    let service = service(&["--unix", socket.to_str().unwrap()]);
    let (http, unix) = (format!("http://{}", service.address()), format!("unix:{}", socket.display()));
    let cameras = [
        "camera/01-large-diameter.jpg",
        "camera/no-hand.jpg",
        "camera/09-pinch.jpg",
        "labels.csv",
        "missing.jpg",
    ];
    for server in [&http, &unix] {
        for form in [["--json"].as_slice(), &[]] {
            let all = compare(server, &[form, &cameras].concat(), b"");
            assert_eq!(all.status, 2);
            compare(server, &[form, &["camera/no-hand.jpg"]].concat(), b"");
        }
    }
    for arguments in [
        ["segmented/09-pinch.png", "--mask", "mask/09-pinch.png"].as_slice(),
        &["segmented/09-pinch.png", "--mask", "labels.csv"],
        &["segmented/09-pinch.png", "--mask", "missing.png"],
        &["camera/09-pinch.jpg", "--mask", "mask/09-pinch.png"],
        &["camera/09-pinch.jpg", "--segment", "skin"],
        &[
            "segmented/12-precision-disc.png",
            "--segmented",
            "--hand",
            "right",
            "--k",
            "4",
            "--json",
            "--recall",
            "0.9",
        ],
        &[
            "segmented/12-precision-disc.png",
            "--segmented",
            "--eps",
            "0.1",
            "--sigma-scale",
            "0.5",
            "--rolls",
            "3",
        ],
        &[
            "segmented/12-precision-disc.png",
            "--segmented",
            "--exact",
            "--literal-sigma",
            "--euler-mean",
            "--json",
        ],
    ] {
        compare(&http, arguments, b"");
    }
}

#[test]
fn frames_of_a_pipe_are_answered_one_by_one() {
    let service = service(&[]);
    let server = format!("http://{}/", service.address());
    let picture = std::fs::read(pictures().join("camera/09-pinch.jpg")).unwrap();
    let other = std::fs::read(pictures().join("camera/no-hand.jpg")).unwrap();
    let frames = [picture.as_slice(), &other, &picture].concat();
    let told = compare(&server, &["--json", "-"], &frames);
    assert_eq!(told.json_lines().len(), 3);
    compare(&server, &["--json", "-"], &picture);
    compare(&server, &["-"], b"");
}

#[test]
fn a_drawing_is_the_same() {
    let service = service(&[]);
    let server = format!("http://{}", service.address());
    let folder = tempfile::tempdir().unwrap();
    let drawn = |by: &[&str], name: &str| {
        let out = folder.path().join(name);
        let outcome = recognise(by, &["camera/09-pinch.jpg", "--explain", out.to_str().unwrap()], b"");
        assert_eq!(outcome.status, 0, "{}", outcome.stderr);
        std::fs::read(out).unwrap()
    };
    let own = drawn(&["--index", small_index().to_str().unwrap()], "own.png");
    assert_eq!(drawn(&["--server", &server], "other.png"), own);
}

#[test]
fn depth_pictures_are_sent_along() {
    let service = service(&[]);
    let server = format!("http://{}", service.address());
    let folder = tempfile::tempdir().unwrap();
    let mask = image::open(pictures().join("mask/09-pinch.png")).unwrap().into_luma8();
    let depth = image::ImageBuffer::from_fn(mask.width(), mask.height(), |x, y| {
        image::Luma([if mask.get_pixel(x, y).0[0] > 127 { 600u16 } else { 2000 }])
    });
    let path = folder.path().join("depth.png");
    depth.save(&path).unwrap();
    let depth = path.to_str().unwrap();
    let told = compare(
        &server,
        &["segmented/09-pinch.png", "--depth", depth, "--depth-range", "400..900", "--json"],
        b"",
    );
    assert_eq!(told.status, 0, "{}", told.stderr);
}

#[test]
fn a_robot_is_told_the_same() {
    let service = service(&[]);
    let server = format!("http://{}", service.address());
    let data = workspace().join("query/data");
    let path = |name: &str| data.join(name).to_str().unwrap().to_owned();
    let (object, camera, hand) =
        (path("objects/bottle.toml"), path("objects/camera.toml"), path("robots/barrett.toml"));
    let picture = ["camera/01-large-diameter.jpg", "--hand", "right"];
    for robot in ["barrett", "parallel-gripper", &hand] {
        let robot = ["--robot", robot, "--object", &object, "--camera", &camera];
        for form in [["--json"].as_slice(), &[], &["--format", "moveit"]] {
            compare(&server, &[form, &picture, &robot].concat(), b"");
        }
    }
    // A URDF is sent as the description that it makes with the file beside it.
    let urdf = workspace().join("query/robot/tests/urdf/slider.urdf");
    let (urdf, block) = (urdf.to_str().unwrap(), path("objects/handle.toml"));
    let robot = ["--robot", urdf, "--object", &block, "--camera", &camera];
    compare(&server, &[&["--json"], picture.as_slice(), &robot].concat(), b"");
    // What no robot should try is refused by both in the same words.
    let folder = tempfile::tempdir().unwrap();
    let astray = folder.path().join("astray.toml");
    let text = std::fs::read_to_string(&camera).unwrap();
    std::fs::write(&astray, format!("{text}hand = [-6.0, 2.0, 75.0]\n")).unwrap();
    let robot = ["--robot", "barrett", "--object", &object, "--camera", astray.to_str().unwrap()];
    for form in [["--json"].as_slice(), &[], &["--format", "moveit"]] {
        let told = compare(&server, &[form, &picture, &robot].concat(), b"");
        assert_eq!((told.status, told.stdout.is_empty()), (1, form.len() == 2), "{}", told.stderr);
    }
    let arm = path("arms/kuka-kr6-r700.toml");
    for arm in ["kuka-kr6-r700", &arm, "elephant"] {
        let robot = ["--robot", "barrett", "--object", &object, "--camera", &camera, "--arm", arm];
        compare(&server, &[&["--json"], picture.as_slice(), &robot].concat(), b"");
    }
    compare(
        &server,
        &[picture.as_slice(), &["--robot", "elephant", "--object", &object, "--camera", &camera]].concat(),
        b"",
    );
    // A request names no file of the service's machine.
    let path = format!("/v1/strategy?robot={hand}");
    let answer = service.post(&path, b"");
    assert_eq!(answer.status, 400, "{}", answer.text());
}

#[test]
fn a_service_that_does_not_answer_is_an_error_that_says_so() {
    let picture = pictures().join("camera/09-pinch.jpg");
    let ask = |server: &str, more: &[&str]| {
        run(program("grasp-query").args(["recognise", "--server", server]).args(more).arg(&picture))
    };
    let nobody = ask("http://127.0.0.1:1", &[]);
    assert!(nobody.status == 2 && nobody.stderr.contains("grasp-query serve"), "{}", nobody.stderr);
    let nobody = ask("unix:/nowhere/at/all", &[]);
    assert!(nobody.status == 2 && nobody.stderr.contains("no service answers"), "{}", nobody.stderr);
    let form = ask("ftp://robot", &[]);
    assert!(form.status == 2 && form.stderr.contains("http://HOST:PORT"), "{}", form.stderr);

    let folder = tempfile::tempdir().unwrap();
    let token = folder.path().join("token");
    std::fs::write(&token, "0123456789abcdef").unwrap();
    let token: &Path = &token;
    let guarded = service(&["--token-file", token.to_str().unwrap(), "--max-body", "1"]);
    let server = format!("http://{}", guarded.address());
    let refused = ask(&server, &[]);
    assert!(refused.status == 2 && refused.stderr.contains("token is needed"), "{}", refused.stderr);
    let shown = ask(&server, &["--token-file", token.to_str().unwrap()]);
    assert_eq!(shown.status, 0, "{}", shown.stderr);
    // A picture that the service does not want is no reason not to ask for the others.
    let large = folder.path().join("large.ppm");
    std::fs::write(&large, [b"P6 700 700 255\n".as_slice(), &vec![0; 700 * 700 * 3]].concat()).unwrap();
    let both = ask(&server, &["--json", "--token-file", token.to_str().unwrap(), large.to_str().unwrap()]);
    let lines = both.json_lines();
    assert_eq!((both.status, &lines[0]["error"]["kind"]), (2, &"too_large".into()));
    assert!(lines[1]["grasp"].is_string());
}

#[test]
fn what_a_service_does_not_heed_is_refused() {
    // Nothing listens there.
    let nowhere = ["--server", "http://127.0.0.1:1"];
    for (more, said) in [
        (["--index", "own.idx"], "a service answers by its own index: with --server, leave out --index"),
        (["--no-mmap", "--json"], "a service opens its index itself: with --server, leave out --no-mmap"),
        (["--switch", "0.1"], "'--server <ADDRESS>' cannot be used with '--switch <P>'"),
        (["--motion", "9"], "'--server <ADDRESS>' cannot be used with '--motion <DEG>'"),
        (["--holding", "cup"], "'--server <ADDRESS>' cannot be used with '--holding <NAME>'"),
    ] {
        let outcome = recognise(&nowhere, &[&["camera/09-pinch.jpg"][..], &more].concat(), b"");
        assert!(outcome.status == 2 && outcome.stderr.contains(said), "{more:?}: {}", outcome.stderr);
    }
    // The variable is for all other commands.
    let mut by_variable = program("grasp-query");
    by_variable.args(["recognise", "camera/09-pinch.jpg"]).args(nowhere).env("GRASP_INDEX", "own.idx");
    let outcome = run(by_variable.current_dir(pictures()));
    assert!(outcome.stderr.contains("no service answers at"), "{}", outcome.stderr);
}

#[test]
fn who_is_told_to_wait_waits() {
    let service = service(&["--threads", "1", "--queue", "0"]);
    let server = format!("http://{}", service.address());
    let told = std::thread::scope(|scope| {
        let ask = || {
            recognise(
                &["--server", &server, "--threads", "4"],
                &[
                    "--json",
                    "camera/09-pinch.jpg",
                    "camera/no-hand.jpg",
                    "camera/09-pinch.jpg",
                    "camera/02-small-diameter.jpg",
                ],
                b"",
            )
        };
        [scope.spawn(ask), scope.spawn(ask)].map(|asker| asker.join().unwrap())
    });
    for outcome in told {
        assert_eq!((outcome.status, outcome.json_lines().len()), (1, 4), "{}", outcome.stderr);
    }
}
