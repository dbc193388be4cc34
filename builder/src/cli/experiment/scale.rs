//! `grasp-builder experiment scale`.

use std::collections::BTreeSet;
use std::io::Write as _;
use std::path::PathBuf;

use grasp_program::Global;
use grasp_terminal::text::{percent, shown};
use tracing::info;

use crate::cli::seed::DEFAULT_SEED;
use crate::experiment::scale::data::Data;
use crate::experiment::scale::fit::power_law;
use crate::experiment::scale::plot::{self, PAPER_EXPONENT};
use crate::experiment::scale::table::Row;
use crate::experiment::scale::{Hash, Settings, default_sizes, redraw, run};
use crate::interrupt;

/// How latency, candidates, recall, file size and build time grow with the number of entries.
///
/// Indexes of ever more hand shapes are built and searched, on one core, for queries of other hand
/// shapes, so that a neighbour within 5 % of the nearest is found for 95 % of them. DIR gets
/// scale.csv and scale.svg, renewed after every measurement; sizes that are in scale.csv are not
/// measured again.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder experiment scale --out scale
  grasp-builder experiment scale --out scale --largest 5011872       ten times as far; takes an hour
  grasp-builder queries --out q.npy
  grasp-builder experiment scale --descriptors x.npy --queries q.npy --sizes 10000,100000
  grasp-builder experiment scale --out tests/peers --redraw          its drawing, from its table

Exit status: 0 done, 2 an error, 130 stopped by Ctrl-C.")]
pub(super) struct Scale {
    /// The folder of the results; made where there is none.
    #[arg(long, value_name = "DIR", default_value = "scale")]
    out: PathBuf,
    /// Half-decade steps from 5,012 (10^3.7) up to this many entries.
    #[arg(long, value_name = "N", default_value_t = 501_188, value_parser = clap::value_parser!(u64).range(100..=100_000_000))]
    largest: u64,
    /// These numbers of entries instead; rendered ones are rounded to whole hand shapes of 5,400.
    #[arg(long, value_name = "N,...", value_delimiter = ',', conflicts_with = "largest", value_parser = clap::value_parser!(u64).range(100..=100_000_000))]
    sizes: Vec<u64>,
    /// Measure these hashes; by default all.
    #[arg(long, value_name = "NAME", value_enum, value_delimiter = ',')]
    hash: Vec<Hash>,
    /// Measure the random hash up to this many entries: it takes long for more.
    #[arg(long, value_name = "N", default_value_t = 501_188)]
    random_largest: u64,
    /// Index the first rows of this array (float32) instead of rendering.
    #[arg(long, value_name = "X.npy", requires = "queries")]
    descriptors: Option<PathBuf>,
    /// Search for the rows of this array.
    #[arg(long, value_name = "Q.npy", requires = "descriptors")]
    queries: Option<PathBuf>,
    /// What all randomness comes from.
    #[arg(long, default_value_t = DEFAULT_SEED, value_name = "N")]
    seed: u64,
    /// Measure nothing: draw scale.svg anew from the scale.csv that is there.
    #[arg(long, conflicts_with_all = ["largest", "sizes", "hash", "random_largest", "descriptors", "queries"])]
    redraw: bool,
}

impl Scale {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        let rows = if self.redraw { redraw(&self.out)? } else { self.measure(global)? };
        let mut stdout = std::io::stdout().lock();
        for hash in plot::hashes(&rows) {
            if let Some(law) = power_law(&plot::points(&rows, hash, |row| row.candidates)) {
                writeln!(
                    stdout,
                    "{hash}: candidates grow with N^{:.3}; the paper promises N^{PAPER_EXPONENT:.3}",
                    law.exponent
                )?;
            }
        }
        writeln!(stdout, "{}", shown(&self.out.join("scale.csv")))?;
        writeln!(stdout, "{}", shown(&self.out.join("scale.svg")))?;
        Ok(())
    }

    /// Measures what is not in the table yet.
    fn measure(&self, global: &Global) -> anyhow::Result<Vec<Row>> {
        let hashes = if self.hash.is_empty() { Hash::ALL.to_vec() } else { self.hash.clone() };
        let most = |hash| if hash == Hash::Random { self.random_largest } else { u64::MAX };
        let data = match (&self.descriptors, &self.queries) {
            (Some(descriptors), Some(queries)) => {
                Data::Files { descriptors: descriptors.clone(), queries: queries.clone() }
            }
            _ => Data::Rendered,
        };
        let sizes: BTreeSet<u64> = if self.sizes.is_empty() {
            default_sizes(self.largest.min(data.most()?))
        } else {
            self.sizes.iter().copied().collect()
        };
        let settings = Settings {
            data,
            sizes,
            hashes: hashes.into_iter().map(|hash| (hash, most(hash))).collect(),
            out: self.out.clone(),
            seed: self.seed,
        };
        run(&settings, global.progress(), &mut |row| info!("{}", line(row)))
    }
}

fn line(row: &Row) -> String {
    format!(
        "{:>8}  {:>9} entries: {:>9.1} us a query, {:>9.0} candidates ({}), recall@10 {:.3}, eps-success {:.3}, \
         {:.1} MB, built in {:.1} s",
        row.hash,
        row.entries,
        row.ns_per_query / 1e3,
        row.candidates,
        percent(row.share_of_database),
        row.recall_at_10,
        row.eps_success,
        row.file_bytes as f64 / 1e6,
        row.build_s,
    )
}
