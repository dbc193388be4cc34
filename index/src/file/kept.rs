//! What an index keeps of its entries.

/// What an index keeps of each entry besides its descriptor. What it does not keep takes no space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeptFields {
    /// Class, stage, hand shape and object. Without them neighbours are found, but cannot vote.
    pub labels: bool,
    /// `camera_from_hand`. Without it neighbours vote on the class alone.
    pub orientations: bool,
    /// The camera's azimuth, elevation and roll.
    pub views: bool,
    /// The file name.
    pub files: bool,
    /// The hash of what the descriptor was made from. Without it a rebuild starts from nothing.
    pub sources: bool,
}

impl Default for KeptFields {
    /// Everything.
    fn default() -> Self {
        Self { labels: true, orientations: true, views: true, files: true, sources: true }
    }
}

impl KeptFields {
    /// The names of what is kept.
    pub fn names(&self) -> Vec<&'static str> {
        let Self { labels, orientations, views, files, sources } = *self;
        let all = [
            (labels, "labels"),
            (orientations, "orientations"),
            (views, "views"),
            (files, "files"),
            (sources, "sources"),
        ];
        all.into_iter().filter_map(|(is_kept, name)| is_kept.then_some(name)).collect()
    }

    /// Nothing.
    pub fn nothing() -> Self {
        Self { labels: false, orientations: false, views: false, files: false, sources: false }
    }
}
