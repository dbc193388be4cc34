//! `grasp-builder inspect`.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::Context as _;
use grasp_index::{
    Calibration, Catalogue, DescriptorKind, DescriptorParams, EPS, EPS_GRID, HashInfo, Index, Measured,
    Sampling, Tone,
};
use grasp_terminal::text::{counted, percent, printable};
use serde_json::{Value, json};

use super::build::ENTRIES;

/// Show what is in an index: its entries, parameters, origin, and how well its search does.
#[derive(Debug, clap::Args)]
pub(crate) struct Inspect {
    /// The index.
    #[arg(value_name = "FILE")]
    index: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

impl Inspect {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        let name = self.index.display();
        let index = Index::open(&self.index).with_context(|| format!("cannot inspect {name}"))?;
        // The names in it come from whoever made it.
        let text = match self.json {
            true => format!("{}\n", as_json(&name.to_string(), &index)),
            false => as_text(&name.to_string(), &index)
                .lines()
                .map(|line| format!("{}\n", printable(line)))
                .collect(),
        };
        index.check_unchanged().with_context(|| format!("cannot inspect {name}"))?;
        write!(std::io::stdout().lock(), "{text}")?;
        Ok(())
    }
}

const PLANES: [&str; 2] = ["hyperplane", "hyperplanes"];
const QUERIES: [&str; 2] = ["query", "queries"];

/// How many entries each class has.
fn counts(index: &Index) -> Vec<usize> {
    let mut counts = vec![0; index.catalogue().classes.len()];
    for &label in index.labels() {
        if let Some(count) = counts.get_mut(label as usize) {
            *count += 1;
        }
    }
    counts
}

fn as_text(name: &str, index: &Index) -> String {
    let catalogue = index.catalogue();
    let (entries, bytes) = (counted(index.len(), ENTRIES), counted(index.byte_len(), ["byte", "bytes"]));
    let mut lines = vec![format!("{}: {entries}, {bytes}", printable(name))];
    let mut line = |label: &str, text: String| lines.push(format!("  {label:<12} {text}"));
    let descriptor = &catalogue.descriptor;
    let (name, dim) = (descriptor.name(), index.dim());
    let described = match descriptor.kind {
        DescriptorKind::Raw { .. } => format!("{name}, D = {dim}: vectors from elsewhere"),
        DescriptorKind::Learned { network, .. } => {
            format!("{name}, D = {dim}: of hands turned upright, by the network {}", fingerprint(network))
        }
        DescriptorKind::Paper | DescriptorKind::Default => format!(
            "{name}, D = {dim} (B = {}, L = {}), {}, {}",
            descriptor.bins,
            descriptor.levels,
            sampling_text(descriptor.sampling),
            tone_text(descriptor.tone)
        ),
    };
    line("descriptor", described);
    line("originals", catalogue.originals.name().to_owned());
    line("keeps", some_of(&catalogue.kept.names()));
    for (class, count) in catalogue.classes.iter().zip(counts(index)) {
        line("class", format!("{:>2} {}: {}", class.cutkosky, class.name, counted(count, ENTRIES)));
    }
    if catalogue.kept.labels {
        line("hand shapes", list(&catalogue.hand_shapes));
        line("stages", list(&catalogue.stages));
    }
    line(
        "sigma",
        format!(
            "{:.4} (Equation 5 as printed: {:.1})",
            catalogue.sigma.mean_distance, catalogue.sigma.literal
        ),
    );
    for text in vote_text(&catalogue.calibration) {
        line("vote", text);
    }
    line("hash", hash_text(catalogue));
    line("measured", measured_text(&catalogue.measured));
    for point in &catalogue.measured.curve {
        line(
            "effort",
            format!(
                "{:>11}: recall@10 {:.4}, eps-success {:.4} at {EPS}, {} of the index",
                counted(point.probes, ["probe", "probes"]),
                point.recall_at_10,
                point.success(),
                percent(point.share_of_database)
            ),
        );
    }
    line("thumbnails", format!("{} pixels a side", catalogue.thumbnail_side));
    line("seed", catalogue.seed.to_string());
    for (key, value) in &catalogue.provenance {
        line(key, value.clone());
    }
    for section in &catalogue.sections {
        line(
            "section",
            format!(
                "{:<16} {:>12} bytes at {:>10}, {:?}, xxh3 {:016x}",
                format!("{:?}", section.kind),
                section.length,
                section.offset,
                section.element,
                section.xxh3
            ),
        );
    }
    lines.join("\n") + "\n"
}

/// A network's fingerprint, as `train` prints it.
fn fingerprint(network: u64) -> String {
    format!("{network:016x}")
}

/// The fingerprint of the network that describes pictures, where one does.
fn network(descriptor: &DescriptorParams) -> Option<String> {
    match descriptor.kind {
        DescriptorKind::Learned { network, .. } => Some(fingerprint(network)),
        _ => None,
    }
}

/// How a hand image becomes the picture that is described.
fn sampling_text(sampling: Sampling) -> String {
    match sampling {
        Sampling::Native => "its own pixels".to_owned(),
        Sampling::KeepAspect { side } => format!("fitted into {side} pixels a side"),
        Sampling::Upright { side } => format!("turned upright and fitted into {side} pixels a side"),
    }
}

fn tone_text(tone: Tone) -> String {
    match tone {
        Tone::AsIs => "grey as it is".to_owned(),
        Tone::Normalised { contrast } => format!("contrast {contrast}"),
    }
}

