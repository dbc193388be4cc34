//! In which form an index keeps its descriptors.

/// In which form an index keeps its descriptors, besides what its hash makes of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Originals {
    /// As they are: distances are exact.
    #[default]
    F32,
    /// In half the space: distances are right to about 0.1 %.
    F16,
    /// Not at all: distances are as exact as the codes of a learned hash.
    None,
}

impl Originals {
    /// All forms.
    pub const ALL: [Self; 3] = [Self::F32, Self::F16, Self::None];

    /// `f32`, `f16` or `none`.
    pub fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F16 => "f16",
            Self::None => "none",
        }
    }

    /// The form of this name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|originals| originals.name() == name)
    }
}
