//! Requests that no program would send: whatever comes, the service answers with a status of its
//! own choice, panics never, and answers the next one rightly.
//!
//! `PROPTEST_CASES=20000 cargo test --release -p grasp-tests --test cli serve_fuzz` looks for
//! longer.

#[path = "../fuzz/mutated.rs"]
mod mutated;

use grasp_tests::service::{Response, Service, request};
use grasp_tests::{pictures, small_index};
use mutated::mutated;
use proptest::prelude::*;

struct Fixture {
    service: Service,
    seeds: Vec<Vec<u8>>,
    answer: Response,
}

/// One service for all cases of a test: what one leaves behind, the next one meets. It ends with
/// the test, as no static would.
fn fixture() -> Fixture {
    let service = Service::start(|command| {
        command.arg("--index").arg(small_index()).args([
            "--max-body",
            "1",
            "--max-pixels",
            "1",
            "--timeout",
            "5",
        ]);
    });
    let read = |name: &str| std::fs::read(pictures().join(name)).unwrap();
    let picture = read("segmented/09-pinch.png");
    let answer = service.post("/v1/recognise?segmented=true", &picture);
    assert_eq!(answer.status, 200);
    let npy: Vec<u8> = [
        b"\x93NUMPY\x01\x00\x76\x00{'descr': '<f4', 'fortran_order': False, 'shape': (1, 340), }".as_slice(),
        &[b' '; 60],
        b"\n",
        &[0; 1360],
    ]
    .concat();
    let seeds = vec![
        read("camera/09-pinch.jpg"),
        picture,
        b"P6 8 8 255\n".iter().copied().chain(0..192).collect(),
        b"P7\nWIDTH 4\nHEIGHT 4\nDEPTH 3\nMAXVAL 255\nTUPLTYPE RGB\nENDHDR\n"
            .iter()
            .copied()
            .chain(0..48)
            .collect(),
        npy,
        b"{\"descriptors\": [[0.1, 1e38, -1e38]]}".to_vec(),
        form(),
    ];
    Fixture { service, seeds, answer }
}

fn form() -> Vec<u8> {
    let mut body = Vec::new();
    for (name, content) in [
        ("picture", std::fs::read(pictures().join("segmented/12-precision-disc.png")).unwrap()),
        ("object", b"name = \"x\"\nshape = \"sphere\"\nradius = 1e308\n".to_vec()),
        ("camera", b"position = [0.0, nan, inf]\n".to_vec()),
        ("mask", b"P5 4 4 255\n0123456789abcdef".to_vec()),
    ] {
        body.extend(format!("--B\r\nContent-Disposition: form-data; name=\"{name}\"\r\n\r\n").bytes());
        body.extend(content);
        body.extend(b"\r\n");
    }
    body.extend(b"--B--\r\n");
    body
}

fn paths() -> impl Strategy<Value = String> {
    let path = prop_oneof![
        4 => Just("/v1/recognise"),
        2 => Just("/v1/search"),
        2 => Just("/v1/strategy"),
        1 => Just("/v1/neighbours/7/thumbnail.png"),
        1 => Just("/session"),
    ];
    let names = proptest::sample::select(vec![
        "segmented",
        "hand",
        "rolls",
        "k",
        "sigma",
        "sigma_scale",
        "recall",
        "eps",
        "success",
        "probes",
        "exact",
        "depth_range",
        "robot",
        "explained",
        "timings",
        "file",
        "frame",
        "literal_sigma",
        "generation",
    ]);
    let values = prop_oneof![
        proptest::sample::select(vec![
            "true",
            "0",
            "1",
            "7",
            "0.9",
            "1e-300",
            "1e308",
            "NaN",
            "inf",
            "-1",
            "left",
            "barrett",
            "1..9",
            "4294967295"
        ])
        .prop_map(str::to_owned),
        "[a-zA-Z0-9%._-]{0,12}",
    ];
    let query = proptest::collection::vec((names, values), 0..4);
    (path, query).prop_map(|(path, query)| {
        let query: Vec<String> = query.into_iter().map(|(name, value)| format!("{name}={value}")).collect();
        format!("{path}?{}", query.join("&"))
    })
}

fn cases() -> ProptestConfig {
    ProptestConfig { max_shrink_iters: 200, ..ProptestConfig::default() }
}

#[test]
fn whatever_is_asked_is_answered() {
    let Fixture { service, seeds, answer } = &fixture();
    proptest!(cases(), |(path in paths(), body in mutated(seeds), kind in 0usize..4, accept in 0usize..4)| {
        let kind = ["Content-Type: multipart/form-data; boundary=B\r\n", "Content-Type: image/png\r\n", "Content-Type: multipart/form-data\r\n", ""][kind];
        let accept = ["Accept: text/plain\r\n", "Accept: image/png\r\n", "Accept: application/yaml\r\n", ""][accept];
        let told = service.send(&request("POST", &path, &format!("{kind}{accept}"), &body));
        let expected = [200, 204, 400, 404, 405, 413, 415, 422];
        prop_assert!(expected.contains(&told.status), "{}: {}", told.status, told.text());
        prop_assert_eq!(service.metric("grasp_panics_total"), 0.0);
        let again = service.post("/v1/recognise?segmented=true", &seeds[1]);
        prop_assert_eq!(&again.body, &answer.body);
    });
}

#[test]
fn what_is_no_request_is_no_harm() {
    use std::io::Write as _;
    let Fixture { service, .. } = &fixture();
    proptest!(cases(), |(bytes in proptest::collection::vec(any::<u8>(), 1..512), head in 0usize..3)| {
        let head = ["", "POST /v1/recognise HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n", "GET /v1/index HTTP/1.1\r\n"][head];
        let mut stream = service.connect();
        let _ = stream.write_all(&[head.as_bytes(), &bytes].concat());
        // One who goes away without a word.
        drop(stream);
        prop_assert_eq!(service.get("/healthz").status, 200);
        prop_assert_eq!(service.metric("grasp_panics_total"), 0.0);
    });
}
