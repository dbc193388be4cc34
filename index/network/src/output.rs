//! What a network answers.

/// What a network returns for one picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output<'a> {
    /// [`Architecture::embedding`](crate::Architecture::embedding) values.
    pub embedding: &'a [f32],
    /// [`Architecture::heads`](crate::Architecture::heads) values.
    pub heads: &'a [f32],
    /// Logits `[mask][y][x]` of a side of
    /// [`Architecture::mask_side`](crate::Architecture::mask_side); empty without masks.
    pub masks: &'a [f32],
}
