//! A picture becomes an entry.

use anyhow::Context as _;
use grasp_index::{Describer, NewEntry};

use super::known::{Known, KnownPicture};
use super::recipe::Recipe;
use crate::descriptor::hand_in;

/// A picture that has become an entry (and whether an existing index knew it), or shows no hand.
pub(crate) type Described = Option<(NewEntry, bool)>;

/// What takes described pictures, in the order of the source.
pub(crate) type Take<'t> = &'t mut dyn FnMut(Vec<Described>) -> anyhow::Result<()>;

/// Puts descriptor and thumbnail of a grey picture into `entry`: taken over from the existing index
/// where it knows `entry.source_hash`, made from the picture otherwise. `None` where the picture
/// shows no hand.
pub(super) fn complete(
    entry: NewEntry,
    recipe: &Recipe,
    describer: &mut Describer,
    known: &Known,
    picture: impl FnOnce() -> anyhow::Result<Grey>,
) -> anyhow::Result<Described> {
    if let Some(known) = known.get(entry.source_hash, entry.roll_deg) {
        let KnownPicture { descriptor, thumbnail, turn_deg } = known;
        return Ok(Some((NewEntry { descriptor, thumbnail, ..entry.turned(turn_deg) }, true)));
    }
    let Grey { width, height, pixels } = picture()?;
    let hand = hand_in(width, height, &pixels).with_context(|| format!("cannot use {}", entry.file))?;
    let Some(hand) = hand else { return Ok(None) };
    let hand = hand.shrunk_to(recipe.descriptor.params().described_side());
    let turn_deg = recipe.descriptor.params().turn_deg(&hand);
    let turned = hand.rotated(turn_deg.to_radians());
    let descriptor = describer.describe_turned(&hand, turn_deg, &turned);
    let thumbnail = (recipe.thumbnail_side > 0).then(|| turned.thumbnail(recipe.thumbnail_side as usize));
    Ok(Some((NewEntry { descriptor, thumbnail, ..entry.turned(turn_deg) }, false)))
}

/// A grey picture, row by row.
pub(super) struct Grey {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) pixels: Vec<u8>,
}
