//! `grasp-query search`.

#[cfg(feature = "serve")]
mod remote;

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context as _, bail};
use grasp_index::npy::{NpyError, NpyHeader, NpyType};
use grasp_index::{AtomicFile, Neighbour, SearchOptions};
use grasp_terminal::text::{counted, percent, printable};
use serde::Serialize;
use tracing::info;

use super::effort::EffortArguments;
use super::index_file::IndexFiles;
use super::outputs::check_file;
use crate::search::{Batch, MeanCost, mean_cost, median_ns, ns_per_query};
use grasp_answer::found::{QueryRecord, names_in, present};
use grasp_program::Global;
use grasp_program::status::SUCCESS;
#[cfg(feature = "serve")]
use grasp_serve::client::Address;

const EXAMPLES: &str = "\
Examples:
  grasp-builder queries --out q.npy                      descriptors of other hands, to search for
  grasp-query search q.npy                               the neighbours of the first queries
  grasp-query search q.npy --out ids.npy --distances distances.npy
  grasp-query search q.npy --eps 0.05 --success 0.99 --out ids.npy
  grasp-query search q.npy --rounds 7 --threads 1 --json
  grasp-query search q.npy --index grasp.idx --index new.idx --out ids.npy
  grasp-query search q.npy --neighbours | jq .neighbours[0].id
  grasp-query search q.npy --server http://127.0.0.1:8750 --out ids.npy

QUERIES.npy holds float32, one row of the index's dimension a query.

Exit status: 0, or 2 where something failed.";

/// Queries that a person is shown.
const SHOWN: usize = 3;

/// Search for raw descriptors: rows in, the numbers of the nearest entries out.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Search {
    /// The queries, an array of float32; `-` reads it from standard input.
    #[arg(value_name = "QUERIES.npy")]
    queries: PathBuf,
    #[command(flatten)]
    index: IndexFiles,
    /// How many neighbours to find for each query.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = super::options::parse_k)]
    k: usize,
    /// Write the neighbours' numbers, uint32, a row of k for each query, nearest first; 4294967295
    /// where the index has fewer entries. `-` writes to standard output.
    #[arg(long, value_name = "IDS.npy")]
    out: Option<PathBuf>,
    /// Write their distances, float32, in the same order. `-` writes to standard output.
    #[arg(long, value_name = "DISTANCES.npy")]
    distances: Option<PathBuf>,
    /// Search N times and report the median time; where N > 1, once more before that, to warm up.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    rounds: u32,
    /// Say on standard error how long it took and what it cost.
    #[arg(long)]
    timings: bool,
    /// Print one JSON record about the whole search: its time and cost.
    #[arg(long)]
    json: bool,
    /// Print each query's neighbours as a line of JSON.
    #[arg(long, conflicts_with = "json")]
    neighbours: bool,
    #[cfg(feature = "serve")]
    /// Let a running `grasp-query serve` answer, by its own index; http://HOST:PORT or unix:PATH.
    #[arg(long, value_name = "ADDRESS", conflicts_with_all = ["json", "timings", "rounds", "allow_missing"])]
    server: Option<Address>,
    #[cfg(feature = "serve")]
    /// Show the service the token in this file.
    #[arg(long, value_name = "FILE", requires = "server")]
    token_file: Option<PathBuf>,
    #[command(flatten)]
    effort: EffortArguments,
}

/// What `--json` prints. Its keys are an interface: they may be added to, never renamed.
#[derive(Debug, Serialize)]
struct Summary {
    file: String,
    queries: usize,
    k: usize,
    dim: usize,
    entries: usize,
    segments: SegmentsRecord,
    /// The median of `rounds`.
    ns_per_query: f64,
    /// Nanoseconds a query, round by round: the wall time of all queries, divided by their number.
    rounds: Vec<f64>,
    /// How long it took to open the index.
    open_ns: u64,
    threads: usize,
    #[serde(flatten)]
    cost: MeanCost,
}

/// How many of the indexes that were named could be opened.
#[derive(Debug, Serialize)]
struct SegmentsRecord {
    searched: usize,
    of: usize,
}

impl Search {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<u8> {
        self.refuse_clashes()?;
        #[cfg(feature = "serve")]
        if let Some(address) = &self.server {
            return self.run_remote(address);
        }
        let started = Instant::now();
        let (segments, of) = self.index.open()?;
        let open = started.elapsed();
        let name = self.queries.display();
        let (queries, _) = self.read_queries(Some(segments.dim()))?;
        let count = queries.len() / segments.dim().max(1);

