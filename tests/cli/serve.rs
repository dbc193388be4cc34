//! `grasp-query serve`: the answers of the command line over HTTP, and what it does with askers who want too much.

use std::io::Write as _;
use std::net::TcpStream;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use grasp_tests::service::{PATIENCE, Response, Service, request};
use grasp_tests::{pictures, program, run, small_index, workspace};
use serde_json::Value;

fn serve(more: &[&str]) -> Service {
    Service::start(|command| {
        command.arg("--index").arg(small_index()).args(more);
    })
}

fn sample(name: &str) -> Vec<u8> {
    std::fs::read(pictures().join(name)).unwrap()
}

/// A form of files, as `curl -F` sends it.
fn form(parts: &[(&str, &[u8])]) -> (String, Vec<u8>) {
    let mut body = Vec::new();
    for (name, bytes) in parts {
        body.extend_from_slice(
            format!("--x1x\r\nContent-Disposition: form-data; name=\"{name}\"; filename=\"f\"\r\n\r\n")
                .as_bytes(),
        );
        body.extend_from_slice(bytes);
        body.extend_from_slice(b"\r\n");
    }
    body.extend_from_slice(b"--x1x--\r\n");
    ("Content-Type: multipart/form-data; boundary=x1x\r\n".into(), body)
}

/// The command line's answer to the same.
fn recognise(arguments: &[&str]) -> grasp_tests::Outcome {
    run(program("grasp-query")
        .current_dir(pictures())
        .args(["recognise", "--index"])
        .arg(small_index())
        .args(arguments))
}

#[test]
fn answers_are_those_of_the_command_line() {
    let service = serve(&[]);
    for (name, query, options) in [
        ("camera/09-pinch.jpg", "", [].as_slice()),
        ("camera/10-power-sphere-left.jpg", "&rolls=4&k=5", &["--rolls", "4", "--k", "5"]),
        ("camera/no-hand.jpg", "", &[]),
        ("camera/09-pinch.jpg", "&segment=skin", &["--segment", "skin"]),
        ("labels.csv", "", &[]),
        (
            "segmented/12-precision-disc.png",
            "&segmented=true&hand=right",
            &["--segmented", "--hand", "right"],
        ),
        (
            "segmented/09-pinch.png",
            "&segmented=true&exact=true&sigma=0.3",
            &["--segmented", "--exact", "--sigma", "0.3"],
        ),
    ] {
        let path = format!("/v1/recognise?file={name}{query}");
        let printed = recognise(&[["--json", name].as_slice(), options].concat());
        let answer = service.post(&path, &sample(name));
        assert_eq!(answer.text(), printed.stdout, "{name}");
        assert_eq!(answer.header("grasp-status"), Some(printed.status.to_string().as_str()), "{name}");
        assert_eq!(answer.status == 200, printed.status == 0, "{name}");

        let printed = recognise(&[[name].as_slice(), options].concat());
        let text = service.send(&request("POST", &path, "Accept: text/plain\r\n", &sample(name)));
        assert_eq!(text.text(), if printed.status == 0 { printed.stdout } else { printed.stderr }, "{name}");
    }
    let (picture, mask) = (sample("segmented/09-pinch.png"), sample("mask/09-pinch.png"));
    let (kind, body) = form(&[("mask", &mask), ("picture", &picture)]);
    let answer = service.send(&request("POST", "/v1/recognise?file=segmented/09-pinch.png", &kind, &body));
    let printed = recognise(&["--json", "segmented/09-pinch.png", "--mask", "mask/09-pinch.png"]);
    assert_eq!(answer.text(), printed.stdout);

    let out = tempfile::tempdir().unwrap();
    let drawn = out.path().join("why.png");
    recognise(&["camera/09-pinch.jpg", "--explain", drawn.to_str().unwrap()]);
    let path = "/v1/recognise?file=camera/09-pinch.jpg";
    let drawing =
        service.send(&request("POST", path, "Accept: image/png\r\n", &sample("camera/09-pinch.jpg")));
    assert_eq!(drawing.body, std::fs::read(drawn).unwrap());
}

