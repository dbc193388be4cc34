//! How much a service bears: `cargo run --release --bin load [SECONDS]` starts one on this machine,
//! asks it from several connections for so long, and prints a table. Asking takes part of the same
//! processors' time.

use std::error::Error;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::process::Command;
use std::time::{Duration, Instant};

use grasp_tests::service::Service;
use grasp_tests::{Build, pictures, programs};

type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// Connections at a time: one for each core, and as many that wait.
const CONNECTIONS: usize = 4;

fn main() -> Outcome<()> {
    let seconds: u64 = std::env::args().nth(1).map_or(Ok(20), |text| text.parse())?;
    let folder = tempfile::tempdir()?;
    let (index, queries) = (folder.path().join("grasp.idx"), folder.path().join("q.npy"));
    let builder = || Command::new(programs(Build::Release).join("grasp-builder"));
    run(builder().args(["build", "--no-progress", "--out"]).arg(&index))?;
    run(builder().args(["queries", "--no-progress", "--count", "100", "--out"]).arg(&queries))?;
    let mut serve = Command::new(programs(Build::Release).join("grasp-query"));
    let service = Service::of(serve.args(["serve", "--listen", "127.0.0.1:0", "--index"]).arg(&index));

    let camera = std::fs::read(pictures().join("camera/09-pinch.jpg"))?;
    let segmented = std::fs::read(pictures().join("segmented/09-pinch.png"))?;
    let all = std::fs::read(&queries)?;
    let dim = service.get("/v1/index").json()["dim"].as_u64().ok_or("no dim")? as usize;
    let one = one_row(&all, dim);
    let kinds = [
        ("camera picture, 640 x 480 JPEG", "/v1/recognise", camera.as_slice(), 1),
        ("segmented picture, 256 x 192 PNG", "/v1/recognise?segmented=true", &segmented, 1),
        ("a descriptor", "/v1/search", &one, 1),
        ("a hundred descriptors", "/v1/search", &all, 100),
    ];
    println!(
        "| {CONNECTIONS} connections, {seconds} s each | requests/s | p50 ms | p99 ms | memory before / after, MB |"
    );
    println!("|---|---|---|---|---|");
    for (name, path, body, each) in kinds {
        // Once through, so that what is mapped is in memory.
        ask_for(&service, path, body, Duration::from_secs(1))?;
        let before = memory(&service)?;
        let started = Instant::now();
        let mut took = ask_for(&service, path, body, Duration::from_secs(seconds))?;
        let rate = took.len() as f64 / started.elapsed().as_secs_f64();
        took.sort_unstable();
        let at = |share: f64| {
            took.get((share * took.len() as f64) as usize).map_or(f64::NAN, |took| took.as_secs_f64() * 1e3)
        };
        let (p50, p99, after) = (at(0.5), at(0.99), memory(&service)?);
        let of_each =
            if each > 1 { format!(" ({:.0} descriptors/s)", rate * f64::from(each)) } else { String::new() };
        println!("| {name} | {rate:.0}{of_each} | {p50:.2} | {p99:.2} | {before:.0} / {after:.0} |");
    }
    Ok(())
}

fn run(command: &mut Command) -> Outcome<()> {
    let output = command.output()?;
    if output.status.success() { Ok(()) } else { Err(String::from_utf8_lossy(&output.stderr).into()) }
}

/// The last row of an array, as JSON.
fn one_row(array: &[u8], dim: usize) -> Vec<u8> {
    let row = &array[array.len() - 4 * dim..];
    let values: Vec<f32> =
        row.chunks_exact(4).map(|v| f32::from_le_bytes([v[0], v[1], v[2], v[3]])).collect();
    serde_json::json!({ "descriptors": [values] }).to_string().into_bytes()
}

/// The service's resident memory in megabytes.
fn memory(service: &Service) -> Outcome<f64> {
    let status = std::fs::read_to_string(format!("/proc/{}/status", service.id()))?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).ok_or("no VmRSS")?;
    Ok(line.trim().trim_end_matches(" kB").parse::<f64>()? / 1e3)
}

/// Asks from all connections for so long; how long each answer took.
fn ask_for(service: &Service, path: &str, body: &[u8], long: Duration) -> Outcome<Vec<Duration>> {
    let head = format!("POST {path} HTTP/1.1\r\nHost: localhost\r\nContent-Length: {}\r\n\r\n", body.len());
    let request = [head.as_bytes(), body].concat();
    let ask = || -> Outcome<Vec<Duration>> {
        let mut stream = TcpStream::connect(service.address())?;
        stream.set_nodelay(true)?;
        let mut answers = BufReader::new(stream.try_clone()?);
        let (started, mut took) = (Instant::now(), Vec::new());
        while started.elapsed() < long {
            let asked = Instant::now();
            stream.write_all(&request)?;
            let mut length = 0;
            let mut line = String::new();
            loop {
                line.clear();
                answers.read_line(&mut line)?;
                if line.starts_with("HTTP/1.1 ") && !line.starts_with("HTTP/1.1 200") {
                    return Err(line.into());
                }
                if let Some(value) = line.strip_prefix("content-length: ") {
                    length = value.trim().parse()?;
                }
                if line == "\r\n" {
                    break;
                }
            }
            std::io::copy(&mut (&mut answers).take(length), &mut std::io::sink())?;
            took.push(asked.elapsed());
        }
        Ok(took)
    };
    std::thread::scope(|scope| {
        let askers: Vec<_> = (0..CONNECTIONS).map(|_| scope.spawn(ask)).collect();
        let mut all = Vec::new();
        for asker in askers {
            all.extend(asker.join().map_err(|_| "a connection panicked")??);
        }
        Ok(all)
    })
}
