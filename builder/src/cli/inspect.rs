//! `grasp-builder inspect`.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::Context as _;
use grasp_about::{IndexInfo, class_counts};
use grasp_index::{Calibration, Catalogue, DescriptorKind, EPS, HashInfo, Index, Measured, Sampling, Tone};
use grasp_terminal::text::{counted, percent, printable};

use super::report::ENTRIES;

/// Show what is in an index: its entries, parameters, origin, and how well its search does.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder inspect grasp.idx
  grasp-builder inspect grasp.idx --json | jq .entries

Exit status: 0 where it can be used, 2 where it cannot.")]
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
            // As a value, whose keys are in order.
            true => format!("{}\n", serde_json::to_value(IndexInfo::new(name.to_string(), &index))?),
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
    for (class, count) in catalogue.classes.iter().zip(class_counts(index)) {
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
        line(key, shortened(value));
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

/// What is longer than anybody reads, such as grasps of one's own, cut.
fn shortened(text: &str) -> String {
    const MOST: usize = 300;
    let length = text.chars().count();
    if length <= MOST {
        return text.to_owned();
    }
    let beginning: String = text.chars().take(MOST).collect();
    format!("{beginning}... ({length} characters: --json prints all)")
}

/// A network's fingerprint, as `train` prints it.
fn fingerprint(network: u64) -> String {
    format!("{network:016x}")
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
            "learned, K = {}, {}, {}, codes of {} bits",
            counted(hash.planes, PLANES),
            counted(hash.axes, ["principal axis", "principal axes"]),
            counted(hash.groups, ["group of centres", "groups of centres"]),
            hash.code_bits.count()
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

/// The names of a list, if any.
fn some_of(names: &[&str]) -> String {
    if names.is_empty() { "nothing else".to_owned() } else { names.join(", ") }
}

fn measured_text(measured: &Measured) -> String {
    let queries = counted(measured.queries, QUERIES);
    let [least, most] = measured.noise;
    match (measured.held_out, most > 0.0) {
        (true, true) => format!("{queries} of held-out hands, moved by {least} to {most} sigma"),
        (true, false) => format!("{queries} that were held out, as they are"),
        (false, _) => {
            format!("{queries} of entries, each held out for its own query, moved by {least} to {most} sigma")
        }
    }
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
