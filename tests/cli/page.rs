//! The page of `grasp-query serve` in a real browser: a picture is dropped, the answer is read, the neighbours are seen.
//!
//! `SCREENSHOTS=DIR` keeps what it looks like. Where no Chromium is installed (`CHROMIUM` names another), nothing is tested.

use std::path::PathBuf;
use std::process::Command;

use grasp_tests::browser::Browser;
use grasp_tests::service::Service;
use grasp_tests::{pictures, small_index};

fn start() -> Option<(Service, Browser)> {
    let Some(browser) = Browser::start() else {
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
    keep(&mut browser, "page-empty.png");
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
    assert_eq!(neighbours.as_array().unwrap().len(), expected.len().min(14));
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

    // On a phone, in the dark, nothing runs out of the side.
    browser.look_like(390, 844, "dark");
    assert_eq!(browser.evaluate("document.documentElement.scrollWidth <= innerWidth"), true);
    keep(&mut browser, "page-dark.png");
}

#[test]
fn everything_can_be_done_by_keyboard_and_has_a_name() {
    let Some((service, mut browser)) = start() else { return };
    browser.look_like(1200, 900, "dark");
    browser.open(&format!("http://{}/", service.address()));
    browser.drop_file("#drop", &pictures().join("camera/no-hand.jpg"));
    browser.wait_for("!document.getElementById('problem').hidden");
    let problem = browser.evaluate("document.getElementById('problem').textContent");
    assert!(problem.as_str().unwrap().contains("no hand found"), "{problem}");
    assert_eq!(browser.evaluate("document.getElementById('answer').hidden"), true);
    browser.complaints.clear();

    let mut reached = Vec::new();
    for _ in 0..12 {
        browser.press("Tab", 9);
        reached.push(browser.evaluate("document.activeElement.id || document.activeElement.tagName"));
    }
    for id in ["choose", "camera", "side", "segmented"] {
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
    // The browser's own test picture shows no hand, or something that could be one: an answer either way.
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
    assert!(off < 0.01 || off > std::f64::consts::PI - 0.01, "{off} rad off in {above:?}");

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
