//! One number for all that an index is made from, kept in its provenance: equal numbers mean equal bytes.

use grasp_index::{IndexParams, NewEntry};
use xxhash_rust::xxh3::Xxh3;

use super::Source;

/// Where the number stands in the provenance.
pub(crate) const KEY: &str = "inputs";
/// Where the provenance tells the options by which hands are seen.
pub(crate) const OPTIONS: &str = "options";

/// The running hash of the parameters and entries of an index.
pub(super) struct Inputs {
    hash: Xxh3,
    provenance: Vec<(String, String)>,
}

/// Which program makes the index.
pub(crate) fn tool() -> (String, String) {
    ("tool".to_owned(), concat!("grasp-builder ", env!("CARGO_PKG_VERSION")).to_owned())
}

/// Where an index of `source` comes from, measured by what `held_out` tells of, on hands that are seen by the options `seen`.
pub(super) fn origin(source: &Source, held_out: Option<String>, seen: Option<&str>) -> Vec<(String, String)> {
    let mut provenance = vec![tool()];
    match source {
        Source::Plan(plan) => {
            let hands = plan.hand_shapes.len() + plan.hand_models.len();
            let (grasps, views) = (plan.grasps.len(), plan.views.count());
            let scenes = plan.renders() / views.max(1);
            let text = format!(
                "rendered: {scenes} scenes (hand shapes: {hands}, grasps: {grasps}) of {views} views, seed {}",
                plan.seed
            );
            provenance.push(("source".to_owned(), text));
        }
        Source::Sets(sets) => provenance.extend(sets.iter().map(|set| {
            let text =
                format!("{}, {} pictures, manifest xxh3 {:016x}", set.name(), set.len(), set.manifest_hash());
            ("render set".to_owned(), text)
        })),
        Source::Vectors(vectors) => provenance.push(("vectors".to_owned(), vectors.provenance())),
    }
    provenance.extend(seen.map(|seen| (OPTIONS.to_owned(), seen.to_owned())));
    provenance.extend(held_out.map(|held_out| ("held out".to_owned(), held_out)));
    provenance
}

impl Inputs {
    /// Of no entries yet. `origin` is what is known beforehand of where the index comes from.
    pub(super) fn new(params: &IndexParams, origin: Vec<(String, String)>) -> Self {
        let mut hash = Xxh3::new();
        // Debug prints every field, and floats so that they read back exactly.
        hash.update(format!("{} {params:?} {origin:?}", grasp_index::FORMAT_VERSION).as_bytes());
        Self { hash, provenance: origin }
    }

    /// Adds an entry. Its descriptor and thumbnail follow from the source hash and the parameters.
    pub(super) fn add(&mut self, entry: &NewEntry) {
        for text in [&entry.object, &entry.file] {
            self.hash.update(&(text.len() as u64).to_le_bytes());
            self.hash.update(text.as_bytes());
        }
        let view = [entry.azimuth_deg, entry.elevation_deg, entry.roll_deg];
        view.iter().for_each(|angle| self.hash.update(&angle.to_le_bytes()));
        entry.orientation.coords.iter().for_each(|value| self.hash.update(&value.to_le_bytes()));
        self.hash.update(&entry.class.to_le_bytes());
        self.hash.update(&[entry.stage]);
        self.hash.update(&entry.hand_shape.to_le_bytes());
        self.hash.update(&entry.source_hash.to_le_bytes());
    }

    /// What the index says of its origin, this number included.
    pub(super) fn provenance(&self) -> Vec<(String, String)> {
        let mut provenance = self.provenance.clone();
        provenance.push((KEY.to_owned(), format!("{:016x}", self.hash.digest())));
        provenance
    }
}