        let options = self.options();
        let mut batch = Batch::new(&segments, &queries, options, threads(global))?;
        if self.rounds > 1 {
            batch.run()?;
        }
        let rounds = (0..self.rounds).map(|_| batch.run()).collect::<Result<Vec<Duration>, _>>()?;

        let names = |id| names_in(&segments, id);
        let check = || segments.check_unchanged().context("cannot use the index");
        check()?;
        self.write(count, || batch.found())?;
        if self.neighbours {
            return print_neighbours(names, batch.found(), check);
        }
        if self.json || self.timings {
            let summary = Summary {
                file: name.to_string(),
                queries: count,
                k: self.k,
                dim: segments.dim(),
                entries: segments.len(),
                segments: SegmentsRecord { searched: segments.indexes().len(), of },
                ns_per_query: median_ns(&rounds, count),
                rounds: rounds.iter().map(|&round| ns_per_query(round, count)).collect(),
                open_ns: u64::try_from(open.as_nanos()).unwrap_or(u64::MAX),
                threads: batch.threads(),
                cost: mean_cost(&segments, &queries, &options)?,
            };
            check()?;
            self.report(&summary)?;
        }
        if self.out.is_none() && self.distances.is_none() && !self.json {
            show(names, batch.found(), count, check)?;
        }
        Ok(SUCCESS)
    }

    fn options(&self) -> SearchOptions {
        SearchOptions { k: self.k, effort: self.effort.effort() }
    }

    /// As a run by an own index, but for who answers.
    #[cfg(feature = "serve")]
    fn run_remote(&self, address: &Address) -> anyhow::Result<u8> {
        self.index.refuse_beside_a_service()?;
        let (queries, dim) = self.read_queries(None)?;
        let count = queries.len() / dim.max(1);
        let found = self.ask(address, &queries, dim)?;
        let names = |id| found.names(id);
        let rows = || found.neighbours.chunks_exact(self.k);
        self.write(count, rows)?;
        if self.neighbours {
            return print_neighbours(names, rows(), || Ok(()));
        }
        if self.out.is_none() && self.distances.is_none() {
            show(names, rows(), count, || Ok(()))?;
        }
        Ok(SUCCESS)
    }

    /// The queries, at least one, and how many values each has: `dim`, if that is known.
    fn read_queries(&self, dim: Option<usize>) -> anyhow::Result<(Vec<f32>, usize)> {
        let name = self.queries.display();
        let read = if is_standard(&self.queries) {
            read_array(io::stdin().lock(), dim)
        } else {
            File::open(&self.queries)
                .map_err(NpyError::from)
                .and_then(|file| read_array(BufReader::new(file), dim))
        };
        let (queries, dim) = read.with_context(|| format!("cannot use the queries {name}"))?;
        if queries.is_empty() {
            bail!("{name} holds no query");
        }
        Ok((queries, dim))
    }

    /// Writes the arrays that are wanted: begun only now, so that a search that is ended by Ctrl-C
    /// leaves none half written.
    fn write<'f, F: Iterator<Item = &'f [Neighbour]>>(
        &self,
        count: usize,
        found: impl Fn() -> F,
    ) -> anyhow::Result<()> {
        if let Some(out) = &self.out {
            Target::create(out)?
                .write(NpyType::U32, count, self.k, found(), |neighbour| neighbour.id.to_le_bytes())?;
        }
        if let Some(distances) = &self.distances {
            let bytes = |neighbour: &Neighbour| neighbour.distance.to_le_bytes();
            Target::create(distances)?.write(NpyType::F32, count, self.k, found(), bytes)?;
        }
        Ok(())
    }

    /// Refuses outputs that would destroy an input or each other, or cannot be written.
    fn refuse_clashes(&self) -> anyhow::Result<()> {
        let indexes = self.index.paths();
        let mut printed = usize::from(self.json || self.neighbours);
        for out in self.out.iter().chain(&self.distances) {
            if is_standard(out) {
                printed += 1;
            } else {
                let inputs = indexes.iter().map(PathBuf::as_path).chain([self.queries.as_path()]);
                check_file(out, inputs)?;
            }
        }
        if printed > 1 {
            bail!("only one of --out -, --distances -, --json and --neighbours can have standard output");
        }
        let files = (&self.out, &self.distances);
        if matches!(files, (Some(out), Some(distances)) if out == distances && !is_standard(out)) {
            bail!("--out and --distances name the same file: name two");
        }
        Ok(())
    }

