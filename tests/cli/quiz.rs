//! `grasp-query quiz`: a person answers by HTTP, stops, goes on, and is scored beside the program.

use std::collections::HashMap;
use std::fs;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use grasp_tests::{pictures, program, run, small_index};
use serde_json::{Value, json};

/// A quiz that is served, until [`Served::stop`].
struct Served {
    child: Child,
    address: String,
    stderr: BufReader<std::process::ChildStderr>,
}

struct Response {
    status: u16,
    head: String,
    body: Vec<u8>,
}

impl Response {
    fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|error| panic!("{error}: {}", self.text()))
    }

    fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }
}

fn quiz(answers: &Path) -> Command {
    let mut command = program("grasp-query");
    command.arg("quiz").arg(pictures().join("labels.csv")).arg("--out").arg(answers);
    // Not what lies about where the tests run.
    command.current_dir(answers.parent().unwrap());
    command
}

impl Served {
    fn start(command: &mut Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut stderr = BufReader::new(child.stderr.take().unwrap());
        let mut told = String::new();
        let address = loop {
            let mut line = String::new();
            assert!(stderr.read_line(&mut line).unwrap() > 0, "the quiz ended: {told}");
            told += &line;
            if let Some(address) = line.strip_prefix("open http://") {
                break address.split('/').next().unwrap().to_owned();
            }
        };
        Self { child, address, stderr }
    }

    fn send(&self, request: &[u8]) -> Response {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        // A server that refuses early may close before all is written.
        let _ = stream.write_all(request);
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let end = answer.windows(4).position(|bytes| bytes == b"\r\n\r\n").expect("a response has a head");
        let head = String::from_utf8(answer[..end].to_vec()).unwrap();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        Response { status, head, body: answer[end + 4..].to_vec() }
    }

    fn get(&self, path: &str) -> Response {
        self.send(format!("GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").as_bytes())
    }

    fn post(&self, path: &str, body: &str) -> Response {
        let length = body.len();
        self.send(
            format!(
                "POST {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Type: application/json\r\n\
                 Content-Length: {length}\r\n\r\n{body}"
            )
            .as_bytes(),
        )
    }

    fn answer(&self, picture: usize, answer: usize) -> Response {
        self.post("/answer", &json!({"picture": picture, "answer": answer}).to_string())
    }

