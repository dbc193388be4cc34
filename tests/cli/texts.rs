//! What a person reads: numbers, names and errors in what both programs print, and what their
//! examples name.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
#[cfg(unix)]
use std::process::Command;

use grasp_tests::{Outcome, pictures, program, run, small_index, workspace};

const SEGMENTED: &str = "segmented/09-pinch.png";

/// `grasp-query` with the small index, in the folder of the sample pictures.
fn query(arguments: &[&str]) -> Outcome {
    run(program("grasp-query").args(arguments).env("GRASP_INDEX", small_index()).current_dir(pictures()))
}

#[test]
fn a_folder_stands_for_its_pictures_in_the_order_of_their_names() {
    let folder = query(&["recognise", "segmented", "--segmented", "--json", "--hand", "right"]);
    let names: Vec<String> = fs::read_dir(pictures().join("segmented"))
        .unwrap()
        .map(|entry| format!("segmented/{}", entry.unwrap().file_name().to_string_lossy()))
        .collect::<BTreeSet<_>>()
        .into_iter()
        .collect();
    let files: Vec<_> = folder.json_lines().iter().map(|record| record["file"].clone()).collect();
    assert_eq!(files, names, "{}", folder.stderr);

    let alias = query(&["recognize", "segmented", "--segmented", "--json", "--hand", "right"]);
    assert_eq!(alias.stdout, folder.stdout);

    let empty = tempfile::tempdir().unwrap();
    let empty = query(&["recognise", &empty.path().display().to_string()]);
    assert_eq!(empty.status, 2);
    assert!(
        empty.stderr.contains("holds no picture, and folders in it are not searched: name pictures"),
        "{}",
        empty.stderr
    );
}

#[test]
fn pictures_of_a_folder_that_are_not_read_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(pictures().join("segmented/09-pinch.png"), folder.path().join("a.png")).unwrap();
    for name in ["IMG_1.HEIC", "scan.tif", "notes.txt"] {
        fs::write(folder.path().join(name), "").unwrap();
    }
    let outcome = query(&["recognise", "--segmented", "--json", &folder.path().display().to_string()]);
    assert!(outcome.status < 2 && outcome.json_lines().len() == 1, "{}", outcome.stderr);
    let said = "2 pictures are left out, being of a format that is not read, such as ";
    assert!(outcome.stderr.contains(said) && outcome.stderr.contains("IMG_1.HEIC"), "{}", outcome.stderr);
}

#[test]
fn where_knows_its_columns_and_values() {
    let evaluate = |condition| query(&["evaluate", "labels.csv", "--where", condition]);
    let column = evaluate("knid=camera");
    assert_eq!(column.status, 2);
    assert!(column.stderr.contains("has no column `knid`; its columns are azimuth, "), "{}", column.stderr);
    let value = evaluate("kind=photo");
    assert_eq!(value.status, 2);
    assert!(
        value.stderr.contains("no row of labels.csv has this value; `kind` is camera or segmented"),
        "{}",
        value.stderr
    );
    let both = query(&[
        "evaluate",
        "labels.csv",
        "--where",
        "kind=segmented",
        "--where",
        "file=camera/09-pinch.jpg",
    ]);
    assert!(both.stderr.contains("no row of labels.csv meets all of --where and --part"), "{}", both.stderr);
    assert_eq!(evaluate("kind=segmented").status, 0);
}