#[test]
fn descriptors_are_searched_for_as_by_the_command_line() {
    let service = serve(&[]);
    let folder = tempfile::tempdir().unwrap();
    let queries = folder.path().join("q.npy");
    let made = run(program("grasp-builder")
        .args(["queries", "--descriptor", "default", "--count", "20", "--out"])
        .arg(&queries));
    assert_eq!(made.status, 0, "{}", made.stderr);
    let printed = run(program("grasp-query")
        .args(["search", "--neighbours", "--k", "3", "--exact", "--index"])
        .arg(small_index())
        .arg(&queries));
    let bytes = std::fs::read(&queries).unwrap();
    let answer = service.post("/v1/search?k=3&exact=true", &bytes);
    assert_eq!((answer.status, answer.text()), (200, printed.stdout.clone()));

    let dim = service.get("/v1/index").json()["dim"].as_u64().unwrap() as usize;
    let values = bytes[bytes.len() - dim * 4..].chunks_exact(4);
    let last: Vec<f32> = values.map(|value| f32::from_le_bytes(value.try_into().unwrap())).collect();
    let body = serde_json::json!({ "descriptors": [last] }).to_string();
    let answer = service.post("/v1/search?k=3&exact=true", body.as_bytes()).json();
    let expected: Value = serde_json::from_str(printed.stdout.lines().last().unwrap()).unwrap();
    assert_eq!(answer["neighbours"], expected["neighbours"]);

    for (query, body, status, says) in [
        ("", "{\"descriptors\":[[1.0]]}", 400, "descriptors[0] has 1 values"),
        ("", "{\"descriptors\":[]}", 400, "no descriptor"),
        ("", "[1]", 400, "descriptors"),
        ("", "", 400, "NumPy"),
        ("", "\u{93}NUMPY", 400, ""),
        ("?k=0", "{}", 400, "k is 0"),
        ("?kk=1", "{}", 400, "kk"),
    ] {
        let answer = service.post(&format!("/v1/search{query}"), body.as_bytes());
        assert_eq!(answer.status, status, "{body}: {}", answer.text());
        let message = answer.json()["error"]["message"].as_str().unwrap().to_owned();
        assert!(message.contains(says), "{body}: {message}");
    }
    let many =
        format!("{{\"descriptors\":[{}]}}", vec![format!("[{}]", vec!["0.5"; dim].join(",")); 101].join(","));
    assert_eq!(service.post("/v1/search?k=1000", many.as_bytes()).status, 413);
}

#[test]
fn an_answer_can_be_explained_and_its_neighbours_looked_at() {
    let service = serve(&[]);
    let answer = service.post("/v1/recognise?explained=true", &sample("camera/09-pinch.jpg"));
    let record = answer.json();
    let explained = &record["explained"];
    assert!(record["grasp"].is_string(), "the record is there as well");
    assert_eq!((explained["width"].as_u64(), explained["height"].as_u64()), (Some(320), Some(240)));
    for picture in ["mask", "hand_image"] {
        assert!(explained[picture].as_str().unwrap().starts_with("data:image/png;base64,iVBOR"), "{picture}");
    }
    let cells = explained["cells"].as_array().unwrap();
    let values: usize = cells.iter().map(|cell| cell["histogram"].as_array().unwrap().len()).sum();
    assert_eq!(values as u64, explained["dim"].as_u64().unwrap());

    let nearest = record["neighbours"][0]["id"].as_u64().unwrap();
    let of = |generation: &str| service.get(&format!("/v1/neighbours/{nearest}/thumbnail.png{generation}"));
    assert!(of("?generation=1").body.starts_with(b"\x89PNG"));
    assert!(of("").body.starts_with(b"\x89PNG"));
    assert_eq!(of("?generation=2").status, 410);
    assert_eq!(service.get("/v1/neighbours/4294967295/thumbnail.png").status, 404);
    assert_eq!(service.get("/v1/neighbours/-1/thumbnail.png").status, 400);
}

