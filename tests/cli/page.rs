//! The page of `grasp-query serve` in a real browser: a picture is dropped, the answer is read, the
//! neighbours are seen.
//!
//! `SCREENSHOTS=DIR` keeps what it looks like. Where no Chromium is installed (`CHROMIUM` names
//! another), nothing is tested.

use std::path::PathBuf;
use std::process::Command;

use grasp_tests::browser::Browser;
use grasp_tests::service::Service;
use grasp_tests::{pictures, program, run, small_index};

fn start() -> Option<(Service, Browser)> {
    start_with(&[])
}

fn start_with(options: &[String]) -> Option<(Service, Browser)> {
    let Some(browser) = Browser::start_with(options) else {
        eprintln!("skipped: no Chromium is installed, and CHROMIUM names none");
        return None;
    };
    let index = std::env::var_os("SCREENSHOTS_INDEX").map_or_else(|| small_index().to_owned(), PathBuf::from);
    let service = Service::start(|command| {
        command.arg("--index").arg(index);
    });
    Some((service, browser))
}

fn keep(browser: &mut Browser, name: &str) {
    let Some(folder) = std::env::var_os("SCREENSHOTS") else { return };
    let path = PathBuf::from(folder).join(name);
    let decoded = Command::new("sh")
        .args(["-c", "base64 -d > \"$0\""])
        .arg(path)
        .stdin(std::process::Stdio::piped())
        .spawn()
        .and_then(|mut child| {
            let mut input = child.stdin.take().expect("a pipe");
            std::io::Write::write_all(&mut input, browser.screenshot().as_bytes())?;
            drop(input);
            child.wait()
        });
    assert!(decoded.unwrap().success());
}

/// Every picture that is shown is there.
const PICTURES_ARE_THERE: &str = "[...document.images].filter((i) => !i.hidden && i.checkVisibility()).every((i) => i.complete && i.naturalWidth > 0)";