#[test]
fn a_file_name_cannot_command_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let name = "a\u{1b}[2J\u{7}\n.png";
    fs::copy(pictures().join(SEGMENTED), folder.path().join(name)).unwrap();
    fs::write(folder.path().join("labels.csv"), format!("file,kind,grasp\n\"{name}\",camera,\u{1b}[31m\n"))
        .unwrap();
    let index = folder.path().join("\u{1b}]0;x.idx");
    fs::copy(small_index(), &index).unwrap();
    let index = index.to_str().unwrap();
    for (program_name, arguments) in [
        ("grasp-query", vec!["recognise", "--segmented", name, "--index", index]),
        ("grasp-query", vec!["recognise", "\u{1b}c.png", "--index", index]),
        ("grasp-query", vec!["recognise", name, "--index", "\u{1b}c.idx"]),
        ("grasp-query", vec!["evaluate", "labels.csv", "--index", index]),
        ("grasp-builder", vec!["inspect", index]),
        ("grasp-builder", vec!["verify", index]),
        ("grasp-builder", vec!["verify", name]),
        ("grasp-builder", vec!["merge", "\u{1b}c"]),
    ] {
        let outcome = run(program(program_name).args(&arguments).current_dir(folder.path()));
        let printed = outcome.stdout + &outcome.stderr;
        let controls = |c: char| c.is_control() && c != '\n';
        assert!(!printed.contains(controls), "{arguments:?}: {printed:?}");
        assert!(printed.contains("\\u{1b}"), "{arguments:?}: {printed}");
    }
}

#[test]
fn an_error_is_printed_once() {
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("broken.toml");
    fs::write(&broken, "[objects\n").unwrap();
    let broken = broken.to_str().unwrap();
    let index = small_index().to_str().unwrap();
    let object = workspace().join("query/data/objects/bottle.toml").display().to_string();
    for (program_name, arguments) in [
        ("grasp-query", vec!["recognise", SEGMENTED, "--index", "none.idx"]),
        ("grasp-query", vec!["recognise", "none.png"]),
        ("grasp-query", vec!["recognise", SEGMENTED, "--mask", "none.png"]),
        ("grasp-query", vec!["recognise", SEGMENTED, "--prior", broken, "--holding", "x"]),
        ("grasp-query", vec!["recognise", SEGMENTED, "--prior", "none.toml", "--holding", "x"]),
        (
            "grasp-query",
            vec!["recognise", SEGMENTED, "--robot", "barrett", "--object", broken, "--camera", &object],
        ),
        ("grasp-query", vec!["recognise", SEGMENTED, "--server", "unix:none.sock"]),
        ("grasp-query", vec!["recognise", SEGMENTED, "--explain", "none/why.png"]),
        ("grasp-query", vec!["evaluate", "none.csv"]),
        ("grasp-query", vec!["search", "none.npy"]),
        ("grasp-query", vec!["search", "labels.csv"]),
        ("grasp-builder", vec!["inspect", "none.idx"]),
        ("grasp-builder", vec!["verify", SEGMENTED]),
        ("grasp-builder", vec!["build", "none", "--out", "none/x.idx"]),
        ("grasp-builder", vec!["build", "--step", "60", "--out", "none/x.idx"]),
        ("grasp-builder", vec!["build", "--grasps", broken, "--out", "x.idx"]),
        ("grasp-builder", vec!["build", "--hand-model", "none.glb", "--out", "x.idx"]),
        ("grasp-builder", vec!["merge", "none"]),
        ("grasp-builder", vec!["export", index, "--labels", "none/y.csv"]),
    ] {
        let outcome =
            run(program(program_name).args(&arguments).env("GRASP_INDEX", index).current_dir(pictures()));
        assert_eq!(outcome.status, 2, "{arguments:?}: {}{}", outcome.stdout, outcome.stderr);
        let clauses: Vec<&str> = outcome.stderr.split([':', '\n']).map(str::trim).collect();
        let said =
            |clause: &&str| clause.len() > 8 && clauses.iter().filter(|other| *other == clause).count() > 1;
        assert_eq!(clauses.iter().find(|clause| said(clause)), None, "{arguments:?}: {}", outcome.stderr);
        let os_errors = outcome.stderr.matches("os error").count();
        assert!(os_errors <= 1, "{arguments:?}: {}", outcome.stderr);
    }
}

