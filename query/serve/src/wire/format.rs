//! The formats of an answer, by their media types.

/// In which format an answer is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// The record that `--json` prints.
    Json,
    /// The text that a person reads.
    Text,
    /// The drawing that `--explain` makes.
    Drawing,
    /// The robot's strategy as the YAML that `--format moveit` prints.
    Moveit,
}

impl Format {
    /// All of them, the preferred first.
    pub(crate) const ALL: [Self; 4] = [Self::Json, Self::Text, Self::Drawing, Self::Moveit];

    /// The media type, as the header `Accept` names it.
    pub(crate) fn media_type(self) -> &'static str {
        match self {
            Self::Json => "application/json",
            Self::Text => "text/plain",
            Self::Drawing => "image/png",
            Self::Moveit => "application/yaml",
        }
    }
}