#[test]
fn a_dropped_picture_is_answered_with_its_neighbours() {
    let Some((service, mut browser)) = start() else { return };
    browser.look_like(1200, 900, "light");
    browser.open(&format!("http://{}/", service.address()));
    browser.wait_for("document.getElementById('about').textContent.includes('6 grasps')");
    browser.drop_file("#drop", &pictures().join("camera/12-precision-disc.jpg"));
    browser.wait_for("!document.getElementById('answer').hidden");
    browser.wait_for(PICTURES_ARE_THERE);

    // What is read is what the service says.
    let answer = service
        .post("/v1/recognise", &std::fs::read(pictures().join("camera/12-precision-disc.jpg")).unwrap())
        .json();
    let grasp = answer["grasp"].as_str().unwrap().replace('-', " ");
    let verdict = browser.evaluate("document.getElementById('verdict').textContent");
    assert!(verdict.as_str().unwrap().starts_with(&grasp), "{verdict}");
    let neighbours = browser.evaluate(
        "[...document.querySelectorAll('#neighbours li')].map((li) => [li.querySelector('strong').textContent, li.querySelector('img').alt, li.querySelector('svg').getAttribute('aria-label')])",
    );
    let expected = answer["neighbours"].as_array().unwrap();
    assert_eq!(neighbours.as_array().unwrap().len(), expected.len().min(12));
    for (seen, entry) in neighbours.as_array().unwrap().iter().zip(expected) {
        let name = entry["grasp"].as_str().unwrap().replace('-', " ");
        assert_eq!(seen[0], name.as_str());
        assert!(
            seen[1].as_str().unwrap().starts_with(&name) && seen[2].as_str().unwrap().starts_with("fingers "),
            "{seen}"
        );
    }
    let shares = browser.evaluate("document.querySelectorAll('#classes tbody tr').length");
    assert_eq!(shares, answer["classes"].as_array().unwrap().len());

    // Each bar begins beside the longest label, and not across the page.
    let apart = "(() => { const label = (row) => { const range = document.createRange(); range.selectNodeContents(row.querySelector('th')); return range.getBoundingClientRect().right; }; const rows = [...document.querySelectorAll('#classes tbody tr')]; return rows[0].querySelector('.bar').getBoundingClientRect().left - Math.max(...rows.map(label)); })()";
    let apart = browser.evaluate(apart).as_f64().unwrap();
    assert!((0.0..40.0).contains(&apart), "the bars begin {apart} pixels after the labels");

    // The hand is drawn, and the keyboard turns it.
    let drawn = "(() => { const c = document.getElementById('hand'); const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let n = 0, h = 0; for (let i = 3; i < d.length; i += 4) if (d[i]) { n++; h = (31 * h + i + d[i - 1]) % 1000000007; } return [n, h]; })()";
    let before = browser.evaluate(drawn);
    assert!(before[0].as_u64().unwrap() > 5_000, "{before}");
    browser.evaluate("document.getElementById('hand').focus()");
    browser.press("ArrowLeft", 37);
    let turned = browser.evaluate(drawn);
    assert_ne!(turned, before);
    browser.press("Home", 36);
    assert_eq!(browser.evaluate(drawn), before);
    keep(&mut browser, "page.png");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);

    // What makes an answer doubtful stands beside it, in the words of the page.
    browser.evaluate("(async () => { const record = await (await request(current)).json(); record.warnings = [{ kind: 'hand_ambiguous', message: 'it may as well be the other hand: say which it is' }]; show(current, record); })()");
    let warnings = browser.evaluate("document.getElementById('warnings').innerText");
    assert_eq!(warnings, "it may as well be the other hand: say which it is above, under “Hand”");

    // On a phone, in the dark, nothing runs out of the side, and what explains the answer waits to
    // be asked for.
    assert_eq!(browser.evaluate(FOLDED), serde_json::json!([false, false]));
    browser.look_like(390, 844, "dark");
    browser.wait_for("document.querySelectorAll('details.fold:not([open])').length === 2");
    assert_eq!(browser.evaluate("document.documentElement.scrollWidth <= innerWidth"), true);
    assert_eq!(browser.evaluate("document.querySelector('#neighbours').checkVisibility()"), false);
    keep(&mut browser, "page-dark.png");
}

/// Whether the neighbours and the descriptor are folded.
const FOLDED: &str = "[...document.querySelectorAll('details.fold')].map((details) => !details.open)";