/// A number that nobody would write so: `1 pictures`, `-0`, or `0 %` of what is not nothing.
fn odd_number(text: &str) -> Option<String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let is_plural = |word: &str| {
        let word = word.trim_end_matches([',', '.', ';', ':']);
        word.len() > 3 && word.ends_with('s') && !word.ends_with("ss") && word != "axis"
    };
    words.windows(2).find_map(|pair| {
        let [number, unit] = pair else { return None };
        let zero = number.strip_prefix('-').is_some_and(|rest| {
            rest.starts_with('0')
                && rest.trim_end_matches(['°', ',']).bytes().all(|b| matches!(b, b'0' | b'.'))
        });
        (zero || (*number == "1" && is_plural(unit))).then(|| pair.join(" "))
    })
}

#[test]
fn numbers_are_written_as_people_write_them() {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(pictures().join(SEGMENTED), folder.path().join("one.png")).unwrap();
    fs::write(folder.path().join("one.csv"), "file,kind,grasp\none.png,segmented,pinch\n").unwrap();
    let index = small_index().to_str().unwrap();
    let query = ["--index", index];
    let one = ["recognise", "one.png", "--segmented", "--hand", "right"];
    let mut printed = String::new();
    for (program_name, arguments) in [
        ("grasp-query", [&one[..], &query].concat()),
        ("grasp-query", [&["evaluate", "one.csv"][..], &query].concat()),
        ("grasp-query", vec!["simulate", "--grasp", "precision-disc"]),
        ("grasp-builder", vec!["inspect", index]),
        ("grasp-builder", vec!["verify", index]),
        ("grasp-builder", vec!["render", "--views", "1", "--out", "renders"]),
        (
            "grasp-builder",
            vec![
                "build", "--hands", "2", "--views", "2", "--hash", "random", "--planes", "1", "--tables",
                "1", "--out", "s.idx",
            ],
        ),
        ("grasp-builder", vec!["queries", "--count", "9", "--out", "q.npy"]),
    ] {
        let outcome = run(program(program_name).args(&arguments).current_dir(folder.path()));
        assert!(outcome.status < 2, "{arguments:?}: {}", outcome.stderr);
        assert_eq!(odd_number(&outcome.stdout), None, "{arguments:?}: {}", outcome.stdout);
        printed += &outcome.stdout;
    }
    assert!(printed.contains("· 1 search over ") && !printed.contains("over 0 %"), "{printed}");
    assert!(printed.contains("% of 1 picture, "), "{printed}");
}

#[test]
fn the_order_and_the_unit_of_the_euler_angles_are_in_the_record() {
    let outcome = query(&["recognise", SEGMENTED, "--segmented", "--json"]);
    let orientation = &outcome.json_lines()[0]["orientation"];
    let angles = &orientation["euler_deg"];
    assert_eq!(angles["order"], "extrinsic xyz");
    let half = |axis: &str| angles[axis].as_f64().unwrap().to_radians() / 2.0;
    assert_eq!(orientation["euler"][2], angles["z"]);
    // About fixed axes, what turns first stands rightmost: q = z y x.
    let ((sx, cx), (sy, cy), (sz, cz)) = (half("x").sin_cos(), half("y").sin_cos(), half("z").sin_cos());
    let made = [
        sx * cy * cz - cx * sy * sz,
        cx * sy * cz + sx * cy * sz,
        cx * cy * sz - sx * sy * cz,
        cx * cy * cz + sx * sy * sz,
    ];
    let stated = orientation["quaternion_xyzw"].as_array().unwrap();
    let dot: f64 = made.iter().zip(stated).map(|(a, b)| a * b.as_f64().unwrap()).sum();
    assert!((dot.abs() - 1.0).abs() < 1e-9, "{orientation}");
}

