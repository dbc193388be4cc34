//! The figures as a table for a person.

use std::fmt::Write as _;

use super::figures::{Paper, SetResult};
use crate::evaluate::report::errors_text;

pub(super) fn text(paper: &Paper) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = write_text(&mut text, paper);
    text
}

fn write_text(text: &mut String, paper: &Paper) -> std::fmt::Result {
    for kind in &paper.kinds {
        writeln!(text, "{} pictures", kind.kind)?;
        writeln!(
            text,
            "  {:<30} {:>5}  {:>6}  {:>9}  {:>8}  {:>8}   {:>22}",
            "", "n", "top-1", "95 %", "error", "median", "Euler x, y, z"
        )?;
        for set in &kind.sets {
            ours(text, set)?;
            theirs(text, set)?;
        }
        writeln!(text)?;
        for set in kind.sets.iter().filter(|set| set.n > 0) {
            writeln!(text, "  {}, {} (rows: labelled; columns: answered)", set.set, set.what)?;
            set.confusion.write_text(text)?;
            writeln!(text)?;
        }
    }
    writeln!(
        text,
        "error: the mean angle between labelled and answered rotation; Euler: the mean difference of each angle. The paper's are \
         of its own\n36 pictures, about axes that it does not name."
    )?;
    text.push_str(&errors_text(&paper.errors));
    Ok(())
}

fn ours(text: &mut String, set: &SetResult) -> std::fmt::Result {
    let name = format!("{:<3} {}", set.set, set.what);
    if set.n == 0 {
        return writeln!(text, "  {name:<30} {:>5}", 0);
    }
    let errors = &set.orientation_error_deg;
    line(
        text,
        &name,
        set.n,
        set.top1,
        set.top1_interval,
        [degrees(errors.mean), degrees(errors.median)],
        set.euler_error_deg,
    )
}

fn theirs(text: &mut String, set: &SetResult) -> std::fmt::Result {
    let top1 = set.paper.top1;
    line(
        text,
        "    the paper",
        top1.n,
        top1.top1(),
        top1.interval(),
        [const { String::new() }; 2],
        set.paper.euler_error_deg,
    )?;
    match set.paper.human_top1 {
        Some(human) => line(
            text,
            "    the paper's person",
            human.n,
            human.top1(),
            human.interval(),
            [const { String::new() }; 2],
            None,
        ),
        None => Ok(()),
    }
}

fn line(
    text: &mut String,
    name: &str,
    n: usize,
    top1: f64,
    [low, high]: [f64; 2],
    [mean, median]: [String; 2],
    euler: Option<[f64; 3]>,
) -> std::fmt::Result {
    let interval = format!("{:.0}..{:.0}", 100.0 * low, 100.0 * high);
    let euler = euler.map(|[x, y, z]| format!("{x:.1}°, {y:.1}°, {z:.1}°")).unwrap_or_default();
    let line = format!(
        "  {name:<30} {n:>5}  {:>4.0} %  {interval:>9}  {mean:>8}  {median:>8}   {euler:>22}",
        100.0 * top1
    );
    writeln!(text, "{}", line.trim_end())
}

fn degrees(value: Option<f64>) -> String {
    value.map(|value| format!("{value:.1}°")).unwrap_or_default()
}