#[test]
fn it_says_what_it_serves_and_how_it_does() {
    let service = serve(&[]);
    let index = service.get("/v1/index").json();
    assert_eq!(index["classes"].as_array().unwrap().len(), 6);
    assert_eq!((&index["generation"], &index["recognises"]), (&1.into(), &true.into()));
    assert_eq!(service.get("/readyz").json()["state"], "serving");
    assert_eq!(service.get("/healthz").text(), "ok\n");
    assert_eq!(service.post("/v1/recognise", &sample("camera/09-pinch.jpg")).status, 200);
    assert_eq!(service.metric("grasp_step_seconds_count{step=\"segmentation\"}"), 1.0);
    assert_eq!(service.metric("grasp_requests_total{path=\"/v1/recognise\",status=\"200\"}"), 1.0);
    assert_eq!(service.metric("grasp_candidates_count"), 1.0);

    let described = service.get("/openapi.json").json();
    assert!(described["openapi"].as_str().unwrap().starts_with("3."));
    // People read the same as a page.
    let docs = service.get("/docs");
    assert!(docs.header("content-type").unwrap().starts_with("text/html"));
    let paths: Vec<&String> = described["paths"].as_object().unwrap().keys().collect();
    for (path, methods) in described["paths"].as_object().unwrap() {
        for of in methods.as_object().unwrap().values() {
            let summary = of["summary"].as_str().unwrap();
            assert!(docs.text().contains(path) && docs.text().contains(summary), "{path}: {summary}");
            assert!(of["tags"][0].is_string() && !summary.contains(path), "{path}: {summary}");
        }
    }
    assert!(paths.contains(&&"/v1/recognise".to_owned()) && paths.contains(&&"/v1/search".to_owned()));
    // Every key of a real record is described, and every schema that is named is there.
    let record = service.post("/v1/recognise?timings=true", &sample("camera/09-pinch.jpg")).json();
    let schemas = &described["components"]["schemas"];
    for key in record.as_object().unwrap().keys() {
        assert!(!schemas["Answer"]["properties"][key].is_null(), "{key} is not described");
    }
    let text = described.to_string();
    for named in text.split("#/components/schemas/").skip(1) {
        let name = named.split('"').next().unwrap();
        assert!(!schemas[name].is_null(), "{name} is not described");
    }
}

#[test]
fn nonsense_is_refused_and_nothing_falls() {
    let service = serve(&["--max-body", "1", "--max-pixels", "1"]);
    let too_long = vec![0u8; 1_000_001];
    assert_eq!(service.post("/v1/recognise", &too_long).status, 413);
    // A header that asks for a gigapixel; nothing of that size is ever made.
    let mut forged = sample("segmented/09-pinch.png");
    forged[16..24].copy_from_slice(&[0, 0, 0x80, 0, 0, 0, 0x80, 0]);
    let (kind, huge_mask) =
        form(&[("picture", &sample("segmented/09-pinch.png")), ("mask", b"P5 30000 30000 255\n")]);
    let answer = service.send(&request("POST", "/v1/recognise", &kind, &huge_mask));
    assert_eq!(answer.status, 413, "{}", answer.text());
    let crc = service.post("/v1/recognise", &forged);
    assert!((400..500).contains(&crc.status), "{}", crc.text());
    let ppm = service.post("/v1/recognise", b"P6 30000 30000 255\n");
    assert_eq!((ppm.status, &ppm.json()["error"]["kind"]), (413, &"too_large".into()));

    for (query, says) in [
        ("rolls=0", "rolls"),
        ("rolls=1000000", "1 to 36"),
        ("nothing=1", "nothing"),
        ("hand=both", "hand"),
        ("segment=colour", "segment"),
        ("recall=2", "recall"),
        ("depth_range=1..2", "depth picture"),
        ("k=99999999999999999999999", "k"),
        ("%ff=%ff", ""),
    ] {
        let answer = service.post(&format!("/v1/recognise?{query}"), &sample("camera/09-pinch.jpg"));
        assert_eq!(answer.status, 400, "{query}: {}", answer.text());
        let message = answer.json()["error"]["message"].as_str().unwrap().to_owned();
        assert!(message.contains(says), "{query}: {message}");
    }
    let picture = sample("segmented/09-pinch.png");
    for parts in [
        [("mask", picture.as_slice()), ("mask", &picture)].as_slice(),
        &[("picture", &picture), ("picture", &picture)],
        &[("elephant", &picture)],
        &[("picture", &picture), ("depth", &picture)],
        &[("picture", &picture), ("mask", b"no picture")],
        &[],
    ] {
        let (kind, body) = form(parts);
        let answer = service.send(&request("POST", "/v1/recognise", &kind, &body));
        assert_eq!(answer.status, 400, "{}", answer.text());
        let cut = service.send(&request("POST", "/v1/recognise", &kind, &body[..body.len() / 2]));
        assert_eq!(cut.status, 400, "{}", cut.text());
    }
    for (method, path, status) in [
        ("GET", "/v1/recognise", 405),
        ("POST", "/v1/index", 405),
        ("GET", "/nowhere", 404),
        ("GET", "/../Cargo.toml", 404),
        ("POST", "/v1/recognise", 400),
    ] {
        assert_eq!(service.send(&request(method, path, "", b"")).status, status, "{method} {path}");
    }
    assert_eq!(service.send(b"nonsense\r\n\r\n").status, 400);
    let elsewhere = service.send(b"GET /v1/index HTTP/1.1\r\nHost: example.com\r\nConnection: close\r\n\r\n");
    assert_eq!(elsewhere.status, 403, "another site's page cannot ask under its own name");
    assert_eq!(service.post("/v1/recognise", &sample("camera/09-pinch.jpg")).status, 200);
    assert_eq!(service.metric("grasp_panics_total"), 0.0);
    assert_eq!(service.metric("grasp_requests_inside"), 0.0);
}

