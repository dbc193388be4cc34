//! `--explain`: files are what their names say, and the sheet shows what it is read for.

use std::fs;
use std::path::Path;

use grasp_tests::{Outcome, pictures, program, run, small_index};
use image::{ImageFormat, RgbImage};

/// Runs `recognise` on sample pictures in `folder`.
fn recognise(folder: &Path, samples: &[&str], explain: &str) -> Outcome {
    let mut command = program("grasp-query");
    command.arg("recognise").args(samples.iter().map(|sample| pictures().join(sample)));
    run(command.args(["--explain", explain, "--index"]).arg(small_index()).current_dir(folder))
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

const BALL: &str = "camera/10-power-sphere.jpg";
const BOTTLE: &str = "camera/01-large-diameter.jpg";

#[test]
fn a_drawing_is_the_file_that_its_name_says() {
    let folder = tempfile::tempdir().unwrap();
    for (name, format) in [("why.jpg", ImageFormat::Jpeg), ("why.png", ImageFormat::Png)] {
        let outcome = recognise(folder.path(), &[BALL], name);
        assert_eq!(outcome.status, 0, "{}", outcome.stderr);
        let bytes = fs::read(folder.path().join(name)).unwrap();
        assert_eq!(image::guess_format(&bytes).unwrap(), format, "{name}");
    }
    assert_eq!(names(folder.path()), ["why.jpg", "why.png"]);
}

#[test]
fn a_name_that_is_no_file_and_no_folder_makes_neither() {
    let folder = tempfile::tempdir().unwrap();
    for (samples, name, hint) in [
        (&[BALL][..], "why", "write why.png for a file, or why/ for a folder"),
        (&[BALL], "why.pdf", "write why.png for a file, or why/ for a folder"),
        (&[BALL, BOTTLE], "why.jpg", "write why/ for a folder"),
    ] {
        let outcome = recognise(folder.path(), samples, name);
        assert_eq!((outcome.status, outcome.stdout.as_str()), (2, ""), "{name}");
        assert!(outcome.stderr.contains(hint), "{}", outcome.stderr);
        assert!(names(folder.path()).is_empty(), "{name}");
    }
}

#[test]
fn a_folder_is_named_by_a_slash_or_by_several_pictures() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(recognise(folder.path(), &[BALL], "one/").status, 0);
    assert_eq!(names(&folder.path().join("one")).len(), 1);
    // One that is there is taken, however it is named.
    assert_eq!(recognise(folder.path(), &[BOTTLE], "one").status, 0);
    assert_eq!(names(&folder.path().join("one")).len(), 2);
    recognise(folder.path(), &[BALL, BOTTLE], "two");
    let drawn = names(&folder.path().join("two"));
    assert_eq!(drawn.len(), 2, "{drawn:?}");
    assert!(drawn[0].ends_with("01-large-diameter.jpg.png"), "{drawn:?}");
}

/// Pixels of the sheet in this colour.
fn count(sheet: &RgbImage, colour: [u8; 3]) -> usize {
    sheet.pixels().filter(|pixel| pixel.0 == colour).count()
}

#[test]
fn the_sheet_shows_the_probabilities_as_bars_and_the_axes_as_arrows() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = program("grasp-query");
    command.args(["recognise", "--json"]).arg(pictures().join(BALL));
    let outcome =
        run(command.args(["--explain", "why.png", "--index"]).arg(small_index()).current_dir(folder.path()));
    let record = &outcome.json_lines()[0];
    let sheet = image::open(folder.path().join("why.png")).unwrap().into_rgb8();
    // The answer's bar: as many pixels long as its share of 300. Longer than any stroke of the
    // letters in that colour.
    let green = [110, 210, 130];
    let longest = sheet.rows().map(|row| {
        let runs = row.map(|pixel| usize::from(pixel.0 == green)).scan(0, |length, is_green| {
            *length = if is_green == 1 { *length + 1 } else { 0 };
            Some(*length)
        });
        runs.max().unwrap_or(0)
    });
    let expected = 300.0 * record["probability"].as_f64().unwrap();
    let longest = longest.max().unwrap();
    assert!((longest as f64 - expected).abs() <= 1.0, "{longest} pixels for {expected:.1}");
    for (arrow, colour) in [("fingers", [90, 190, 255]), ("back", [255, 190, 70])] {
        assert!(count(&sheet, colour) > 144, "no arrow besides its legend: {arrow}");
    }
}