/// The commands of a text, each as its words, without comments.
fn commands(lines: impl Iterator<Item = String>, comment: &str) -> Vec<Vec<String>> {
    const PROGRAMS: [&str; 7] = ["grasp-builder", "grasp-query", "curl", "cat", "cp", "npm", "for"];
    let mut text = String::new();
    for line in lines {
        match line.trim_end().strip_suffix('\\') {
            Some(begun) => text += begun,
            None => text += &format!("{line}\n"),
        }
    }
    let starts =
        |line: &&str| PROGRAMS.iter().any(|program| line.trim_start().starts_with(&format!("{program} ")));
    let code = |line: &str| line.trim_start().split(comment).next().unwrap_or_default().to_owned();
    let simple = text
        .lines()
        .filter(starts)
        .flat_map(|line| code(line).split(['|', ';', '&']).map(str::to_owned).collect::<Vec<_>>());
    simple
        .map(|command| {
            let words = command.split_whitespace().skip_while(|&word| word == "do");
            words.map(|word| word.trim_matches(['\'', '"', '(', ')']).to_owned()).collect::<Vec<_>>()
        })
        .filter(|words| !words.is_empty())
        .collect()
}

/// Placeholders are written in capitals, as in the usage: `PICTURE.png`.
fn is_placeholder(word: &str) -> bool {
    let stem = word.rsplit_once('.').map_or(word, |(stem, _)| stem);
    !stem.is_empty() && stem.bytes().all(|byte| byte.is_ascii_uppercase())
}

/// The files that commands name, in the order in which they are shown.
#[derive(Clone, Default)]
struct Files {
    made: BTreeSet<String>,
    missing: Vec<String>,
}

impl Files {
    const OUTPUTS: [&str; 8] = [
        "--out",
        "--explain",
        "--pictures",
        "--predictions",
        "--distances",
        "--segment",
        "--out-dir",
        "--unix",
    ];
    const EXPORTED: [&str; 3] = ["--descriptors", "--labels", "--parquet"];
    /// Options without a value: what follows them is a file again.
    const FLAGS: [&str; 6] =
        ["--json", "--segmented", "--timings", "--sequence", "--data-binary", "--no-progress"];

    fn take(&mut self, words: &[String]) {
        let [program, rest @ ..] = words else { return };
        let subcommand = rest.first().map_or("", String::as_str);
        if program == "cp" {
            self.made.extend(rest.last().cloned());
        }
        let mut before = "";
        for word in rest {
            let word = word.trim_start_matches('@');
            let is_output = Self::OUTPUTS.contains(&before)
                || (subcommand == "export" && Self::EXPORTED.contains(&before))
                || before == ">";
            if is_output {
                self.made.insert(word.to_owned());
            } else if program == "npm" && before == "--prefix" {
                self.made.insert(format!("{word}/node_modules"));
            } else if Self::is_file(word, before, program, subcommand) && !self.is_there(word) {
                self.missing.push(word.to_owned());
            }
            before = word;
        }
    }

    /// Whether a word names a file or, where one is expected, a folder.
    fn is_file(word: &str, before: &str, program: &str, subcommand: &str) -> bool {
        const ENDINGS: [&str; 12] =
            ["jpg", "png", "toml", "npy", "csv", "idx", "glb", "mp4", "parquet", "shard", "txt", "urdf"];
        if word.starts_with('-') || word.contains("://") || word.starts_with("/dev/") || word.contains('=') {
            return false;
        }
        let ending = word.rsplit_once('.').map_or("", |(_, ending)| ending);
        if is_placeholder(word) {
            return false;
        }
        let is_positional = !before.starts_with('-') || Self::FLAGS.contains(&before);
        let takes_folders = ["build", "merge", "add", "compact", "recognise", "watch"].contains(&subcommand);
        let is_folder = program.starts_with("grasp-") && takes_folders && is_positional && word != subcommand;
        ENDINGS.contains(&ending) || is_folder
    }

