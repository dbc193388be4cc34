//! One number for all that an index is made from, kept in its provenance: equal numbers mean equal
//! bytes.

use grasp_canonical::Encoder;
use grasp_index::{
    Calibration, ClassInfo, HashParams, IndexParams, KeptFields, NewEntry, Originals, RandomParams,
};
use xxhash_rust::xxh3::Xxh3;

/// Where the number stands in the provenance.
pub(crate) const KEY: &str = "inputs";
/// Where the provenance keeps how hands are seen, a [`PlanSpec`](crate::plan_spec::PlanSpec) as
/// text.
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

impl Inputs {
    /// Of no entries yet. `origin` is what is known beforehand of where the index comes from.
    pub(super) fn new(params: &IndexParams, origin: Vec<(String, String)>) -> Self {
        let mut hash = Xxh3::new();
        hash.update(encoded(params, &origin).bytes());
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

/// All that is known of an index before its entries. What it is measured with follows from the
/// parameters and the origin, which names it.
fn encoded(params: &IndexParams, origin: &[(String, String)]) -> Encoder {
    // Taken apart without `..`, so that a new parameter is not forgotten here.
    let IndexParams {
        descriptor,
        // The descriptor's fingerprint is also its network's.
        network: _,
        originals,
        kept,
        classes,
        hand_shapes,
        stages,
        hash,
        held_out: _,
        held_out_classes: _,
        seed,
        thumbnail_side,
        calibration,
        provenance: _,
    } = params;
    let Calibration { k, sigma_scale, floor, power, farthest, least_probability, measured: _ } = calibration;
    let KeptFields { labels, orientations, views, files, sources } = *kept;
    let mut to = Encoder::new();
    to.u32(grasp_index::FORMAT_VERSION).u64(descriptor.fingerprint());
    to.u8(match originals {
        Originals::F32 => 0,
        Originals::F16 => 1,
        Originals::None => 2,
    });
    for is_kept in [labels, orientations, views, files, sources] {
        to.u8(u8::from(is_kept));
    }
    to.count(classes.len());
    for ClassInfo { name, cutkosky } in classes {
        to.text(name).u8(*cutkosky);
    }
    for names in [hand_shapes, stages] {
        to.count(names.len());
        for name in names {
            to.text(name);
        }
    }
    match *hash {
        HashParams::Learned => to.u8(0),
        HashParams::Random(RandomParams::Auto) => to.u8(1),
        HashParams::Random(RandomParams::Fixed { k, t, buckets }) => to.u8(2).u32(k).u32(t).u32(buckets),
    };
    to.u64(*seed).u32(*thumbnail_side);
    to.u32(*k).f64s(&[*sigma_scale, *floor, *power, *least_probability]).option(farthest.as_ref());
    to.count(origin.len());
    for (key, text) in origin {
        to.text(key).text(text);
    }
    to
}

#[cfg(test)]
mod tests {
    use super::*;
    use xxhash_rust::xxh3::xxh3_64;

    #[test]
    fn the_number_of_an_index_of_nothing_is_pinned() {
        let params = IndexParams {
            classes: vec![ClassInfo { name: "pinch".to_owned(), cutkosky: 9 }],
            hand_shapes: vec!["mean".to_owned()],
            seed: 3,
            ..IndexParams::default()
        };
        let origin = vec![("source".to_owned(), "a test".to_owned())];
        let inputs = Inputs::new(&params, origin.clone());
        // Of what follows the versions: those of the format and the descriptor rise by themselves.
        let after = 1 + 4 + 8;
        assert_eq!(
            format!("{:016x}", xxh3_64(&encoded(&params, &origin).bytes()[after..])),
            "b42bbd8c107cbd74",
            "every index is built anew, as its inputs have another number: if that is meant, pin this"
        );
        assert_eq!(inputs.provenance().len(), 2);
        let other = IndexParams { thumbnail_side: 1, ..params.clone() };
        assert_ne!(Inputs::new(&other, origin).provenance(), inputs.provenance());
    }
}
