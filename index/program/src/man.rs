//! Manual pages.

use std::io::Write as _;

use anyhow::Context as _;

/// Print a manual page, for `man -l -` to show.
#[derive(Debug, clap::Args)]
pub struct Man {
    /// The subcommand whose page to print; without it, the program's own.
    subcommand: Option<String>,
}

impl Man {
    /// Prints the page of a program, or of its subcommand.
    ///
    /// # Errors
    /// Where there is no such subcommand, or standard output cannot be written.
    pub fn run(&self, mut program: clap::Command) -> anyhow::Result<()> {
        // Makes the global options known to the subcommands.
        program.build();
        let missing = |name| format!("there is no subcommand {name}: see `{} --help`", program.get_name());
        let command = match &self.subcommand {
            None => &program,
            Some(name) => program.find_subcommand(name).with_context(|| missing(name))?,
        };
        let mut page = Vec::new();
        clap_mangen::Man::new(command.clone()).render(&mut page)?;
        Ok(std::io::stdout().lock().write_all(&page)?)
    }
}