    /// Ctrl-C; the exit status, standard output and what was still to be read of standard error.
    fn stop(mut self) -> (i32, String, String) {
        let interrupted = Command::new("kill").args(["-INT", &self.child.id().to_string()]).status().unwrap();
        assert!(interrupted.success());
        let (mut stdout, mut stderr) = (String::new(), String::new());
        self.child.stdout.take().unwrap().read_to_string(&mut stdout).unwrap();
        self.stderr.read_to_string(&mut stderr).unwrap();
        (self.child.wait().unwrap().code().unwrap_or(-1), stdout, stderr)
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        // A failed test must leave nothing running.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What each picture of the table shows.
fn labels() -> HashMap<String, String> {
    let mut table = csv::Reader::from_path(pictures().join("labels.csv")).unwrap();
    table.records().map(Result::unwrap).map(|row| (row[0].to_owned(), row[3].to_owned())).collect()
}

#[test]
fn a_person_answers_stops_goes_on_and_is_scored() {
    let folder = tempfile::tempdir().unwrap();
    let answers = folder.path().join("answers.csv");
    let command = || {
        let mut command = quiz(&answers);
        command
            .args(["--where", "kind=segmented", "--json", "--hand", "right", "--index"])
            .arg(small_index());
        command
    };
    let first = Served::start(&mut command());
    assert_eq!(first.get("/state").json()["total"], 6);
    assert_eq!(first.answer(0, 1).json()["answered"], 1);
    assert_eq!(first.answer(1, 1).json()["answered"], 2);
    let again = first.answer(1, 4).json();
    assert_eq!((&again["answered"], &again["last"]), (&json!(2), &json!(4)));
    let second_picture = first.get("/picture/2").body;
    // Killed, not asked: what was answered is there all the same.
    drop(first);

    let second = Served::start(&mut command());
    assert_eq!(
        second.get("/state").json(),
        json!({"total": 6, "answered": 2, "last": 4, "seed": 7, "finished": false})
    );
    assert_eq!(second.get("/picture/2").body, second_picture, "the order is the seed's");
    assert_eq!(second.post("/finish", "{}").status, 409);
    for picture in 2..6 {
        assert_eq!(second.answer(picture, 6).status, 200);
    }
    let result = second.post("/finish", "{}");
    assert_eq!(result.status, 200, "{}", result.text());
    assert_eq!(second.answer(5, 1).status, 409, "the result has been shown");
    assert_eq!(second.get("/state").json()["finished"], true);

    let (status, stdout, stderr) = second.stop();
    assert_eq!((status, stderr.as_str()), (0, ""));
    let printed: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(printed, result.json());

    // Scored by hand: the last answer to each picture counts.
    let mut table = csv::Reader::from_path(&answers).unwrap();
    let given: HashMap<String, String> =
        table.records().map(Result::unwrap).map(|row| (row[0].to_owned(), row[1].to_owned())).collect();
    let labels = labels();
    let right = given.iter().filter(|(file, answer)| labels[*file] == **answer).count();
    assert_eq!(given.len(), 6);
    assert_eq!(printed["person"]["share"]["right"], right);
    let evaluated = run(program("grasp-query")
        .args(["evaluate", "--json", "--hand", "right", "--where", "kind=segmented", "--index"])
        .arg(small_index())
        .arg(pictures().join("labels.csv")));
    assert_eq!(printed["machine"]["confusion"], evaluated.json_lines()[0]["confusion"]);
}

#[test]
fn nothing_tells_a_label_before_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::start(
        quiz(&folder.path().join("answers.csv"))
            .args(["--where", "kind=segmented", "--index"])
            .arg(small_index()),
    );
    let total = served.get("/state").json()["total"].as_u64().unwrap() as usize;
    let files: Vec<String> = labels().into_keys().collect();
    let mut heads = Vec::new();
    let check = |response: &Response| {
        assert_eq!(response.status, 200, "{}", response.text());
        for file in &files {
            let stem = Path::new(file).file_stem().unwrap().to_str().unwrap();
            let told = response.head.contains(stem) || response.text().contains(stem);
            assert!(!told, "{stem} is told");
        }
    };
    for picture in 0..total {
        let response = served.get(&format!("/picture/{picture}"));
        check(&response);
        assert!(response.body.starts_with(b"\x89PNG"));
        // Heads are alike but for the length and the time.
        let head: Vec<String> = response
            .head
            .lines()
            .filter(|line| !line.starts_with("content-length") && !line.starts_with("date"))
            .map(str::to_owned)
            .collect();
        heads.push(head);
        check(&served.get("/state"));
        check(&served.answer(picture, 1));
    }
    assert!(heads.iter().all(|head| *head == heads[0]), "{heads:?}");
    // The page and what it is made of name the grasps, in their fixed order, and no picture.
    for path in ["/", "/quiz.js", "/look.css", "/quiz.css", "/choices"] {
        check(&served.get(path));
        let text = served.get(path).text();
        assert!(!text.contains("http://") && !text.contains("https://"), "{path} reaches out");
    }
}

#[test]
fn hostile_requests_are_refused_and_change_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let served = Served::start(quiz(&folder.path().join("answers.csv")).args(["--limit", "3"]));
    let before = served.get("/state").json();
    for (picture, answer, status) in
        [(0, 0, 422), (0, 7, 422), (1, 1, 409), (3, 1, 404), (usize::MAX, 1, 404), (0, usize::MAX, 422)]
    {
        assert_eq!(served.answer(picture, answer).status, status, "{picture} {answer}");
    }
    for body in [
        "",
        "{",
        "[]",
        "{\"picture\":-1,\"answer\":1}",
        "{\"picture\":0}",
        "{\"picture\":\"0\",\"answer\":1}",
    ] {
        let status = served.post("/answer", body).status;
        assert!((400..500).contains(&status), "{body}: {status}");
    }
    let huge = format!("{{\"picture\":0,\"answer\":1,\"more\":\"{}\"}}", "x".repeat(1 << 20));
    assert_eq!(served.post("/answer", &huge).status, 413);
    for path in [
        "/picture/3",
        "/picture/-1",
        "/picture/x",
        "/picture/99999999999999999999",
        "/../labels.csv",
        "/labels.csv",
    ] {
        let status = served.get(path).status;
        assert!((400..500).contains(&status), "{path}: {status}");
    }
    // Another site cannot answer, nor read the pictures, nor come under a name of its own.
    let answering = "{\"picture\":0,\"answer\":1}";
    for (request, host, origin) in [
        ("POST /answer", "localhost", "Origin: https://example.com\r\n"),
        ("POST /answer", "localhost", "Sec-Fetch-Site: cross-site\r\n"),
        ("POST /finish", "localhost", "Sec-Fetch-Site: same-site\r\n"),
        ("GET /picture/0", "localhost", "Sec-Fetch-Site: cross-site\r\n"),
        ("POST /answer", "example.com", ""),
        ("GET /", "example.com", ""),
    ] {
        let refused = served.send(
            format!(
                "{request} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n{origin}Content-Type: application/json\r\n\
                 Content-Length: {}\r\n\r\n{answering}",
                answering.len()
            )
            .as_bytes(),
        );
        assert_eq!(refused.status, 403, "{request} {host} {origin}");
    }
    let missing = served.get("/picture/x");
    assert!(missing.text().contains("an integer from 0"), "{}", missing.text());
    // Another site's form cannot answer: it cannot send JSON.
    let form = served.send(
        b"POST /answer HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Type: text/plain\r\nContent-Length: 24\r\n\r\n\
          {\"picture\":0,\"answer\":1} ",
    );
    assert_eq!(form.status, 415);
    assert_eq!(served.send(b"nonsense\r\n\r\n").status, 400);
    assert_eq!(served.get("/answer").status, 405);
    assert_eq!(served.get("/state").json(), before);
}

