//! Manual pages.

use std::io::Write as _;

use anyhow::Context as _;
use clap::Command;
use clap::builder::{Resettable, StyledStr};
use roff::{Roff, roman};

/// How the line begins that says what an exit status means.
const EXIT_STATUS: &str = "Exit status: ";

/// Print a manual page, for `man -l -` to show.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-query man | man -l -
  grasp-query man experiment paper | man -l -
  grasp-builder man build > grasp-builder-build.1")]
pub struct Man {
    /// The subcommand whose page to print, with that below it where there is one; without it, the
    /// program's own.
    #[arg(value_name = "SUBCOMMAND")]
    path: Vec<String>,
}

impl Man {
    /// Prints the page of a program, or of its subcommand.
    ///
    /// # Errors
    /// Where there is no such subcommand, or standard output cannot be written.
    pub fn run(&self, mut program: Command) -> anyhow::Result<()> {
        // Makes the global options known to the subcommands.
        program.build();
        let name = self.path.join("-");
        let missing =
            || format!("there is no subcommand {}: see `{} --help`", self.path.join(" "), program.get_name());
        let command = found(&program, &name).with_context(missing)?;
        Ok(std::io::stdout().lock().write_all(&page(command)?)?)
    }
}

/// The subcommand of that name, as pages name it: below another, it has that one's name and a
/// hyphen before its own.
fn found<'a>(command: &'a Command, name: &str) -> Option<&'a Command> {
    if name.is_empty() {
        return Some(command);
    }
    command.get_subcommands().find_map(|below| {
        let rest = name.strip_prefix(below.get_name())?;
        match rest.is_empty() {
            true => Some(below),
            false => found(below, rest.strip_prefix('-')?),
        }
    })
}

/// What `man` shows of a command. Examples keep their lines, and options that only `--help` shows
/// are explained as well.
fn page(command: &Command) -> std::io::Result<Vec<u8>> {
    let after = command.get_after_help().map(StyledStr::to_string).unwrap_or_default();
    let command = command
        .clone()
        .mut_args(|argument| argument.hide_short_help(false))
        .after_help(Resettable::<StyledStr>::Reset);
    let mut page = Vec::new();
    clap_mangen::Man::new(command).render(&mut page)?;
    let mut sections = Roff::new();
    let mut is_verbatim = false;
    for line in after.lines() {
        let is_indented = line.starts_with(' ');
        if is_indented != is_verbatim {
            sections.control(if is_indented { "nf" } else { "fi" }, []);
            is_verbatim = is_indented;
        }
        if let Some(status) = line.strip_prefix(EXIT_STATUS) {
            sections.control("SH", ["EXIT STATUS"]).text([roman(status)]);
        } else if let Some(title) = line.strip_suffix(':').filter(|title| !title.contains(' ')) {
            sections.control("SH", [title.to_uppercase().as_str()]);
        } else if line.is_empty() {
            sections.control("PP", []);
        } else {
            sections.text([roman(line)]);
        }
    }
    sections.to_writer(&mut page)?;
    Ok(page)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Arg;

    fn program() -> Command {
        let below = Command::new("paper")
            .about("Repeat it.")
            .arg(Arg::new("rounds").long("rounds").help("How many.").hide_short_help(true))
            .after_help("Examples:\n  q experiment paper  # all\n\nExit status: 0, or 2.");
        let mut program = Command::new("q").subcommand(Command::new("experiment").subcommand(below));
        program.build();
        program
    }

    #[test]
    fn a_page_has_every_option_and_examples_line_by_line() {
        let program = program();
        let page = page(found(&program, "experiment-paper").unwrap()).unwrap();
        let page = String::from_utf8(page).unwrap();
        assert!(page.contains("How many."), "{page}");
        assert!(page.contains(".SH EXAMPLES\n.nf\n  q experiment paper  # all\n.fi\n"), "{page}");
        assert!(page.ends_with(".SH \"EXIT STATUS\"\n0, or 2.\n"), "{page}");
    }

    #[test]
    fn subcommands_are_found_as_pages_name_them() {
        let program = program();
        let name = |path: &str| found(&program, path).map(|command| command.get_name().to_owned());
        assert_eq!(name("").as_deref(), Some("q"));
        assert_eq!(name("experiment").as_deref(), Some("experiment"));
        assert_eq!(name("experiment-paper").as_deref(), Some("paper"));
        assert_eq!(name("experiments"), None);
        assert_eq!(name("paper"), None);
    }
}
