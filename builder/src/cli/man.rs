//! `grasp-builder man`.

use anyhow::Context as _;

/// Print a manual page, e.g. `grasp-builder man | man -l -`.
#[derive(Debug, clap::Args)]
pub(crate) struct Man {
    /// The subcommand whose page to print, e.g. `grasp-builder man SUBCOMMAND`; without it, the
    /// program's own.
    subcommand: Option<String>,
}

impl Man {
    pub(crate) fn run(&self, mut program: clap::Command) -> anyhow::Result<()> {
        // Makes the global options known to the subcommands.
        program.build();
        let command = match &self.subcommand {
            None => program,
            Some(name) => program
                .find_subcommand(name)
                .with_context(|| format!("there is no subcommand {name}: see `grasp-builder --help`"))?
                .clone(),
        };
        let mut page = Vec::new();
        clap_mangen::Man::new(command).render(&mut page)?;
        std::io::Write::write_all(&mut std::io::stdout().lock(), &page)?;
        Ok(())
    }
}
