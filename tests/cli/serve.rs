//! `grasp-query serve`: the answers of the command line over HTTP.

use grasp_tests::service::{Response, Service, request};
use grasp_tests::{pictures, program, run, small_index, workspace};
use serde_json::Value;
use std::io::Write as _;
use std::os::unix::net::UnixStream;
use std::path::Path;

pub(crate) fn serve(more: &[&str]) -> Service {
    Service::start(|command| {
        command.arg("--index").arg(small_index()).args(more);
    })
}

pub(crate) fn sample(name: &str) -> Vec<u8> {
    std::fs::read(pictures().join(name)).unwrap()
}

/// A form of files, as `curl -F` sends it.
pub(crate) fn form(parts: &[(&str, &[u8])]) -> (String, Vec<u8>) {
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

/// What of a value is not as a schema of `api` says: the few words of JSON Schema that utoipa uses.
fn fault(api: &Value, schema: &Value, value: &Value) -> Option<String> {
    let is_of = |schema: &Value| fault(api, schema, value).is_none();
    let each = |of: &str| schema[of].as_array().into_iter().flatten();
    if let Some(name) = schema["$ref"].as_str() {
        return fault(api, api.pointer(name.trim_start_matches('#')).unwrap(), value);
    }
    let ways = each("oneOf").filter(|schema| is_of(schema)).count();
    if schema["oneOf"].is_array() && ways != 1 {
        return Some(format!("{ways} of oneOf {} for {value}", schema["oneOf"]));
    }
    if schema["anyOf"].is_array() && !each("anyOf").any(is_of) {
        return Some(format!("none of anyOf {} for {value}", schema["anyOf"]));
    }
    if let Some(why) = each("allOf").find_map(|schema| fault(api, schema, value)) {
        return Some(why);
    }
    let is_type = |name: &Value| match name.as_str().unwrap() {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_i64() || value.is_u64(),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        _ => value.is_object(),
    };
    let is_wrong = match &schema["type"] {
        Value::Null => false,
        Value::Array(names) => !names.iter().any(is_type),
        name => !is_type(name),
    };
    if is_wrong || schema["enum"].as_array().is_some_and(|known| !known.contains(value)) {
        return Some(format!("{value} is not of {schema}"));
    }
    if let Some(missing) = each("required").find(|key| value.get(key.as_str().unwrap()).is_none()) {
        return Some(format!("{missing} is missing in {value}"));
    }
    let of_keys = value.as_object().into_iter().flatten();
    let mut of_keys = of_keys.filter_map(|(key, value)| fault(api, schema["properties"].get(key)?, value));
    let of_items = value.as_array().into_iter().flatten();
    let items = schema.get("items").filter(|items| items.is_object());
    of_keys.next().or_else(|| of_items.filter_map(|value| fault(api, items?, value)).next())
}

#[test]
fn answers_are_as_the_description_says() {
    let service = serve(&[]);
    let api = service.get("/openapi.json").json();
    let data = workspace().join("query/data/objects");
    let [bottle, camera] =
        ["bottle.toml", "camera.toml"].map(|name| std::fs::read_to_string(data.join(name)).unwrap());
    let picture = sample("segmented/10-power-sphere.png");
    let strategy = |object: &str| {
        let parts =
            [("picture", picture.as_slice()), ("object", object.as_bytes()), ("camera", camera.as_bytes())];
        let (kind, body) = form(&parts);
        let path = "/v1/strategy?robot=barrett&segmented=true&hand=right&accept=always";
        service.send(&request("POST", path, &kind, &body))
    };
    let feasible = strategy(&bottle);
    // The hand does not open so far: an answer with an error.
    let too_wide = strategy(&bottle.replace("radius = 0.035", "radius = 0.3"));
    let record = too_wide.json();
    assert!(record["grasp"].is_string() && record["error"]["kind"] == "too_wide", "{record}");
    let hand = sample("camera/09-pinch.jpg");
    let schema_of = |path: &str, status: u16| {
        let response = &api["paths"][path]["post"]["responses"][status.to_string()];
        response["content"]["application/json"]["schema"].clone()
    };
    for (path, answer, status) in [
        ("/v1/strategy", feasible, 200),
        ("/v1/strategy", too_wide, 200),
        ("/v1/recognise", service.post("/v1/recognise?timings=true", &hand), 200),
        ("/v1/recognise", service.post("/v1/recognise", &sample("camera/no-hand.jpg")), 422),
        ("/v1/recognise", service.post("/v1/recognise", b"no picture"), 400),
        ("/v1/recognise", service.post("/v1/recognise?k=0", &hand), 400),
    ] {
        let record = answer.json();
        assert_eq!(answer.status, status, "{record}");
        assert_eq!(fault(&api, &schema_of(path, status), &record), None, "{path} {status}");
    }
    let explained = service.post("/v1/recognise?explained=true", &hand).json();
    let schema = &api["components"]["schemas"]["ExplainedRecord"];
    assert_eq!(fault(&api, schema, &explained), None);
    assert!(fault(&api, schema, &record).is_some(), "a record that is not explained is none");
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
