//! Where the hand was in the frame before: in a video that is where it is looked for first.

use crate::networks::Networks;
use crate::picture::Picture;
use crate::scene::{self, Detection, Scene};

/// So many frames after it was looked for in the whole picture, the hand is looked for there again:
/// what was found wrongly, or turned wrongly, is not followed for longer than a second.
const AGAIN: u32 = 30;

/// Follows the hand through the frames of a video.
#[derive(Clone, Debug, Default)]
pub struct Tracker {
    /// The hand in the frame before, and that picture's width and height.
    last: Option<(Detection, (usize, usize))>,
    /// Frames since the hand was looked for in the whole picture.
    followed: u32,
    searches: u64,
}

impl Tracker {
    /// In how many frames the hand was looked for in the whole picture: in the first, where it was
    /// lost, and every now and then.
    pub fn searches(&self) -> u64 {
        self.searches
    }

    /// The hand where it was in the frame before, or near it.
    pub(crate) fn follow(&mut self, networks: &Networks, picture: &Picture) -> Option<Detection> {
        let size = (picture.width(), picture.height());
        let (before, _) = self.last.take().filter(|(_, before)| *before == size && self.followed < AGAIN)?;
        self.followed += 1;
        scene::follow(networks, picture, &before)
    }

    /// The hand anywhere in the picture.
    pub(crate) fn search(&mut self, networks: &Networks, picture: &Picture) -> Option<Detection> {
        self.searches += 1;
        self.followed = 0;
        self.last = None;
        scene::find(networks, picture)
    }

    /// Begins there in the next frame.
    pub(crate) fn keep(&mut self, scene: Option<&Scene>, size: (usize, usize)) {
        self.last = scene.map(|scene| (scene.found.clone(), size));
    }
}
