//! `grasp-query man`.

use anyhow::Context as _;

use super::status::SUCCESS;

/// Print a manual page, e.g. `grasp-query man | man -l -`.
#[derive(Debug, clap::Args)]
pub(super) struct Man {
    /// The subcommand whose page to print, e.g. `grasp-query man SUBCOMMAND`; without it, the
    /// program's own.
    subcommand: Option<String>,
}

impl Man {
    pub(super) fn run(&self, mut program: clap::Command) -> anyhow::Result<u8> {
        // Makes the global options known to the subcommands.
        program.build();
        let command = match &self.subcommand {
            None => program,
            Some(name) => program
                .find_subcommand(name)
                .with_context(|| format!("there is no subcommand {name}: see `grasp-query --help`"))?
                .clone(),
        };
        let mut page = Vec::new();
        clap_mangen::Man::new(command).render(&mut page)?;
        std::io::Write::write_all(&mut std::io::stdout().lock(), &page)?;
        Ok(SUCCESS)
    }
}
