//! Scenes that leave out a kind of what is random, to measure what it brings.

use grasp_renders::Randomised;
use serde::{Deserialize, Serialize};

/// A kind of what is random in the scenes that a network of scenes learns from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum LeftOut {
    /// Lamps, light from all around and shadows.
    Light,
    /// What lies behind the hand.
    Background,
    /// Rooms full of things behind it.
    Clutter,
    /// Skin tones, and what is uneven in them.
    Skin,
    /// Patterns, shine and metal of what is held.
    Materials,
    /// Things that people hold, in place of plain bodies.
    Things,
    /// Bent wrists, sleeves and watches.
    Arms,
    /// Exposure, colour balance, blur, sharpening and noise.
    Camera,
    /// Borders of pictures within the square that is looked at.
    Borders,
    /// Things that are held up, and hands that are posed as another grasp's.
    Ways,
    /// Pictures that are made harder than a camera's.
    Hard,
}

impl LeftOut {
    /// What is random in pictures without these.
    pub(super) fn randomised(left_out: &[Self]) -> Randomised {
        let has = |kind| !left_out.contains(&kind);
        Randomised {
            light: has(Self::Light),
            background: has(Self::Background),
            clutter: has(Self::Clutter),
            skin: has(Self::Skin),
            materials: has(Self::Materials),
            things: has(Self::Things),
            arms: has(Self::Arms),
            camera: has(Self::Camera),
            borders: has(Self::Borders),
        }
    }

    /// As it is written on the command line.
    pub(super) fn name(self) -> String {
        clap::ValueEnum::to_possible_value(&self)
            .map_or_else(String::new, |value| value.get_name().to_owned())
    }
}
