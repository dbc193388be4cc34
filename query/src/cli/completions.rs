//! `grasp-query completions`.

use grasp_terminal::completions::with_subcommands;

use super::status::SUCCESS;

/// Print a shell's completion script, e.g. `grasp-query completions bash >
/// /etc/bash_completion.d/grasp-query`.
#[derive(Debug, clap::Args)]
pub(super) struct Completions {
    /// The shell.
    shell: clap_complete::Shell,
}

impl Completions {
    pub(super) fn run(&self, mut program: clap::Command) -> anyhow::Result<u8> {
        // Into memory first: the generator panics where its writer fails, as a closed pipe does.
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut program, "grasp-query", &mut script);
        let script = with_subcommands(&String::from_utf8(script)?, "grasp-query");
        std::io::Write::write_all(&mut std::io::stdout().lock(), script.as_bytes())?;
        Ok(SUCCESS)
    }
}