/// Sends the head of a request and half of its body.
fn half(service: &Service, body: &[u8]) -> std::net::TcpStream {
    let mut stream = service.connect();
    let whole = request("POST", "/v1/recognise", "", body);
    let half = whole.len() - body.len() / 2;
    stream.write_all(&whole[..half]).unwrap();
    service.wait_until("the request to arrive", |service| service.metric("grasp_requests_arriving") >= 1.0);
    stream
}

#[test]
fn who_cannot_wait_is_told_when_to_come_back() {
    let service = serve(&["--threads", "1", "--queue", "0"]);
    let picture = sample("camera/09-pinch.jpg");
    let started = Instant::now();
    loop {
        assert!(started.elapsed() < PATIENCE, "eight at a time, and none is in the way of another");
        let answers: Vec<Response> = std::thread::scope(|scope| {
            let ask = || service.post("/v1/recognise?rolls=36", &picture);
            let asking: Vec<_> = (0..8).map(|_| scope.spawn(ask)).collect();
            asking.into_iter().map(|asking| asking.join().unwrap()).collect()
        });
        assert!(answers.iter().any(|answer| answer.status == 200));
        if let Some(turned_away) = answers.iter().find(|answer| answer.status != 200) {
            assert_eq!((turned_away.status, turned_away.header("retry-after")), (429, Some("1")));
            assert_eq!(turned_away.json()["error"]["kind"], "busy");
            break;
        }
    }
    // One who has not sent all takes no place.
    let mut first = half(&service, &picture);
    assert_eq!(service.post("/v1/recognise", &picture).status, 200);
    first.write_all(&picture[picture.len() - picture.len() / 2..]).unwrap();
    assert_eq!(Response::read(&mut first).unwrap().status, 200);
}

#[test]
fn who_sends_too_slowly_is_sent_away() {
    let service = serve(&["--timeout", "0.2"]);
    let picture = sample("camera/09-pinch.jpg");
    let mut slow = half(&service, &picture);
    let answer = Response::read(&mut slow).unwrap();
    assert_eq!((answer.status, &answer.json()["error"]["kind"]), (408, &"timeout".into()));
    service.wait_until("the end of it", |service| service.metric("grasp_requests_arriving") == 0.0);
    // One who went away is forgotten as well.
    drop(half(&service, &picture));
    service.wait_until("the end of it", |service| service.metric("grasp_requests_arriving") == 0.0);
}

/// Clients that mean no good: each has sent the head of a request, and sends of its body at most
/// `most` bytes, at most `each` at a time.
struct Crowd {
    clients: Vec<TcpStream>,
    most: usize,
    each: usize,
}

impl Crowd {
    fn new(service: &Service, count: usize, declared: usize, most: usize, each: usize) -> Self {
        let client = || {
            let mut stream = service.connect();
            let head = format!(
                "POST /v1/recognise HTTP/1.1\r\nHost: localhost\r\nContent-Length: {declared}\r\n\r\n"
            );
            stream.write_all(head.as_bytes()).unwrap();
            stream.set_nonblocking(true).unwrap();
            stream
        };
        Self { clients: std::iter::repeat_with(client).take(count).collect(), most, each }
    }

