//! What is known about an index, under the names that `grasp-builder inspect --json` uses.

use grasp_index::{EPS_GRID, HashInfo, Index};
use serde_json::{Value, json};

/// All of it.
pub(crate) fn info(file: &str, index: &Index) -> Value {
    let catalogue = index.catalogue();
    let measured = &catalogue.measured;
    let mut counts = vec![0u64; catalogue.classes.len()];
    for &label in index.labels() {
        if let Some(count) = counts.get_mut(usize::from(label)) {
            *count += 1;
        }
    }
    let classes = catalogue.classes.iter().zip(counts);
    let classes: Vec<Value> = classes
        .map(|(class, entries)| json!({"name": class.name, "cutkosky": class.cutkosky, "entries": entries}))
        .collect();
    let hash = match catalogue.hash {
        HashInfo::Random(hash) => json!({
            "kind": "random", "tables": hash.tables, "planes": hash.planes, "buckets": hash.buckets,
        }),
        HashInfo::Learned(hash) => json!({
            "kind": "learned", "tables": 1, "planes": hash.planes, "axes": hash.axes, "groups": hash.groups,
        }),
        _ => Value::Null,
    };
    let point = |point: &grasp_index::EffortPoint| {
        json!({
            "probes": point.probes, "recall_at_10": point.recall_at_10, "eps_success": point.eps_success,
            "share_of_database": point.share_of_database,
        })
    };
    let curve: Vec<Value> = measured.curve.iter().map(point).collect();
    let provenance: Vec<Value> =
        catalogue.provenance.iter().map(|(name, value)| json!({"name": name, "value": value})).collect();
    json!({
        "file": file, "entries": index.len(), "bytes": index.byte_len(),
        "recognises": index.check_recognises().is_ok(),
        "descriptor": {"name": catalogue.descriptor.name(), "dim": index.dim()},
        "originals": catalogue.originals.name(), "keeps": catalogue.kept.names(),
        "classes": classes, "hand_shapes": catalogue.hand_shapes, "stages": catalogue.stages,
        "hash": hash,
        "measured": {
            "queries": measured.queries, "held_out": measured.held_out, "noise": measured.noise,
            "eps": EPS_GRID, "curve": curve,
        },
        "thumbnail_side": catalogue.thumbnail_side, "seed": catalogue.seed, "provenance": provenance,
    })
}