#[test]
fn an_empty_page_shows_the_grasps_and_a_sample_is_answered_by_a_key() {
    let Some((service, mut browser)) = start() else { return };
    browser.look_like(1200, 900, "light");
    let address = format!("http://{}/", service.address());
    browser.open(&address);
    browser.wait_for("document.querySelectorAll('#grasps li').length === 6");
    let purpose = browser.evaluate("document.getElementById('purpose').innerText");
    assert!(purpose.as_str().unwrap().contains("names the grasp"), "{purpose}");
    // Each grasp is a picture with a hand and an object in it.
    let colours = "[...document.querySelectorAll('#grasps canvas')].map((c) => { const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let [hand, thing] = [0, 0]; for (let i = 0; i < d.length; i += 4) if (d[i + 3]) d[i] > d[i + 2] ? hand++ : thing++; return [hand, thing]; })";
    for counts in browser.evaluate(colours).as_array().unwrap() {
        assert!(counts[0].as_u64() > Some(5_000) && counts[1].as_u64() > Some(100), "{counts}");
    }
    browser.wait_for(PICTURES_ARE_THERE);
    keep(&mut browser, "page-empty.png");
    browser.look_like(390, 844, "dark");
    assert_eq!(browser.evaluate("document.documentElement.scrollWidth <= innerWidth"), true);
    keep(&mut browser, "page-empty-dark.png");

    browser.evaluate("document.querySelector('button.sample').focus()");
    browser.press(" ", 32);
    browser.wait_for("!document.getElementById('answer').hidden");
    browser.wait_for(PICTURES_ARE_THERE);
    assert_eq!(browser.evaluate("document.getElementById('known').open"), false);
    let elsewhere = format!(
        "performance.getEntriesByType('resource').map((e) => e.name).filter((name) => !name.startsWith('{address}') && !/^(data|blob):/.test(name))"
    );
    assert_eq!(browser.evaluate(&elsewhere), serde_json::json!([]), "loaded from elsewhere");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn masks_and_depth_pictures_are_sent_as_the_command_line_sends_them() {
    let Some((service, mut browser)) = start() else { return };
    browser.look_like(1200, 900, "light");
    browser.open(&format!("http://{}/", service.address()));
    let folder = tempfile::tempdir().unwrap();
    let mask = image::open(pictures().join("mask/09-pinch.png")).unwrap().into_luma8();
    let depth = image::ImageBuffer::from_fn(mask.width(), mask.height(), |x, y| {
        image::Luma([if mask.get_pixel(x, y).0[0] > 127 { 600u16 } else { 2000 }])
    });
    let depth_file = folder.path().join("depth.png");
    depth.save(&depth_file).unwrap();
    let nearest =
        "JSON.parse(document.getElementById('record').textContent || '{}').neighbours?.[0].distance";
    let choose = |source: &str| {
        format!(
            "(() => {{ const s = document.getElementById('source'); s.value = '{source}'; s.dispatchEvent(new Event('change')); }})()"
        )
    };
    browser.evaluate(&choose("mask"));
    browser.drop_file("#drop", &pictures().join("segmented/09-pinch.png"));
    browser.wait_for("document.getElementById('busy').textContent.includes('mask')");
    browser.choose_file("#mask-file", &pictures().join("mask/09-pinch.png"));
    browser.wait_for("!document.getElementById('answer').hidden");
    let by_command = |option: &[&str]| {
        let mut command = program("grasp-query");
        command.args(["recognise", "--json", "--index"]).arg(small_index());
        let outcome = run(command.arg(pictures().join("segmented/09-pinch.png")).args(option));
        outcome.json_lines()[0]["neighbours"][0]["distance"].clone()
    };
    let mask_file = pictures().join("mask/09-pinch.png");
    assert_eq!(browser.evaluate(nearest), by_command(&["--mask", mask_file.to_str().unwrap()]));

    browser.evaluate(&choose("depth"));
    browser.choose_file("#depth-file", &depth_file);
    browser.evaluate("document.getElementById('answer').hidden = true");
    browser.evaluate("for (const [id, value] of [['near', 400], ['far', 900]]) { document.getElementById(id).value = value; document.getElementById(id).dispatchEvent(new Event('change')); }");
    browser.wait_for("!document.getElementById('answer').hidden");
    let depth_options = ["--depth", depth_file.to_str().unwrap(), "--depth-range", "400..900"];
    assert_eq!(browser.evaluate(nearest), by_command(&depth_options));

    // A range with nothing in it: no hand, in words that a page's visitor can do something about.
    browser.evaluate("document.getElementById('far').value = 401; document.getElementById('far').dispatchEvent(new Event('change'))");
    browser.wait_for("!document.getElementById('problem').hidden");
    let said = browser.evaluate("document.getElementById('unanswered').innerText");
    assert!(said.as_str().unwrap().contains("between the two distances"), "{said}");
    assert!(!said.as_str().unwrap().contains("--"), "{said}");
}

/// Counts the requests for answers: how many were begun, and how many were under way at once at
/// most.
const COUNT_REQUESTS: &str = "(() => { const real = fetch; window.seen = { begun: 0, now: 0, most: 0 }; window.fetch = async (path, options) => { if (!String(path).startsWith('v1/recognise')) return real(path, options); seen.begun++; seen.now++; seen.most = Math.max(seen.most, seen.now); try { return await real(path, options); } finally { seen.now--; } }; })()";

#[test]
fn a_live_camera_is_answered_one_frame_at_a_time_until_it_is_stopped() {
    // The camera of this browser shows a hand: a film of one picture.
    let folder = tempfile::tempdir().unwrap();
    let film = folder.path().join("film.mjpeg");
    let picture = std::fs::read(pictures().join("camera/01-large-diameter.jpg")).unwrap();
    std::fs::write(&film, picture.repeat(10)).unwrap();
    let option = format!("--use-file-for-fake-video-capture={}", film.display());
    let Some((service, mut browser)) = start_with(&[option]) else { return };
    browser.look_like(1200, 900, "light");
    browser.open(&format!("http://{}/", service.address()));
    browser.evaluate(COUNT_REQUESTS);
    browser.evaluate("document.getElementById('camera').click()");
    browser.wait_for("document.getElementById('video').videoWidth > 0");
    browser.evaluate("document.getElementById('live').click()");
    browser.wait_for("seen.begun >= 4 && document.querySelector('#live-words strong') !== null");
    let words = browser.evaluate("document.querySelector('#live-words strong').textContent");
    let answer = service.post("/v1/recognise", &picture).json();
    assert_eq!(words, answer["grasp"].as_str().unwrap().replace('-', " "));
    let drawn = "(() => { const c = document.getElementById('overlay'); const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let n = 0; for (let i = 3; i < d.length; i += 4) if (d[i]) n++; return n; })()";
    assert!(browser.evaluate(drawn).as_u64() > Some(1_000), "nothing is drawn over the picture");
    // What is drawn lies where the video is.
    let boxes = "['video', 'overlay'].map((id) => { const b = document.getElementById(id).getBoundingClientRect(); return [b.left, b.top, b.width, b.height].map(Math.round).join(); })";
    let boxes = browser.evaluate(boxes);
    assert_eq!(boxes[0], boxes[1]);
    keep(&mut browser, "page-live.png");

    browser.evaluate("document.getElementById('live').click()");
    browser.wait_for("seen.now === 0");
    let stopped = browser.evaluate("seen.begun");
    std::thread::sleep(std::time::Duration::from_millis(400));
    assert_eq!(browser.evaluate("[seen.begun, seen.most]"), serde_json::json!([stopped, 1]));
    assert_eq!(browser.evaluate(drawn), 0, "an answer stays on a picture that it is not of");
    browser.evaluate("window.track = stream.getTracks()[0]; document.getElementById('leave').click()");
    assert_eq!(browser.evaluate("track.readyState"), "ended");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn a_page_that_gets_no_camera_says_why_and_what_to_do() {
    // Under the name of another machine, over plain HTTP: no camera, and a token is needed.
    let folder = tempfile::tempdir().unwrap();
    let token = folder.path().join("token");
    std::fs::write(&token, "sesame-and-a-good-deal-more-of-it").unwrap();
    let rules = "--host-resolver-rules=MAP hand.test 127.0.0.1".to_owned();
    let Some(mut browser) = Browser::start_with(&[rules]) else { return };
    let service = Service::start(|command| {
        command.arg("--index").arg(small_index()).arg("--token-file").arg(&token);
    });
    let port = service.address().rsplit_once(':').unwrap().1.to_owned();
    browser.look_like(1200, 900, "light");
    browser.open(&format!("http://hand.test:{port}/"));
    browser.evaluate("document.getElementById('camera').click()");
    browser.wait_for("!document.getElementById('problem').hidden");
    let said = browser.evaluate("document.getElementById('unanswered').innerText");
    let said = said.as_str().unwrap();
    for needed in
        ["unencrypted", "https://", &format!("ssh -L 8750:localhost:{port} hand.test"), "Choose a picture"]
    {
        assert!(said.contains(needed), "{needed}: {said}");
    }
}

#[test]
fn everything_can_be_done_by_keyboard_and_has_a_name() {
    let Some((service, mut browser)) = start() else { return };
    browser.look_like(1200, 900, "dark");
    browser.open(&format!("http://{}/", service.address()));
    browser.drop_file("#drop", &pictures().join("camera/no-hand.jpg"));
    browser.wait_for("!document.getElementById('problem').hidden");
    // The picture stays in sight, with why there is no answer and what may help: no word of options
    // of the command line.
    browser.wait_for("document.getElementById('rejected').naturalWidth === 640");
    let problem = browser.evaluate("document.getElementById('unanswered').innerText");
    let problem = problem.as_str().unwrap();
    assert!(problem.contains("No hand found") && problem.contains("by a mask"), "{problem}");
    assert!(!problem.contains("--"), "{problem}");
    assert_eq!(browser.evaluate("document.getElementById('answer').hidden"), true);
    keep(&mut browser, "page-no-hand-dark.png");
    browser.complaints.clear();

    let mut reached = Vec::new();
    for _ in 0..16 {
        browser.press("Tab", 9);
        reached.push(browser.evaluate("document.activeElement.id || document.activeElement.tagName"));
    }
    for id in ["choose", "camera", "side", "source"] {
        assert!(reached.iter().any(|found| found == id), "{id} is not reached: {reached:?}");
    }
    // What assistive technology is told: every control has a name.
    let nodes = browser.call("Accessibility.getFullAXTree", serde_json::json!({}));
    for node in nodes["nodes"].as_array().unwrap() {
        let role = node["role"]["value"].as_str().unwrap_or_default();
        if ["button", "link", "combobox", "checkbox", "textbox", "img"].contains(&role)
            && node["ignored"] != true
        {
            assert_ne!(node["name"]["value"].as_str().unwrap_or_default(), "", "{node}");
        }
    }
}

#[test]
fn the_camera_takes_a_picture_and_the_robot_is_shown_what_to_do() {
    let Some((service, mut browser)) = start() else { return };
    browser.look_like(1200, 900, "light");
    browser.open(&format!("http://{}/", service.address()));
    browser.evaluate("document.getElementById('camera').click()");
    browser.wait_for("document.getElementById('video').videoWidth > 0");
    browser.evaluate("document.getElementById('take').click()");
    // The browser's own test picture shows no hand, or something that could be one: an answer
    // either way.
    browser
        .wait_for("!document.getElementById('problem').hidden || !document.getElementById('answer').hidden");
    browser.evaluate("document.getElementById('leave').click()");
    browser.complaints.clear();

    browser.evaluate("document.getElementById('robot-choice').open = true");
    browser.wait_for("document.getElementById('object').value.includes('radius') && document.getElementById('camera-pose').value.includes('position')");
    browser.evaluate("document.getElementById('robot').value = 'barrett'");
    browser.drop_file("#drop", &pictures().join("camera/01-large-diameter.jpg"));
    browser.wait_for("document.querySelectorAll('#steps li').length > 0");
    let steps = browser.evaluate("document.getElementById('strategy').innerText");
    let form_less = service.post("/v1/strategy", b"");
    assert_eq!(form_less.status, 400, "{}", form_less.text());
    assert!(!steps.as_str().unwrap().is_empty());
    keep(&mut browser, "page-robot.png");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

/// A box that is turned by 30 degrees about the vertical.
const TURNED_BOX: &str = "name = 'box'\\nshape = 'box'\\nsize = [0.16, 0.06, 0.10]\\nposition = [0.5, 0.1, 0.05]\\nquaternion_xyzw = [0, 0, 0.25881905, 0.96592583]\\ntable = 0\\n";

/// The points of a drawn area or way: x to the right, y up, in pixels.
fn points(browser: &mut Browser, selector: &str) -> Vec<[f64; 2]> {
    let list = browser.evaluate(&format!("document.querySelector('{selector}').getAttribute('points')"));
    let pair = |pair: &str| {
        let (x, y) = pair.split_once(',').unwrap();
        [x.parse().unwrap(), -y.parse::<f64>().unwrap()]
    };
    list.as_str().unwrap_or_else(|| panic!("{selector} is not drawn")).split(' ').map(pair).collect()
}

#[test]
fn a_turned_box_and_the_palm_are_drawn_where_they_are() {
    let Some((service, mut browser)) = start() else { return };
    browser.look_like(1200, 900, "light");
    browser.open(&format!("http://{}/", service.address()));
    browser.evaluate("document.getElementById('robot-choice').open = true");
    browser.wait_for("document.getElementById('object').value.includes('radius') && document.getElementById('camera-pose').value.includes('position')");
    browser.evaluate(&format!("document.getElementById('object').value = \"{TURNED_BOX}\""));
    browser.evaluate(
        "document.getElementById('robot').value = 'barrett'; document.getElementById('side').value = 'right'",
    );
    browser.drop_file("#drop", &pictures().join("camera/01-large-diameter.jpg"));
    browser.wait_for("document.querySelectorAll('#strategy-picture .thing').length === 2");
    let record = browser.evaluate("JSON.parse(document.getElementById('record').textContent)");
    let strategy = &record["strategy"];
    let number = |value: &serde_json::Value| value.as_f64().unwrap();

    // From above: a rectangle of the box's sides, turned in the world as the box is.
    let above = points(&mut browser, "#strategy-picture svg:nth-of-type(2) .thing");
    assert_eq!(above.len(), 4, "{above:?}");
    let sides: Vec<[f64; 2]> =
        (0..4).map(|at| [0, 1].map(|axis| above[(at + 1) % 4][axis] - above[at][axis])).collect();
    let long = sides.iter().max_by(|a, b| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1]))).unwrap();
    let scale = long[0].hypot(long[1]) / 0.16;
    let shortest = sides.iter().map(|[x, y]| x.hypot(*y)).fold(f64::MAX, f64::min);
    assert!((shortest - 0.06 * scale).abs() < 0.1, "{sides:?}");
    let right = &strategy["layout"]["views"][1]["right"];
    let turn = number(&right[1]).atan2(number(&right[0]));
    let off = (long[1].atan2(long[0]) + turn - 30f64.to_radians()).rem_euclid(std::f64::consts::PI);
    assert!(!(0.01..=std::f64::consts::PI - 0.01).contains(&off), "{off} rad off in {above:?}");

    // The way ends in the palm, which is beside the box's middle as its pose in the world says.
    let way = points(&mut browser, "#strategy-picture svg:nth-of-type(2) .way");
    let middle = [0, 1].map(|axis| above.iter().map(|point| point[axis]).sum::<f64>() / 4.0);
    let drawn = [0, 1].map(|axis| (way[1][axis] - middle[axis]) / scale);
    let palm = &strategy["palm_in_world"]["position"];
    let (sin, cos) = turn.sin_cos();
    let in_world = [drawn[0] * cos - drawn[1] * sin + 0.5, drawn[0] * sin + drawn[1] * cos + 0.1];
    for (axis, found) in in_world.iter().enumerate() {
        assert!((found - number(&palm[axis])).abs() < 1e-3, "{in_world:?}, {palm}");
    }
    // From the side: it stands on the table, and the palm is as high as it is.
    let side = points(&mut browser, "#strategy-picture svg:nth-of-type(1) .thing");
    let table = "Number(document.querySelector('#strategy-picture .table').getAttribute('y'))";
    let table = -number(&browser.evaluate(table));
    let lowest = side.iter().map(|[_, y]| *y).fold(f64::MAX, f64::min);
    let way = points(&mut browser, "#strategy-picture svg:nth-of-type(1) .way");
    assert!((lowest - table).abs() < 0.1, "{side:?}, the table at {table}");
    assert!(((way[1][1] - table) / scale - number(&palm[2])).abs() < 1e-3, "{way:?}, {palm}");
    // What is pressed with is what was simulated, or is said not to be known.
    let steps = browser.evaluate("document.getElementById('steps').innerText");
    let steps = steps.as_str().unwrap();
    assert!(steps.contains("one link pressed with up to") || steps.contains("not simulated"), "{steps}");
    assert!(!steps.contains("at most 20 N"), "{steps}");
    browser.evaluate("document.getElementById('strategy').scrollIntoView()");
    keep(&mut browser, "page-robot-box.png");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}
