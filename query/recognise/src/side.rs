//! Left and right.

use std::fmt;

use serde::{Deserialize, Serialize};

/// One of the two hands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// A left hand: its picture is flipped, recognised, and the answer flipped back.
    Left,
    /// A right hand, as in the index.
    #[default]
    Right,
}

impl Side {
    /// The other hand.
    pub fn other(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Left => "left",
            Self::Right => "right",
        })
    }
}

/// Which hand a picture is taken to show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(rename_all = "lowercase")]
pub enum HandChoice {
    /// Try both: neighbours, networks and where the arm comes from say which it is.
    #[default]
    Auto,
    /// A left hand.
    Left,
    /// A right hand.
    Right,
}

impl HandChoice {
    /// The hands to try, the first winning a tie.
    pub fn sides(self) -> &'static [Side] {
        match self {
            Self::Auto => &[Side::Right, Side::Left],
            Self::Left => &[Side::Left],
            Self::Right => &[Side::Right],
        }
    }
}