    fn is_there(&self, word: &str) -> bool {
        // A pattern is there where its folder is.
        let path = Path::new(word);
        let path = if word.contains('*') { path.parent().unwrap_or(path) } else { path };
        let is_made = path.ancestors().any(|path| self.made.contains(path.to_str().unwrap_or_default()));
        is_made || (!path.as_os_str().is_empty() && workspace().join(path).exists())
    }
}

fn help(name: &str, path: &[String]) -> String {
    run(program(name).args(path).arg("--help").env("COLUMNS", "200")).stdout
}

/// All subcommands of a program, as paths of names.
fn subcommands(name: &str, path: &[String]) -> Vec<Vec<String>> {
    let help = help(name, path);
    let Some((_, list)) = help.split_once("Commands:\n") else { return vec![path.to_vec()] };
    let names = list.lines().take_while(|line| line.starts_with("  "));
    let names = names.filter_map(|line| line.split_whitespace().next()).filter(|&name| name != "help");
    let below = names.flat_map(|sub| subcommands(name, &[path, &[sub.to_owned()]].concat()));
    std::iter::once(path.to_vec()).chain(below).collect()
}

fn examples(help: &str) -> Vec<Vec<String>> {
    let (_, examples) = help.split_once("Examples:\n").unwrap_or_default();
    commands(examples.lines().take_while(|line| !line.is_empty()).map(str::to_owned), "   ")
}

#[test]
fn every_file_that_an_example_names_is_there_or_made_before() {
    let programs = ["grasp-builder", "grasp-query"];
    let mut common = Files::default();
    programs.iter().flat_map(|name| examples(&help(name, &[]))).for_each(|words| common.take(&words));
    assert_eq!(common.missing, [""; 0]);
    for name in programs {
        for path in subcommands(name, &[]) {
            let mut files = common.clone();
            examples(&help(name, &path)).iter().for_each(|words| files.take(words));
            assert_eq!(files.missing, [""; 0], "{name} {path:?}");
        }
    }
}

#[test]
fn every_option_of_an_example_exists() {
    let helped = ["grasp-builder", "grasp-query"].into_iter().flat_map(|name| {
        subcommands(name, &[]).into_iter().flat_map(move |path| examples(&help(name, &path)))
    });
    let documented = documents().into_iter().flat_map(|(_, text)| commands(code(&text), " # "));
    let mut helps = BTreeMap::new();
    for words in helped.chain(documented).filter(|words| words[0].starts_with("grasp-")) {
        let [program_name, rest @ ..] = words.as_slice() else { continue };
        let below = |word: &&String| word.bytes().all(|byte| byte.is_ascii_lowercase());
        let depth = if rest.first().is_some_and(|word| word == "experiment") { 2 } else { 1 };
        let path: Vec<String> = rest.iter().take(depth).take_while(below).cloned().collect();
        let help =
            helps.entry((program_name.clone(), path.clone())).or_insert_with(|| help(program_name, &path));
        for option in rest.iter().filter(|word| word.starts_with("--") && word.len() > 2) {
            // An option may have its value with it.
            let name = option.split('=').next().unwrap_or_default();
            assert!(help.contains(name), "{option} in {words:?}");
        }
    }
}

