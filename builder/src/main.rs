//! The `grasp-builder` program; everything it does is in the library beside it.

use std::process::ExitCode;

fn main() -> ExitCode {
    grasp_builder::cli::main()
}
