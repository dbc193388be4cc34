//! What `grasp-query serve` refuses: nonsense, strangers, strategies that nobody should try.

use crate::serve::{form, sample, serve};
use grasp_tests::service::{Service, request};
use grasp_tests::{program, run, small_index, workspace};

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
        ("rolls=1000000", "1 to 360"),
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
const RAW: [&str; 9] = [
    "out of range",
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
    let searched = |second: &str| format!("{{\"descriptors\": [[{row}], [{second}]]}}").into_bytes();
    let huge = row.replacen("0.5,0.5,0.5", "0.5,0.5,2e15", 1);
    let [object, camera] = ["bottle", "camera"]
        .map(|name| std::fs::read(workspace().join(format!("query/data/objects/{name}.toml"))).unwrap());
    let (strategy, described) = form(&[("picture", &picture), ("object", &object), ("camera", &camera)]);
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
            "/v1/recognise?rolls=999",
            "",
            &picture,
            400,
            "rolls is 999: an integer from 1 to 360 is needed",
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
        (
            "POST",
            "/v1/recognise?segment=landmarks",
            "",
            b"",
            400,
            "segment is `landmarks`: `scene` or `skin` is needed",
        ),
        ("POST", "/v1/search?probes=4294967296", "", b"", 400, "an integer from 1 to 4294967295 is needed"),
        (
            "POST",
            "/v1/recognise",
            "Accept: image/jpeg\r\n",
            &picture,
            406,
            "`image/jpeg`: answers are one of application/json, text/plain, image/png, application/yaml",
        ),
        ("POST", "/v1/recognise", "Accept: application/yaml\r\n", &picture, 400, "say which robot: robot="),
        ("POST", "/v1/strategy?robot=nope", &strategy, &described, 400, "and say robot=described"),
        ("POST", "/v1/strategy?robot=barrett&arm=nope", &strategy, &described, 400, "and say arm=described"),
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
        ("POST", "/v1/search", "", &searched("0, \"1\""), 400, "descriptors[1][1] is no number"),
        ("POST", "/v1/search", "", &searched("0, 1e39"), 400, "descriptors[1][1] is too large"),
        ("POST", "/v1/search", "", &searched(&huge), 400, "descriptors[1][2] is larger than 1e15"),
        ("POST", "/v1/search?exact=true", "", &searched(&huge), 400, "descriptors[1][2] is larger"),
        ("POST", "/v1/search?shortlist=true", "", &searched(&huge), 400, "descriptors[1][2] is larger"),
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
        assert_eq!(ask(path, &right.replace("Bearer", "bearer")).status, status, "{path}");
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