    /// Sends until `over`. What the service does not take, or no longer, is nothing to these
    /// clients.
    fn send(&mut self, over: &AtomicBool) {
        let mut sent = vec![0; self.clients.len()];
        let zeros = vec![0; self.each];
        while !over.load(Ordering::SeqCst) {
            for (client, sent) in self.clients.iter_mut().zip(&mut sent) {
                let each = self.each.min(self.most - *sent);
                *sent += client.write(&zeros[..each]).unwrap_or(0);
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

/// Megabytes of memory that a service has.
fn memory(service: &Service) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{}/status", service.id())).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse::<u64>().unwrap() / 1024
}

#[test]
fn slow_and_stalled_clients_shut_nobody_out_and_their_memory_comes_back() {
    let service = serve(&[]);
    let small = sample("camera/09-pinch.jpg");
    let large = [b"P6 1000 1000 255\n".as_slice(), &vec![0; 3_000_000]].concat();
    let ask = |body: &[u8]| service.post("/v1/recognise", body).status;
    for _ in 0..4 {
        assert_eq!((ask(&small), ask(&large)), (200, 422));
    }
    let before = memory(&service);
    let mut slow = Crowd::new(&service, 100, 10_000_000, 10_000_000, 1);
    let mut stalled = Crowd::new(&service, 100, 19_000_000, 18_900_000, 1 << 18);
    let over = AtomicBool::new(false);
    let most = AtomicU64::new(0);
    std::thread::scope(|scope| {
        scope.spawn(|| slow.send(&over));
        scope.spawn(|| stalled.send(&over));
        scope.spawn(|| {
            while !over.load(Ordering::SeqCst) {
                most.fetch_max(memory(&service), Ordering::SeqCst);
                std::thread::sleep(Duration::from_millis(10));
            }
        });
        // The others must end also where this fails.
        let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            service.wait_until("the crowd", |service| service.metric("grasp_requests_arriving") >= 150.0);
            std::thread::scope(|scope| {
                for client in 0..8 {
                    let (body, expected) = if client % 2 == 0 { (&small, 200) } else { (&large, 422) };
                    scope.spawn(move || (0..5).for_each(|_| assert_eq!(ask(body), expected)));
                }
            });
            // The crowd is still there, and goes on sending as it did.
            service.wait_until("the crowd's end", |service| service.metric("grasp_requests_arriving") == 0.0);
            service.wait_until("the memory", |service| memory(service) < before + 40);
        }));
        over.store(true, Ordering::SeqCst);
        if let Err(panic) = outcome {
            std::panic::resume_unwind(panic);
        }
    });
    let most = most.into_inner();
    assert!(most < before + 200, "{before} MB before, {most} MB at most");
    assert_eq!(service.metric("grasp_body_bytes_reserved"), 0.0);
}

#[test]
fn a_foreign_page_makes_it_do_nothing() {
    let service = serve(&[]);
    let picture = sample("camera/09-pinch.jpg");
    let routes = [
        ("POST", "/v1/recognise"),
        ("POST", "/v1/strategy"),
        ("POST", "/v1/search"),
        ("POST", "/session"),
        ("GET", "/v1/index"),
        ("GET", "/v1/neighbours/0/thumbnail.png"),
        ("GET", "/metrics"),
    ];
    for headers in [
        "Sec-Fetch-Site: cross-site\r\nSec-Fetch-Mode: no-cors\r\n",
        "Sec-Fetch-Site: cross-site\r\nOrigin: https://example.com\r\nContent-Type: text/plain\r\n",
        "Sec-Fetch-Site: same-site\r\nOrigin: http://localhost:3000\r\n",
        "Origin: https://example.com\r\n",
        "Origin: null\r\n",
    ] {
        for (method, path) in routes {
            let answer = service.send(&request(method, path, headers, &picture));
            assert_eq!(
                (answer.status, &answer.json()["error"]["kind"]),
                (403, &"origin".into()),
                "{headers}{path}"
            );
        }
        // A link may lead to the page.
        assert_eq!(service.send(&request("GET", "/", headers, b"")).status, 200);
    }
    assert_eq!(service.metric("grasp_requests_total{path=\"/v1/recognise\",status=\"403\"}"), 5.0);
    assert_eq!(service.metric("grasp_step_seconds_count{step=\"decode\"}"), 0.0);
    for headers in
        ["Sec-Fetch-Site: same-origin\r\nOrigin: http://localhost\r\n", "Origin: http://localhost\r\n", ""]
    {
        assert_eq!(
            service.send(&request("POST", "/v1/recognise", headers, &picture)).status,
            200,
            "{headers}"
        );
    }
}

