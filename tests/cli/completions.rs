//! What a real bash completes by the scripts of both programs. Where no bash is installed, nothing
//! is tested.

use std::process::Command;

use grasp_tests::{program, run};

/// Calls the completion function as bash does on the tab key, for the last of the words.
const PRESS_TAB: &str = r#"
source "$1"; shift
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
function=$(complete -p "$1" | sed 's/.*-F \([^ ]*\) .*/\1/')
"$function" "$1" "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
echo "${COMPREPLY[*]}"
"#;

#[test]
fn bash_completes_below_subcommands_and_behind_options() {
    if Command::new("bash").arg("--version").output().is_err() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for name in ["grasp-builder", "grasp-query"] {
        let script = run(program(name).args(["completions", "bash"]));
        assert_eq!(script.status, 0, "{}", script.stderr);
        std::fs::write(folder.path().join(name), script.stdout).unwrap();
    }
    for (line, expected) in [
        ("grasp-builder comp", "compact completions"),
        ("grasp-builder build --thu", "--thumbnails"),
        ("grasp-builder build --preset ", "paper standard wide"),
        ("grasp-builder build --descriptor ", "learned upright default paper"),
        ("grasp-builder remove --preset w", "wide"),
        ("grasp-builder experiment sh", "shapes"),
        ("grasp-builder experiment shapes --preset s", "standard"),
        ("grasp-builder --threads 2 verify --no-p", "--no-progress"),
        ("grasp-query recognise --rob", "--robot"),
        ("grasp-query recognise --robot ", "allegro barrett franka-hand parallel-gripper robotiq-2f-85"),
        ("grasp-query recognize --arm k", "kuka-kr6-r700"),
        ("grasp-query recognise --hand ", "auto left right"),
        ("grasp-query simulate --object b", "box block"),
        ("grasp-query experiment robustness --object s", "sphere stick"),
    ] {
        let words: Vec<&str> = line.split(' ').collect();
        let completed = run(Command::new("bash")
            .args(["--norc", "-c", PRESS_TAB, "bash"])
            .arg(folder.path().join(words[0]))
            .args(&words));
        assert_eq!(completed.stderr, "", "{line}");
        assert_eq!(completed.stdout.trim_end(), expected, "{line}");
    }
}

/// `recognise -h` is a screen of what everybody needs; `--help` knows the rest, headed as such.
#[test]
fn research_options_stand_apart() {
    let help = |flag: &str| run(program("grasp-query").args(["recognise", flag])).stdout;
    let (short, long) = (help("-h"), help("--help"));
    let (everyday, research) = long.split_once("Research:").expect("a heading");
    for option in ["--rolls", "--k <N>", "--sigma <D>", "--literal-sigma", "--euler-mean", "--unknown-at"] {
        assert!(!short.contains(option) && !everyday.contains(option), "{option}");
        assert!(research.contains(option), "{option}");
    }
    for option in ["--index", "--segmented", "--json", "--explain", "--robot", "--recall"] {
        assert!(short.contains(option) && everyday.contains(option), "{option}");
    }
}