#[test]
fn ctrl_c_prints_the_table_so_far_and_no_index_is_needed() {
    let folder = tempfile::tempdir().unwrap();
    let answers = folder.path().join("answers.csv");
    let served = Served::start(quiz(&answers).args(["--where", "kind=segmented", "--seed", "3"]));
    assert_eq!(served.answer(0, 2).status, 200);
    let (status, stdout, _) = served.stop();
    assert_eq!(status, 130);
    assert!(stdout.starts_with("1 of 6 pictures answered (seed 3)\nperson "), "{stdout}");
    assert!(!stdout.contains("machine  "), "{stdout}");

    let foreign = folder.path().join("labels.csv");
    fs::copy(pictures().join("labels.csv"), &foreign).unwrap();
    let refused = run(&mut quiz(&foreign));
    assert!(
        refused.status == 2 && refused.stderr.contains("is not a table of answers"),
        "{}",
        refused.stderr
    );
    let missing = run(quiz(&answers).args(["--index", "missing.idx"]));
    assert!(missing.status == 2 && missing.stderr.contains("no index at missing.idx"), "{}", missing.stderr);
    let nowhere = run(quiz(&answers).args(["--listen", "203.0.113.1:80"]));
    assert!(nowhere.status == 2 && nowhere.stderr.contains("--listen"), "{}", nowhere.stderr);
    let labels = pictures().join("labels.csv");
    let itself = run(program("grasp-query").arg("quiz").arg(&labels).arg("--out").arg(&labels));
    assert!(itself.status == 2 && itself.stderr.contains("is an input as well"), "{}", itself.stderr);
}
