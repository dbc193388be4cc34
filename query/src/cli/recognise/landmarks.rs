//! Landmarks in a file, as trackers of hands give them.

use std::path::Path;

use anyhow::Context as _;
use grasp_recognise::scene::{LandmarkUnit, Landmarks};
use serde::Deserialize;

/// The file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    unit: LandmarkUnit,
    landmarks: Vec<Place>,
}

/// `[x, y]` or `{"x": .., "y": ..}`; what else a tracker says of it is left alone.
#[derive(Deserialize)]
#[serde(untagged)]
enum Place {
    List([f64; 2]),
    Deep([f64; 3]),
    Named { x: f64, y: f64 },
}

impl Place {
    fn xy(&self) -> [f64; 2] {
        match *self {
            Place::List(place) => place,
            Place::Deep([x, y, _]) | Place::Named { x, y } => [x, y],
        }
    }
}

/// Reads the landmarks of a picture.
pub(super) fn read(path: &Path) -> anyhow::Result<Landmarks> {
    let about = || format!("cannot use the landmarks {}", path.display());
    let text = std::fs::read_to_string(path).with_context(about)?;
    let file: File = serde_json::from_str(&text).with_context(about)?;
    let places: Vec<[f64; 2]> = file.landmarks.iter().map(Place::xy).collect();
    Landmarks::new(&places, file.unit).with_context(about)
}
