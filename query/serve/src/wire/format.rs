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
    /// The media type, as the header `Accept` names it.
    pub(crate) fn media_type(self) -> &'static str {
        match self {
            Self::Json => "application/json",
            Self::Text => "text/plain",
            Self::Drawing => "image/png",
            Self::Moveit => "application/yaml",
        }
    }

    /// The format that the first media type of a header `Accept` names; a record where it names
    /// none.
    pub(crate) fn of_accept(accept: &str) -> Self {
        let first = accept.split([',', ';']).next().unwrap_or_default().trim();
        let others = [Self::Text, Self::Drawing, Self::Moveit];
        others.into_iter().find(|format| format.media_type() == first).unwrap_or(Self::Json)
    }
}