/// Words of the libraries that read requests, which say nothing to who sends them.
const RAW: [&str; 8] = [
    "deserialize",
    "unknown variant",
    "unknown field",
    "invalid type",
    "invalid digit",
    "EOF",
    "URL",
    "multipart",
];

#[test]
fn what_is_wrong_is_said_in_the_services_own_words() {
    let service = serve(&[]);
    let picture = sample("segmented/09-pinch.png");
    let (kind, doubled) = form(&[("picture", &picture), ("picture", &picture)]);
    let dim = service.get("/v1/index").json()["dim"].as_u64().unwrap() as usize;
    let row = vec!["0.5"; dim].join(",");
    for (method, path, headers, body, status, says) in [
        (
            "POST",
            "/v1/recognise?hand=both",
            "",
            b"".as_slice(),
            400,
            "hand is `both`: `auto` or `left` or `right` is needed",
        ),
        ("POST", "/v1/recognise?k=x", "", b"", 400, "k is `x`: an integer from 1 to 1000 is needed"),
        (
            "POST",
            "/v1/recognise?rolls=99",
            "",
            &picture,
            400,
            "rolls is 99: an integer from 1 to 36 is needed",
        ),
        (
            "POST",
            "/v1/recognise?kk=1",
            "",
            b"",
            400,
            "there is no parameter `kk`: there are file, frame, hand,",
        ),
        ("POST", "/v1/recognise?k=1&k=2", "", b"", 400, "k is given more than once"),
        ("POST", "/v1/recognise", "Content-Type: multipart/form-data\r\n", b"", 400, "names no boundary"),
        ("POST", "/v1/recognise", &kind, &doubled, 400, "the form has more than one picture"),
        ("POST", "/v1/recognise", &kind, &doubled[..200], 400, "the form ends within a part"),
        (
            "GET",
            "/v1/neighbours/x/thumbnail.png",
            "",
            b"",
            400,
            "`x` is no entry: its number is an integer from 0",
        ),
        ("GET", "/v1/neighbours/%ff/thumbnail.png", "", b"", 400, "is no entry"),
        ("GET", "/v1/neighbours/1/thumbnail.png?generation=x", "", b"", 400, "generation is `x`: an integer"),
        ("POST", "/v1/search", "", b"{\"descriptors\": [[1, 2", 400, "malformed at line 1, column 22"),
        ("POST", "/v1/search", "", b"[1]", 400, "{\"descriptors\": [[...], ...]} is needed"),
        ("POST", "/v1/search", "", b"{\"descriptors\": [[1]]}", 400, "descriptors[0] has 1 values"),
        (
            "POST",
            "/v1/search",
            "",
            format!("{{\"descriptors\": [[{row}], [0, \"1\"]]}}").as_bytes(),
            400,
            "descriptors[1][1] is no number",
        ),
        ("GET", "/nowhere", "", b"", 404, "/docs says what is"),
        ("GET", "/v1/recognise", "", b"", 405, "the header Allow says"),
        ("DELETE", "/", "", b"", 405, "the header Allow says"),
    ] {
        let answer = service.send(&request(method, path, headers, body));
        let message = answer.json()["error"]["message"].as_str().unwrap().to_owned();
        assert!(
            answer.status == status && message.contains(says),
            "{method} {path}: {} {message}",
            answer.status
        );
        assert!(!RAW.iter().any(|word| message.contains(word)), "{message}");
        let allowed = (status == 405).then_some(if path == "/" { "GET,HEAD" } else { "POST" });
        assert_eq!(answer.header("allow"), allowed, "{method} {path}");
    }
    // What is too large by its own word is refused before it is sent.
    let head = b"POST /v1/recognise HTTP/1.1\r\nHost: localhost\r\nContent-Length: 20000001\r\nExpect: 100-continue\r\n\r\n";
    let answer = service.send(head);
    assert_eq!((answer.status, &answer.json()["error"]["kind"]), (413, &"too_large".into()));
}

