//! Names that come with the program, for options that take a file as well: shells complete them.

use std::ffi::OsStr;

use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};

/// Accepts any text, which is a name or a file; completion scripts and suggestions know the names.
///
/// Options that use it set `hide_possible_values`: help would otherwise say that nothing else is
/// possible.
#[derive(Clone, Debug)]
pub(super) struct NameOrFile(Vec<&'static str>);

impl NameOrFile {
    pub(super) fn new(names: impl IntoIterator<Item = &'static str>) -> Self {
        Self(names.into_iter().collect())
    }
}

impl TypedValueParser for NameOrFile {
    type Value = String;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&clap::Arg>,
        value: &OsStr,
    ) -> Result<String, clap::Error> {
        StringValueParser::new().parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(self.0.iter().map(PossibleValue::new)))
    }
}
