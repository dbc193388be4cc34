//! What is random in camera pictures.

/// Kinds of what camera scenes leave open. All of them are random unless a kind is left out, to
/// measure what it brings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Randomised {
    /// Lamps, the light from all around, and shadows; without, one lamp above the camera and half
    /// of the light from everywhere.
    pub light: bool,
    /// What lies behind the hand; without, one plain colour.
    pub background: bool,
    /// Rooms full of things behind it; without, a ground with a few things on it.
    pub clutter: bool,
    /// The skin's tone and what is uneven in it; without, an even one of medium tone.
    pub skin: bool,
    /// Patterns, shine and metal of what is held; without, it is plain and matt.
    pub materials: bool,
    /// The things that people hold; without, the plain bodies that the grasps close on.
    pub things: bool,
    /// Bent wrists, sleeves and watches; without, straight bare arms.
    pub arms: bool,
    /// Exposure, colour balance, blur, sharpening and noise; without, an ideal camera.
    pub camera: bool,
    /// Where the picture ends within a square around a hand; without, it does not.
    pub borders: bool,
}

impl Randomised {
    /// Everything.
    pub const ALL: Self = Self {
        light: true,
        background: true,
        clutter: true,
        skin: true,
        materials: true,
        things: true,
        arms: true,
        camera: true,
        borders: true,
    };
}
