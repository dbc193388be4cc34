//! Completion scripts as shells can use them.

use std::io::Write as _;

use clap_complete::Shell;

/// Print a completion script for a shell.
#[derive(Debug, clap::Args)]
pub struct Completions {
    /// The shell. bash reads the script in ~/.local/share/bash-completion/completions, in a file of
    /// the program's name.
    shell: Shell,
}

impl Completions {
    /// Prints the script of a program.
    ///
    /// # Errors
    /// Where standard output cannot be written.
    pub fn run(&self, mut program: clap::Command) -> anyhow::Result<()> {
        let name = program.get_name().to_owned();
        // Into memory first: the generator panics where its writer fails, as a closed pipe does.
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut program, &name, &mut script);
        let script = with_subcommands(&String::from_utf8(script)?, &name);
        Ok(std::io::stdout().lock().write_all(script.as_bytes())?)
    }
}

/// Corrects the labels of subcommands in a bash script that `clap_complete` 4.6 has generated.
///
/// For a program with a dash in its name, the script assigns `grasp__query__subcmd__recognise` and
/// then compares with `grasp__subcmd__query__subcmd__recognise`, so that nothing is completed below
/// a subcommand. Scripts without that fault, and those of other shells, stay as they are.
fn with_subcommands(script: &str, program: &str) -> String {
    script.replace(&program.replace('-', "__subcmd__"), &program.replace('-', "__"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_those_that_are_assigned() {
        let (wrong, right) = ("grasp__subcmd__query__subcmd__man)", "grasp__query__subcmd__man)");
        assert_eq!(with_subcommands(wrong, "grasp-query"), right);
        assert_eq!(with_subcommands(right, "grasp-query"), right);
        assert_eq!(with_subcommands("#compdef grasp-query", "grasp-query"), "#compdef grasp-query");
    }
}
