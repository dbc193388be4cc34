//! From the command line to the exit status.

use std::io::{self, Write as _};
use std::process::ExitCode;

use clap::Parser;
use grasp_terminal::error::message;
use grasp_terminal::text::printable_lines;

use crate::global::Global;
use crate::status::{ERROR, SUCCESS};

/// Parses the command line, runs it and turns the outcome into an exit status: that of `run`, or
/// [`ERROR`] and a message. `program` is its name and version; `global` finds what every subcommand
/// understands among its arguments.
pub fn start<A: Parser>(
    program: [&'static str; 2],
    global: impl Fn(&mut A) -> &mut Global,
    run: impl FnOnce(&A) -> anyhow::Result<u8>,
) -> ExitCode {
    let [name, _] = program;
    let (mut arguments, command) = match parse::<A>() {
        Ok(parsed) => parsed,
        Err(message) => return end_with_usage(name, &message),
    };
    let shared = global(&mut arguments);
    shared.program = name;
    let (log, threads) = (shared.log, shared.start_threads());
    let work = || match threads.and_then(|()| run(&arguments)) {
        Ok(status) => status,
        Err(error) if is_closed_pipe(&error) => SUCCESS,
        Err(error) => {
            tracing::error!(subject = name, "{}", said(&error));
            ERROR
        }
    };
    ExitCode::from(grasp_log::run(&log, program, &command, work))
}

/// The command line, and the name of its command.
fn parse<A: Parser>() -> clap::error::Result<(A, String)> {
    let matches = A::command().try_get_matches()?;
    let command = matches.subcommand_name().unwrap_or_default().to_owned();
    Ok((A::from_arg_matches(&matches)?, command))
}

fn end_with_usage(program: &str, message: &clap::Error) -> ExitCode {
    // `--help` and `--version` come this way too, with exit code 0.
    let status = u8::try_from(message.exit_code()).unwrap_or(ERROR);
    match print_usage(message) {
        Ok(()) => ExitCode::from(status),
        Err(problem) if problem.kind() == io::ErrorKind::BrokenPipe => ExitCode::from(SUCCESS),
        Err(problem) => {
            // There is no log yet, and where standard error is what failed, nobody to tell.
            let _ = writeln!(io::stderr(), "{program}: {}", said(&problem.into()));
            ExitCode::from(ERROR)
        }
    }
}

/// What went wrong. Who opens, reads or writes a file names it; where no room is left for something
/// without a name, it is the standard output.
fn said(error: &anyhow::Error) -> String {
    use io::ErrorKind::{FileTooLarge, QuotaExceeded, StorageFull};
    let text = message(error.chain());
    let is_full = |error: &io::Error| matches!(error.kind(), StorageFull | QuotaExceeded | FileTooLarge);
    match error.chain().next().and_then(|outermost| outermost.downcast_ref()).is_some_and(is_full) {
        true => format!("cannot write to standard output: {text}"),
        false => text,
    }
}

/// Prints a usage error, or the help that was asked for. An argument with control characters, such
/// as the odd name of a file that begins with a dash, is escaped, which costs the colours.
fn print_usage(message: &clap::Error) -> io::Result<()> {
    let plain = message.render().to_string();
    let safe = printable_lines(&plain);
    if safe == plain { message.print() } else { io::stderr().write_all(safe.as_bytes()) }
}

/// A reader that has seen enough (`| head`) is no failure of ours. Nothing but the standard output
/// is written to a pipe: what is asked of a service turns its errors into text.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error
        .chain()
        .filter_map(|cause| cause.downcast_ref::<io::Error>())
        .any(|cause| cause.kind() == io::ErrorKind::BrokenPipe)
}
