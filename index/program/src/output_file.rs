//! Files that a command writes.

use std::ffi::OsStr;
use std::path::PathBuf;

use clap::builder::{PathBufValueParser, TypedValueParser};

/// Parses the name of a file to write, where that cannot be standard output: `-` is none.
#[must_use]
pub fn output_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match path.as_os_str() == OsStr::new("-") {
        true => Err("this cannot go to standard output: name a file (./- for one of that name)"),
        false => Ok(path),
    })
}