fn hash_text(catalogue: &Catalogue) -> String {
    match catalogue.hash {
        HashInfo::Random(hash) => format!(
            "random, T = {} of K = {}, H = {}",
            counted(hash.tables, ["table", "tables"]),
            counted(hash.planes, PLANES),
            counted(hash.buckets, ["bucket", "buckets"])
        ),
        HashInfo::Learned(hash) => format!(
            "learned, K = {}, {}, {}",
            counted(hash.planes, PLANES),
            counted(hash.axes, ["principal axis", "principal axes"]),
            counted(hash.groups, ["group of centres", "groups of centres"])
        ),
        _ => "of a kind that this version does not know".to_owned(),
    }
}

/// How neighbours are weighed, and what that is worth.
fn vote_text(calibration: &Calibration) -> Vec<String> {
    let Calibration { k, sigma_scale, floor, power, .. } = calibration;
    let mut lines = vec![format!("k = {k}, sigma x {sigma_scale}")];
    let Some(measured) = &calibration.measured else {
        lines.push("not calibrated: the probability is the share of the weights".to_owned());
        return lines;
    };
    lines.push(format!("probability: (share + {floor})^{power:.3}, divided by the sum of all classes"));
    if let Some(farthest) = calibration.farthest {
        let least = calibration.least_probability;
        lines.push(format!(
            "unknown: farther than {farthest:.3} from all entries, or a probability below {least:.2}"
        ));
    }
    let [least, most] = measured.noise;
    lines.push(format!(
        "{} of held-out hands, moved by {least} to {most} sigma: {:.1} % right, log-likelihood {:.3}, calibration error {:.3}",
        counted(measured.reliability.n(), QUERIES),
        measured.reliability.accuracy().unwrap_or(0.0) * 100.0,
        measured.log_likelihood,
        measured.reliability.expected_error().unwrap_or(0.0),
    ));
    lines
}

fn vote_json(calibration: &Calibration) -> Value {
    let Calibration { k, sigma_scale, floor, power, farthest, least_probability, .. } = calibration;
    let measured = calibration.measured.as_ref().map(|measured| {
        let reliability = &measured.reliability;
        let bins = reliability.bins.iter().filter(|bin| bin.n > 0);
        let bins: Vec<Value> = bins
            .map(|bin| json!({"n": bin.n, "probability": bin.stated(), "right": bin.found()}))
            .collect();
        json!({
            "queries": reliability.n(), "noise": measured.noise, "top1": reliability.accuracy(),
            "log_likelihood": measured.log_likelihood, "ece": reliability.expected_error(), "reliability": bins,
        })
    });
    json!({"k": k, "sigma_scale": sigma_scale, "floor": floor, "power": power, "farthest": farthest, "least_probability": least_probability, "measured": measured})
}

/// The names of a list, if any.
fn some_of(names: &[&str]) -> String {
    if names.is_empty() { "nothing else".to_owned() } else { names.join(", ") }
}

fn measured_text(measured: &Measured) -> String {
    let whose = if measured.held_out { "held-out hands" } else { "entries, each held out for its own query" };
    let [least, most] = measured.noise;
    format!("{} of {whose}, moved by {least} to {most} sigma", counted(measured.queries, QUERIES))
}

/// The first names of a list, and how many more there are.
fn list(names: &[String]) -> String {
    const SHOWN: usize = 8;
    let shown = names.iter().take(SHOWN).map(String::as_str).collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(SHOWN) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

fn as_json(name: &str, index: &Index) -> Value {
    let catalogue = index.catalogue();
    let measured = &catalogue.measured;
    let classes: Vec<Value> = catalogue
        .classes
        .iter()
        .zip(counts(index))
        .map(|(class, entries)| json!({"name": class.name, "cutkosky": class.cutkosky, "entries": entries}))
        .collect();
    let sections: Vec<Value> = catalogue
        .sections
        .iter()
        .map(|section| {
            json!({
                "kind": format!("{:?}", section.kind), "element": format!("{:?}", section.element),
                "offset": section.offset, "bytes": section.length, "xxh3": format!("{:016x}", section.xxh3),
            })
        })
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
    let curve: Vec<Value> = measured
        .curve
        .iter()
        .map(|point| {
            json!({
                "probes": point.probes, "recall_at_10": point.recall_at_10, "eps_success": point.eps_success,
                "share_of_database": point.share_of_database,
            })
        })
        .collect();
    let provenance: Vec<Value> =
        catalogue.provenance.iter().map(|(name, value)| json!({"name": name, "value": value})).collect();
    json!({
        "file": name, "entries": index.len(), "bytes": index.byte_len(),
        "descriptor": {
            "name": catalogue.descriptor.name(), "dim": index.dim(),
            "bins": catalogue.descriptor.bins, "levels": catalogue.descriptor.levels,
            "sampling": format!("{:?}", catalogue.descriptor.sampling), "tone": format!("{:?}", catalogue.descriptor.tone),
            "network": network(&catalogue.descriptor),
        },
        "originals": catalogue.originals.name(), "keeps": catalogue.kept.names(),
        "classes": classes, "hand_shapes": catalogue.hand_shapes, "stages": catalogue.stages,
        "sigma": {"mean_distance": catalogue.sigma.mean_distance, "literal": catalogue.sigma.literal},
        "vote": vote_json(&catalogue.calibration),
        "hash": hash,
        "measured": {
            "queries": measured.queries, "held_out": measured.held_out, "noise": measured.noise,
            "eps": EPS_GRID, "curve": curve,
        },
        "thumbnail_side": catalogue.thumbnail_side, "seed": catalogue.seed,
        "provenance": provenance, "sections": sections,
    })
}
