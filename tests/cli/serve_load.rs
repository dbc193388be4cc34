//! What `grasp-query serve` does with askers who are many, slow or want too much.

use crate::serve::{sample, serve};
use grasp_tests::service::{PATIENCE, Response, Service, request};
use std::io::Write as _;
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

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

#[test]
fn who_asks_nothing_shuts_nobody_out_for_long() {
    let service = serve(&[]);
    // Nothing at all, and no whole head of a request.
    for begun in ["", "GET /healthz HT"] {
        let connect = || {
            let mut stream = service.connect();
            stream.write_all(begun.as_bytes()).unwrap();
            stream
        };
        // As many as there are places.
        let idle: Vec<TcpStream> = std::iter::repeat_with(connect).take(512).collect();
        let started = Instant::now();
        assert_eq!(service.get("/healthz").text(), "ok\n");
        assert!(started.elapsed() < Duration::from_secs(15), "{begun}: {:?}", started.elapsed());
        drop(idle);
    }
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