/// README, and the pages of `docs`, which go on from it.
fn documents() -> Vec<(PathBuf, String)> {
    let pages = fs::read_dir(workspace().join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let pages: BTreeSet<_> = pages.filter(|path| path.extension().is_some_and(|end| end == "md")).collect();
    let paths = std::iter::once(workspace().join("README.md")).chain(pages);
    paths.map(|path| (path.clone(), fs::read_to_string(path).unwrap())).collect()
}

/// The lines of a document that are code to run: those that are indented.
fn code(text: &str) -> impl Iterator<Item = String> {
    text.lines().filter(|line| line.starts_with("    ")).map(str::to_owned)
}

#[test]
fn every_file_that_a_document_names_is_there_or_made_before() {
    let mut made = Files::default();
    for (path, text) in documents() {
        let mut files = made.clone();
        commands(code(&text), " # ").iter().for_each(|words| files.take(words));
        let quoted = text.split("recognise(\"").skip(1).filter_map(|rest| rest.split('"').next());
        files.missing.extend(quoted.filter(|path| !workspace().join(path).exists()).map(str::to_owned));
        let linked = text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
        let shown = text.split("src=\"").skip(1).filter_map(|rest| rest.split('"').next());
        let folder = path.parent().unwrap();
        for link in linked.chain(shown).filter(|link| !link.contains("://")) {
            if !folder.join(link).exists() {
                files.missing.push(link.to_owned());
            }
        }
        assert_eq!(files.missing, [""; 0], "{}", path.display());
        if path.ends_with("README.md") {
            made = files;
        }
    }
}

#[test]
fn the_readme_fits_and_its_lines_do() {
    for (path, text) in documents() {
        let is_text = |line: &&str| !line.starts_with(['|', '!']) && !line.starts_with("    ");
        let long = text.lines().filter(is_text).find(|line| line.chars().count() > 100);
        assert_eq!(long, None, "{}", path.display());
        assert!(!path.ends_with("README.md") || text.lines().count() <= 150);
    }
}

/// Whether a documented command can be run as it stands: it is quick, and needs neither a service,
/// nor a camera, nor a file of the reader's own, nor an index that a longer command makes.
#[cfg(unix)]
fn is_quick(line: &str, folder: &Path) -> bool {
    const QUICK: [&str; 10] = [
        "recognise",
        "recognize",
        "watch",
        "evaluate",
        "search",
        "simulate",
        "inspect",
        "verify",
        "export",
        "queries",
    ];
    let words: Vec<&str> = line.split(" #").next().unwrap_or_default().split_whitespace().collect();
    let subcommand =
        words.iter().position(|word| word.starts_with("grasp-")).and_then(|at| words.get(at + 1));
    let subcommand = subcommand.copied().unwrap_or_default();
    let is_known = QUICK.contains(&subcommand)
        || (subcommand == "build" && words.contains(&"--descriptors"))
        || (subcommand == "experiment" && words.contains(&"report"));
    let mut before = "";
    let is_ready = words.iter().all(|word| {
        let is_there = !word.ends_with(".idx") || before == "--out" || folder.join(word).exists();
        let is_camera = before == "--camera" && (word.starts_with("/dev/") || word.parse::<u32>().is_ok());
        before = word;
        is_there && !is_camera && !is_placeholder(word)
    });
    is_known && is_ready && !["ffmpeg", "curl", "jq", "--server"].iter().any(|needed| words.contains(needed))
}

#[cfg(unix)]
#[test]
fn what_the_documents_show_runs() {
    let path = format!(
        "{}:{}",
        grasp_tests::programs(grasp_tests::Build::Debug).display(),
        std::env::var("PATH").unwrap()
    );
    let home = tempfile::tempdir().unwrap();
    let index = home.path().join("grasp.idx");
    let few = ["build", "--hands", "1", "--views", "6", "--out"];
    assert_eq!(run(program("grasp-builder").args(few).arg(&index)).status, 0);
    let mut ran = 0;
    for (page, text) in documents() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["tests", "query"] {
            std::os::unix::fs::symlink(workspace().join(name), folder.path().join(name)).unwrap();
        }
        // Of few views, but described as the default index is.
        fs::copy(&index, folder.path().join("grasp.idx")).unwrap();
        let code = code(&text).map(|line| line + "\n").collect::<String>().replace("\\\n", " ");
        for line in code.lines() {
            if is_quick(line, folder.path()) {
                let outcome = run(Command::new("sh")
                    .args(["-c", line])
                    .env("PATH", &path)
                    .env_remove("GRASP_INDEX")
                    .current_dir(folder.path()));
                assert!(outcome.status < 2, "{}: {line}\n{}", page.display(), outcome.stderr);
                ran += 1;
            }
        }
    }
    assert!(ran > 30, "{ran}");
}
