//! What the making of an index came to, for a person.

use std::io::Write as _;
use std::path::Path;

use grasp_index::{EPS, Effort, HashInfo, Measured};
use grasp_terminal::text::{counted, percent, shown};

use crate::indexing::Report;

/// What an index holds, in the singular and the plural.
pub(super) const ENTRIES: [&str; 2] = ["entry", "entries"];

/// Whose the queries are that a search was measured by.
fn queries_of(measured: &Measured) -> &'static str {
    let [_, moved] = measured.noise;
    match (measured.held_out, moved > 0.0) {
        (true, true) => "other hands",
        (true, false) => "the rows that were held out",
        (false, _) => "its own entries, each held out for its own query,",
    }
}

/// Prints for a person what came of a build.
pub(super) fn print_report(out: &Path, report: &Report, pictures: bool) -> anyhow::Result<()> {
    let mut stdout = std::io::stdout().lock();
    let (out, seconds) = (shown(out), report.elapsed.as_secs_f64());
    let Some(summary) = &report.written else {
        let entries = counted(report.entries, ENTRIES);
        writeln!(stdout, "{out} is up to date: {entries}, checked in {seconds:.2} s")?;
        return Ok(());
    };
    write!(
        stdout,
        "{out}: {}, {:.1} MB, in {seconds:.2} s",
        counted(summary.entries, ENTRIES),
        summary.bytes as f64 / 1e6
    )?;
    if pictures {
        let described = report.entries - report.reused;
        writeln!(stdout, " ({} reused, {described} described)", report.reused)?;
    } else {
        writeln!(stdout)?;
    }
    if report.without_hand > 0 {
        let views =
            counted(report.without_hand, ["view shows no hand and was", "views show no hand and were"]);
        writeln!(stdout, "  {views} left out")?;
    }
    match summary.hash {
        HashInfo::Random(hash) => {
            writeln!(
                stdout,
                "  hash: T = {} of K = {}",
                counted(hash.tables, ["table", "tables"]),
                counted(hash.planes, ["random hyperplane", "random hyperplanes"])
            )?;
        }
        HashInfo::Learned(hash) => {
            let planes = counted(hash.planes, ["learned hyperplane", "learned hyperplanes"]);
            writeln!(stdout, "  hash: K = {planes}")?;
        }
        _ => {}
    }
    if let Some(point) = summary.measured.enough(Effort::Recall(0.95)) {
        writeln!(
            stdout,
            "  for {} of {} a search finds {} of the 10 nearest entries, an entry within {} of the nearest for {} of \
             the queries, and looks at {} of the index",
            counted(summary.measured.queries, ["query", "queries"]),
            queries_of(&summary.measured),
            percent(point.recall_at_10),
            format_args!("{:.0} %", 100.0 * EPS),
            percent(point.success()),
            percent(point.share_of_database),
        )?;
    } else {
        writeln!(
            stdout,
            "  for {} of {} no search finds 95 % of the 10 nearest entries, but {} at most: one that is asked for more \
             compares with every entry, or is refused where no descriptors are kept",
            counted(summary.measured.queries, ["query", "queries"]),
            queries_of(&summary.measured),
            percent(summary.measured.best_recall()),
        )?;
    }
    Ok(())
}
