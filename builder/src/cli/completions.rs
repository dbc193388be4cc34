//! `grasp-builder completions SHELL`.

use clap_complete::Shell;
use grasp_terminal::completions::with_subcommands;

/// Print a completion script for a shell.
#[derive(Debug, clap::Args)]
pub(crate) struct Completions {
    /// The shell to complete for, e.g. `grasp-builder completions bash >
    /// ~/.local/share/bash-completion/completions/grasp-builder`.
    shell: Shell,
}

impl Completions {
    pub(crate) fn run(&self, mut program: clap::Command) -> anyhow::Result<()> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut program, "grasp-builder", &mut script);
        let script = with_subcommands(&String::from_utf8(script)?, "grasp-builder");
        std::io::Write::write_all(&mut std::io::stdout().lock(), script.as_bytes())?;
        Ok(())
    }
}
