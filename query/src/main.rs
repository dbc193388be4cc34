//! The `grasp-query` program; everything it does is in the library beside it.

use std::process::ExitCode;

fn main() -> ExitCode {
    grasp_query::cli::main()
}