#[test]
fn requests_under_way_are_finished_before_the_end() {
    let mut service = serve(&[]);
    let picture = sample("camera/09-pinch.jpg");
    let mut first = half(&service, &picture);
    service.signal("TERM");
    service.wait_until("readiness to end", |service| service.get("/readyz").status == 503);
    assert_eq!(service.get("/readyz").json()["state"], "draining");
    assert_eq!(service.post("/v1/recognise", &picture).status, 503, "no more is begun");
    first.write_all(&picture[picture.len() - picture.len() / 2..]).unwrap();
    assert_eq!(Response::read(&mut first).unwrap().status, 200);
    assert_eq!(service.wait(), 0);

    let mut interrupted = serve(&[]);
    interrupted.signal("INT");
    assert_eq!(interrupted.wait(), 130);

    let mut impatient = serve(&["--drain", "0.2"]);
    let _never_sent = half(&impatient, &picture);
    impatient.signal("TERM");
    assert_eq!(impatient.wait(), 2);
    assert!(impatient.line().contains("1 request was cut short"));
}

#[test]
fn beyond_this_machine_a_token_is_needed() {
    let folder = tempfile::tempdir().unwrap();
    let refused =
        run(program("grasp-query").args(["serve", "--listen", "0.0.0.0:0", "--index"]).arg(small_index()));
    assert!(refused.status == 2 && refused.stderr.contains("--token-file"), "{}", refused.stderr);
    let token = folder.path().join("token");
    for bad in ["", "short", "a token of several words, which is none", "with-a-semicolon;-----------"] {
        std::fs::write(&token, bad).unwrap();
        let refused = run(program("grasp-query")
            .args(["serve", "--token-file"])
            .arg(&token)
            .arg("--index")
            .arg(small_index()));
        assert!(refused.status == 2 && refused.stderr.contains("holds no token"), "{}", refused.stderr);
    }
    std::fs::write(&token, "0123456789abcdef\n").unwrap();
    let index = folder.path().join("grasp.idx");
    std::fs::copy(small_index(), &index).unwrap();
    let mut command = program("grasp-query");
    command.args(["serve", "--listen", "0.0.0.0:0", "--poll", "0.01", "--token-file"]).arg(&token);
    let service = Service::of(command.arg("--index").arg(&index));
    let ask = |path: &str, headers: &str| service.send(&request("GET", path, headers, b""));
    let right = "Authorization: Bearer 0123456789abcdef\r\n";
    for (path, status) in [
        ("/v1/index", 200),
        ("/metrics", 200),
        ("/v1/neighbours/0/thumbnail.png", 200),
        ("/session", 405),
        // Whatever is not named as open is closed, also what is not there.
        ("/quiz/", 404),
        ("/healthz/", 404),
        ("/nowhere", 404),
    ] {
        let answer = ask(path, "");
        assert_eq!((answer.status, answer.header("www-authenticate")), (401, Some("Bearer")), "{path}");
        assert_eq!(ask(path, "Authorization: Bearer 0123456789abcdeX\r\n").status, 401, "{path}");
        assert_eq!(ask(path, right).status, status, "{path}");
    }
    for path in ["/", "/page.js", "/healthz", "/readyz", "/docs", "/openapi.json"] {
        assert_eq!(ask(path, "").status, 200, "{path}");
    }
    // What anybody may read names no file of this machine.
    let broken = folder.path().join("broken");
    std::fs::write(&broken, "no index").unwrap();
    std::fs::rename(&broken, &index).unwrap();
    service.wait_until("the failure", |_| !ask("/readyz", "").json()["problem"].is_null());
    let ready = ask("/readyz", "").text();
    assert!(!ready.contains(folder.path().to_str().unwrap()) && !ready.contains("grasp.idx"), "{ready}");
    let wrong = request("POST", "/session", "Authorization: Bearer wrong\r\n", b"");
    assert_eq!(service.send(&wrong).status, 401);
    let session =
        service.send(&request("POST", "/session", "Authorization: Bearer 0123456789abcdef\r\n", b""));
    let cookie = session.header("set-cookie").unwrap();
    assert!(cookie.contains("HttpOnly") && cookie.contains("SameSite=Strict"), "{cookie}");
    let shown = format!("Cookie: {}\r\n", cookie.split(';').next().unwrap());
    assert_eq!(ask("/v1/index", &shown).status, 200);
}

