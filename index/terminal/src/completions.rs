//! Completion scripts as shells can use them.

/// Corrects the labels of subcommands in a bash script that `clap_complete` 4.6 has generated.
///
/// For a program with a dash in its name, the script assigns `grasp__query__subcmd__recognise` and
/// then compares with `grasp__subcmd__query__subcmd__recognise`, so that nothing is completed below
/// a subcommand. Scripts without that fault, and those of other shells, stay as they are.
#[must_use]
pub fn with_subcommands(script: &str, program: &str) -> String {
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
