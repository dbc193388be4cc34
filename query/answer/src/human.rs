//! Answers as text.

use std::fmt::Write as _;

use grasp_terminal::text::{counted, fixed, percent, printable, printable_lines};

use super::record::{Answer, Failure, Record};
use grasp_robot::Strategy;

/// Classes below this probability are not named as runners-up.
const WORTH_NAMING: f64 = 0.01;

/// One line for the answer, and indented lines for the rotation, the runners-up, the nearest entry
/// and the timings.
pub fn text(record: &Record) -> String {
    let text = match record {
        Record::Answer(answer) => answer_text(answer),
        Record::Failure(failure) => failure_text(failure),
    };
    // Names of classes and hands come from files as well, and nobody reads an index before using
    // it.
    printable_lines(&text)
}

fn failure_text(failure: &Failure) -> String {
    let message = &failure.error.message;
    // Some messages name the file themselves, as they stand alone elsewhere.
    if message.contains(&format!(" {}: ", failure.file)) {
        return format!("{message}\n");
    }
    format!("{}: {message}\n", name(&failure.file, failure.frame))
}

/// What a line of text calls an input.
pub fn name(file: &str, frame: Option<u64>) -> String {
    let file = printable(file);
    frame.map_or_else(|| file.clone().into_owned(), |frame| format!("{file} frame {frame}"))
}

fn answer_text(answer: &Answer) -> String {
    let class = match (&answer.reason, answer.cutkosky) {
        (None, Some(cutkosky)) => {
            format!("{} (Cutkosky {cutkosky}), {:.2}", answer.grasp, answer.probability)
        }
        _ => answer.grasp.clone(),
    };
    let mut text = format!(
        "{}: {class} · {} hand · camera sees {}, fingers point {} (± {:.0}°)\n",
        name(&answer.file, answer.frame),
        answer.hand,
        answer.orientation.camera_sees,
        answer.orientation.fingers_point,
        answer.orientation.spread_deg,
    );
    if let Some(reason) = &answer.reason {
        let _ = writeln!(text, "    {reason}");
    }
    let [x, y, z] = answer.orientation.euler.map(|degrees| fixed(degrees, 0));
    let _ =
        writeln!(text, "    rotation {x}°, {y}°, {z}° about the camera's fixed axes x, y, z, in this order");
    for warning in &answer.warnings {
        let _ = writeln!(text, "    warning: {}", warning.message);
    }
    let others: Vec<String> = answer
        .classes
        .iter()
        .skip(usize::from(answer.reason.is_none()))
        .filter(|class| class.probability >= WORTH_NAMING)
        .map(|class| format!("{} {:.2}", class.grasp, class.probability))
        .collect();
    if !others.is_empty() {
        let _ = writeln!(text, "    or {}", others.join(", "));
    }
    if let Some(nearest) = answer.neighbours.first() {
        let _ = writeln!(
            text,
            "    nearest {} at {:.3} · {} {} of the index",
            printable(&nearest.file),
            nearest.distance,
            searches(answer.search.searches),
            percent(answer.search.share_of_database),
        );
    }
    if let Some(strategy) = &answer.strategy {
        strategy_text(strategy, &mut text);
    }
    if let Some(error) = &answer.error {
        let _ = writeln!(text, "    no strategy: {}", error.message);
    }
    if let Some(timings) = &answer.timings {
        let _ = writeln!(
            text,
            "    decode {:.2} ms, segmentation {:.2}, descriptor {:.2}, search {:.2}, vote {:.2}, together {:.2}",
            timings.decode_ms,
            timings.segmentation_ms,
            timings.descriptor_ms,
            timings.search_ms,
            timings.vote_ms,
            timings.total_ms(),
        );
    }
    text
}

/// How many searches there were, before the share of the index that the best of them looked at.
fn searches(count: usize) -> String {
    match count {
        1 => "1 search over".to_owned(),
        count => format!("{count} searches, the best over"),
    }
}

fn strategy_text(strategy: &Strategy, text: &mut String) {
    let [x, y, z] = strategy.palm_in_world.position.map(|metres| fixed(1e3 * metres, 0));
    let _ = writeln!(
        text,
        "    {}: {} on {} ({:.0} mm between the fingers), palm at {x}, {y}, {z} mm in the world",
        strategy.robot,
        strategy.grasp,
        strategy.object,
        1e3 * strategy.object_width,
    );
    if let Some(arm) = strategy.arm.as_ref().filter(|arm| arm.reachable) {
        let _ = writeln!(
            text,
            "    {} carries the hand there and back up: {}",
            arm.arm,
            counted(arm.waypoints.len(), ["waypoint", "waypoints"])
        );
    }
    for problem in &strategy.problems {
        let _ = writeln!(text, "    not feasible: {}", problem.message);
    }
    for warning in strategy.doubts() {
        let _ = writeln!(text, "    warning: {warning}");
    }
}