#[test]
fn a_socket_serves_its_own_user_and_is_taken_over_from_the_dead() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("grasp.sock");
    let start = || serve(&["--unix", path.to_str().unwrap()]);
    let ask = || {
        let mut stream = UnixStream::connect(&path).unwrap();
        stream.write_all(&request("GET", "/healthz", "", b"")).unwrap();
        Response::read(&mut stream).unwrap().status
    };
    let mut first = start();
    assert_eq!(ask(), 200);
    assert_eq!(std::fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
    let second =
        run(program("grasp-query").args(["serve", "--unix"]).arg(&path).arg("--index").arg(small_index()));
    assert!(second.status == 2 && second.stderr.contains("another service answers"), "{}", second.stderr);
    first.signal("KILL");
    first.wait();
    assert!(path.exists());
    let mut third = start();
    assert_eq!(ask(), 200);
    third.signal("TERM");
    assert_eq!(third.wait(), 0);
    assert!(!path.exists());
    let occupied: &Path = &workspace().join("Cargo.toml");
    let refused =
        run(program("grasp-query").args(["serve", "--unix"]).arg(occupied).arg("--index").arg(small_index()));
    assert_eq!(refused.status, 2);
    assert!(occupied.is_file());
}

#[test]
fn the_quiz_lives_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let labels = pictures().join("labels.csv");
    let answers = folder.path().join("answers.csv");
    let service = serve(&["--quiz", labels.to_str().unwrap(), "--quiz-out", answers.to_str().unwrap()]);
    assert_eq!(service.get("/v1/index").json()["quiz"], true);
    assert_eq!(service.get("/quiz").header("location"), Some("/quiz/"));
    assert!(service.get("/quiz/").text().contains("quiz.js"));
    assert_eq!(service.get("/quiz/state").json()["answered"], 0);
    let answer = request(
        "POST",
        "/quiz/answer",
        "Content-Type: application/json\r\n",
        b"{\"picture\":0,\"answer\":1}",
    );
    assert_eq!(service.send(&answer).json()["answered"], 1);
    assert_eq!(std::fs::read_to_string(&answers).unwrap().lines().count(), 2);
    assert_eq!(serve(&[]).get("/quiz/").status, 404);
}

#[test]
fn without_a_sound_index_it_does_not_start() {
    let missing =
        run(program("grasp-query").args(["serve", "--listen", "127.0.0.1:0", "--index", "missing.idx"]));
    assert!(missing.status == 2 && missing.stderr.contains("grasp-builder build"), "{}", missing.stderr);
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("broken.idx");
    std::fs::write(&broken, &std::fs::read(small_index()).unwrap()[..1000]).unwrap();
    let refused =
        run(program("grasp-query").args(["serve", "--listen", "127.0.0.1:0", "--index"]).arg(&broken));
    assert!(refused.status == 2 && refused.stderr.contains("truncated"), "{}", refused.stderr);
}

#[test]
fn a_strategy_that_nobody_should_try_is_no_message() {
    let service = serve(&[]);
    let picture = sample("segmented/10-power-sphere.png");
    let data = workspace().join("query/data/objects");
    let [object, camera] =
        ["bottle.toml", "camera.toml"].map(|name| std::fs::read_to_string(data.join(name)).unwrap());
    let astray = format!("{camera}hand = [-6.0, 2.0, 75.0]\n");
    let path = "/v1/strategy?robot=barrett&segmented=true&hand=right&accept=always";
    let ask = |camera: &str, accept: &str| {
        let parts =
            [("picture", picture.as_slice()), ("object", object.as_bytes()), ("camera", camera.as_bytes())];
        let (kind, body) = form(&parts);
        service.send(&request("POST", path, &format!("{kind}Accept: {accept}\r\n"), &body))
    };
    let record = ask(&astray, "application/json");
    let strategy = &record.json()["strategy"];
    assert_eq!((record.status, record.header("grasp-status")), (200, Some("1")));
    assert_eq!(
        (&strategy["feasible"], &strategy["problems"][0]["kind"]),
        (&false.into(), &"hand_away".into())
    );
    let message = ask(&astray, "application/yaml");
    assert_eq!((message.status, message.header("grasp-status")), (422, Some("1")), "{}", message.text());
    assert!(message.text().contains("not feasible: the hand held something 7"), "{}", message.text());
    assert!(!message.text().contains("grasp_pose"));
}
