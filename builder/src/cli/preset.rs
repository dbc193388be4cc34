//! The names of presets: an option that takes one, and that shells complete.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use grasp_renders::Preset;

/// Parses `--preset`. Options that use it set `hide_possible_values` and say what each is instead.
pub(super) fn preset() -> impl TypedValueParser<Value = Preset> {
    PossibleValuesParser::new(Preset::ALL.map(Preset::name)).try_map(|name| name.parse::<Preset>())
}