    fn report(&self, summary: &Summary) -> anyhow::Result<()> {
        if self.timings {
            let Summary { queries, k, threads, ns_per_query, cost, .. } = summary;
            let touched = if cost.exact {
                "every entry compared".into()
            } else {
                let share = percent(cost.share_of_database);
                format!("{:.0} candidates a query, {share} of the index", cost.candidates)
            };
            let recall = cost.predicted_recall.map(|recall| format!(", recall@10 predicted {recall:.3}"));
            info!(
                ns_per_query,
                "{}, {} each: {:.2} us a query (rounds: {}, threads: {threads}), index opened in {:.2} ms; {touched}{}",
                counted(*queries, ["query", "queries"]),
                counted(*k, ["neighbour", "neighbours"]),
                ns_per_query / 1e3,
                summary.rounds.len(),
                summary.open_ns as f64 / 1e6,
                recall.unwrap_or_default(),
            );
        }
        if self.json {
            let mut out = io::stdout().lock();
            serde_json::to_writer(&mut out, summary).map_err(io::Error::from)?;
            out.write_all(b"\n")?;
        }
        Ok(())
    }
}

/// As many as wanted, or as there are cores.
fn threads(global: &Global) -> usize {
    match usize::from(global.threads) {
        0 => std::thread::available_parallelism().map_or(1, Into::into),
        threads => threads,
    }
}

fn is_standard(path: &Path) -> bool {
    path == Path::new("-")
}

/// The values, and how many there are in a row.
fn read_array(mut reader: impl Read, dim: Option<usize>) -> Result<(Vec<f32>, usize), NpyError> {
    let header = NpyHeader::read(&mut reader, NpyType::F32)?;
    let columns = header.columns as usize;
    if let Some(expected) = dim.filter(|&dim| dim != columns) {
        return Err(NpyError::Columns { found: header.columns, expected });
    }
    Ok((header.read_values(&mut reader)?, columns))
}

/// Where an array goes.
enum Target {
    Standard,
    File(AtomicFile),
}

impl Target {
    fn create(path: &Path) -> anyhow::Result<Self> {
        Ok(if is_standard(path) { Self::Standard } else { Self::File(AtomicFile::create(path)?) })
    }

    fn write<'f>(
        self,
        element: NpyType,
        rows: usize,
        columns: usize,
        found: impl Iterator<Item = &'f [Neighbour]>,
        bytes: impl Fn(&Neighbour) -> [u8; 4],
    ) -> anyhow::Result<()> {
        let header = NpyHeader { element, rows: rows as u64, columns: columns as u64, offset: 0 };
        let write = |out: &mut dyn Write| -> io::Result<()> {
            let mut out = BufWriter::with_capacity(1 << 16, out);
            out.write_all(&header.to_bytes())?;
            for neighbour in found.flatten() {
                out.write_all(&bytes(neighbour))?;
            }
            out.flush()
        };
        match self {
            Self::Standard => Ok(write(&mut io::stdout().lock())?),
            Self::File(mut file) => {
                let name = file.path().display().to_string();
                write(&mut file).with_context(|| format!("cannot write {name}"))?;
                Ok(file.commit()?)
            }
        }
    }
}

/// Every query's neighbours as a line of JSON. The names are the index's: `check` says whether they
/// may be believed.
fn print_neighbours<'f, 'n>(
    names: impl Fn(u32) -> (Option<&'n str>, Option<String>),
    found: impl Iterator<Item = &'f [Neighbour]>,
    check: impl Fn() -> anyhow::Result<()>,
) -> anyhow::Result<u8> {
    let mut out = BufWriter::new(io::stdout().lock());
    for (query, neighbours) in found.enumerate() {
        let record = QueryRecord::named(&names, query, neighbours);
        let line = serde_json::to_vec(&record).map_err(io::Error::from)?;
        check()?;
        out.write_all(&line)?;
        out.write_all(b"\n")?;
    }
    out.flush()?;
    Ok(SUCCESS)
}

/// The neighbours of the first queries, for a person.
fn show<'f, 'n>(
    names: impl Fn(u32) -> (Option<&'n str>, Option<String>),
    found: impl Iterator<Item = &'f [Neighbour]>,
    count: usize,
    check: impl Fn() -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let mut out = Vec::new();
    for (query, neighbours) in found.take(SHOWN).enumerate() {
        writeln!(out, "query {query}")?;
        for neighbour in present(neighbours) {
            let (grasp, file) = names(neighbour.id);
            let names = grasp.into_iter().chain(file.as_deref());
            let names = names.map(|name| format!("  {}", printable(name)));
            writeln!(out, "{:>10}  {:.4}{}", neighbour.id, neighbour.distance, names.collect::<String>())?;
        }
    }
    check()?;
    io::stdout().lock().write_all(&out)?;
    if count > SHOWN {
        let more = count - SHOWN;
        let queries = counted(more, ["more query", "more queries"]);
        info!("and {queries}: --out IDS.npy writes all, --neighbours prints all");
    }
    Ok(())
}
