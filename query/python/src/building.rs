//! `grasp.build`.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use grasp_index::{
    BuildError, ClassInfo, DescriptorParams, HashParams, IndexParams, IndexWriter, KeptFields, NewEntry,
    OpenError, Originals, Phase, RandomParams,
};
use pyo3::prelude::*;
use pyo3::types::PyString;
use rayon::ThreadPoolBuilder;

use crate::array::Rows;
use crate::error::{self, parameter};
use crate::index::Index;
use crate::number::Integer;
use crate::progress::{Progress, watched};

/// Entries after which Python is asked whether to go on.
const AT_ONCE: usize = 1 << 14;

/// Build an index of vectors, and open it.
///
/// The file is written beside `path` and takes its place in one step when it is whole.
/// The same vectors, labels and parameters give the same bytes on any number of threads.
///
/// Parameters
/// ----------
/// vectors : array_like of float32, shape (n, dim)
///     A row an entry, n at least 1, finite. A C-contiguous float32 array is read where it
///     lies; other real numbers are copied. Nobody may write to it meanwhile.
/// path : str or os.PathLike
///     The index to write. An index there is replaced; any other file is left alone.
/// labels : sequence of str, length n, optional
///     The class of each entry, which `Index.entry` returns.
/// cutkosky : dict of str to int, optional
///     The numbers of classes in Cutkosky's taxonomy, 0 to 255; 0 where one is not named. What
///     is named must be a label.
/// held_out : array_like of float32, shape (m, dim), optional
///     Vectors that are like what will be searched for, and not among `vectors`: how much
///     effort a recall takes is measured with them, as they are. Without them it is measured with
///     entries, each held out for its own query.
/// hash : {"learned", "random"}, default "learned"
///     Hyperplanes that are fitted to the vectors, or random ones as in the paper.
/// originals : {"f32", "f16", "none"}, default "f32"
///     In which form vectors are kept for exact distances.
/// seed : int, default 0
///     What all randomness comes from, 0 to 2**64 - 1.
/// threads : int, optional
///     How many threads work, 1 to 1024; by default one a core.
/// progress : callable, optional
///     Is called as ``progress(phase, share)``: what is done ("entries", "sigma", "hash",
///     "tables", "measure", "calibrate", "write") and how much of that, 0 to 1. An
///     exception that it raises stops the build, as Ctrl-C does.
///
/// Returns
/// -------
/// Index
///     The index, opened.
///
/// Raises
/// ------
/// ParameterError
///     Where vectors, labels or parameters cannot be.
/// IndexFileError
///     Where the file at `path` is no index.
/// GraspError
///     Where the index cannot be written.
///
/// Notes
/// -----
/// Such an index is searched, and recognises no pictures: how a vector is made of a
/// picture is not known. `grasp-builder build` makes indexes of pictures.
#[pyfunction]
#[pyo3(signature = (
    vectors, path, labels=None, progress=None, seed=0, *,
    cutkosky=None, held_out=None, hash="learned", originals="f32", threads=None
))]
#[allow(clippy::too_many_arguments, reason = "Python names them")]
pub(crate) fn build(
    py: Python<'_>,
    vectors: &Bound<'_, PyAny>,
    path: PathBuf,
    labels: Option<&Bound<'_, PyAny>>,
    progress: Option<Py<PyAny>>,
    #[pyo3(from_py_with = self::seed)] seed: u64,
    cutkosky: Option<BTreeMap<String, Integer>>,
    held_out: Option<&Bound<'_, PyAny>>,
    hash: &str,
    originals: &str,
    threads: Option<Integer>,
) -> PyResult<Index> {
    let threads = crate::parallel::threads(threads)?;
    let rows = Rows::new(vectors, "vectors", false)?;
    let values = rows.values()?;
    let cutkosky = cutkosky_numbers(cutkosky.unwrap_or_default())?;
    if labels.is_none() && !cutkosky.is_empty() {
        return Err(parameter("cutkosky says which number a label has: give labels as well"));
    }
    let labels = labels.map(|labels| Labels::new(labels, rows.count, &cutkosky)).transpose()?;
    let held_out = held_out.map(|held_out| Rows::new(held_out, "held_out", false)).transpose()?;
    if let Some(held_out) = held_out.as_ref().filter(|held_out| held_out.dim != rows.dim) {
        return Err(parameter(format!(
            "held_out has rows of {} values, vectors of {}: they must agree",
            held_out.dim, rows.dim
        )));
    }
    if !(1..=1 << 16).contains(&rows.dim) {
        return Err(parameter(format!("vectors have {} values each: 1 to 65,536 are supported", rows.dim)));
    }
    let params = IndexParams {
        descriptor: DescriptorParams::raw(u32::try_from(rows.dim).unwrap_or(u32::MAX)),
        originals: Originals::by_name(originals).ok_or_else(|| {
            parameter(format!("originals is {originals:?}: \"f32\", \"f16\" or \"none\" is needed"))
        })?,
        kept: KeptFields { labels: labels.is_some(), ..KeptFields::nothing() },
        classes: labels.as_ref().map(|labels| labels.classes.clone()).unwrap_or_default(),
        hand_shapes: vec![String::new()],
        stages: vec![String::new()],
        hash: match hash {
            "learned" => HashParams::Learned,
            "random" => HashParams::Random(RandomParams::Auto),
            _ => return Err(parameter(format!("hash is {hash:?}: \"learned\" or \"random\" is needed"))),
        },
        held_out: held_out.as_ref().map(Rows::values).transpose()?.unwrap_or_default().to_vec(),
        seed,
        ..IndexParams::default()
    };
    refuse_other_files(&path)?;

    let numbers = labels.map(|labels| labels.numbers).unwrap_or_default();
    let (numbers, out, dim) = (numbers.as_slice(), path.as_path(), rows.dim);
    // Of this call alone: a process may fork afterwards.
    let pool =
        ThreadPoolBuilder::new().num_threads(threads).build().map_err(|cause| error::failure(&cause))?;
    let built = watched(py, progress.as_ref(), |progress| {
        pool.install(move || {
            let mut writer = IndexWriter::create(out, params)?;
            add(&mut writer, values, dim, numbers, &progress)?;
            writer.finish(&|phase, share| progress.report(name(phase), share))
        })
    })?;
    built.map_err(|cause| match cause {
        BuildError::Write(_) => error::failure(&cause),
        other => parameter(other.to_string()),
    })?;
    Index::open(py, path, true)
}

/// What all randomness comes from.
fn seed(seed: &Bound<'_, PyAny>) -> PyResult<u64> {
    let seed: Integer = seed.extract()?;
    seed.get()
        .ok_or_else(|| parameter(format!("seed is {seed}: an integer from 0 to {} is needed", u64::MAX)))
}

/// The numbers of classes in the taxonomy.
fn cutkosky_numbers(given: BTreeMap<String, Integer>) -> PyResult<BTreeMap<String, u8>> {
    let number = |(name, number): (String, Integer)| match number.get() {
        Some(number) => Ok((name, number)),
        None => Err(parameter(format!(
            "cutkosky[{name:?}] is {number}: an integer from 0 to {} is needed",
            u8::MAX
        ))),
    };
    given.into_iter().map(number).collect()
}

/// Adds a row an entry.
fn add(
    writer: &mut IndexWriter,
    values: &[f32],
    dim: usize,
    classes: &[u16],
    progress: &Progress,
) -> Result<(), BuildError> {
    let count = (values.len() / dim).max(1);
    for (id, row) in values.chunks_exact(dim).enumerate() {
        if id % AT_ONCE == 0 && progress.report("entries", id as f64 / count as f64).is_break() {
            return Err(BuildError::Stopped);
        }
        writer.push(NewEntry {
            class: classes.get(id).copied().unwrap_or_default(),
            file: format!("row {id}"),
            descriptor: row.to_vec(),
            ..NewEntry::default()
        })?;
    }
    Ok(())
}

/// A file that is no index is somebody's work.
fn refuse_other_files(path: &Path) -> PyResult<()> {
    match grasp_index::Index::open(path) {
        Err(OpenError::Io(cause)) if cause.kind() == std::io::ErrorKind::NotFound => Ok(()),
        Err(cause @ (OpenError::NotAnIndex | OpenError::NotAFile | OpenError::Folder | OpenError::Io(_))) => {
            let path = path.display();
            Err(error::index_file(format!("{path} exists, and is no index ({cause}): choose another path")))
        }
        // A damaged index is replaced, as any other is.
        Ok(_) | Err(_) => Ok(()),
    }
}

/// What is done in a phase, in a word.
fn name(phase: Phase) -> &'static str {
    match phase {
        Phase::Sigma => "sigma",
        Phase::Tune => "hash",
        Phase::Tables => "tables",
        Phase::Measure => "measure",
        Phase::Calibrate => "calibrate",
        Phase::Write => "write",
    }
}

/// The classes of entries.
struct Labels {
    /// By number in the taxonomy, and then by name.
    classes: Vec<ClassInfo>,
    /// The position of each entry's class among them.
    numbers: Vec<u16>,
}

impl Labels {
    fn new(labels: &Bound<'_, PyAny>, count: usize, cutkosky: &BTreeMap<String, u8>) -> PyResult<Self> {
        // Its letters would be labels.
        if labels.is_instance_of::<PyString>() {
            return Err(parameter(format!("labels is a single text: a sequence of {count} names is needed")));
        }
        let mut names: Vec<String> = Vec::with_capacity(count);
        for label in labels.try_iter()? {
            let label = label?;
            names.push(label.extract().map_err(|_| {
                parameter(format!("labels[{}] is {label:?}: a name (str) is needed", names.len()))
            })?);
        }
        if names.len() != count {
            return Err(parameter(format!(
                "there are {} labels and {count} vectors: one label a vector is needed",
                names.len()
            )));
        }
        let known: BTreeSet<&str> = names.iter().map(String::as_str).collect();
        if let Some(name) = cutkosky.keys().find(|name| !known.contains(name.as_str())) {
            return Err(parameter(format!(
                "cutkosky names {name:?}, which is none of the labels: leave it out, or write it as there"
            )));
        }
        let number = |name: &str| cutkosky.get(name).copied().unwrap_or(0);
        let distinct: BTreeSet<(u8, &str)> = names.iter().map(|name| (number(name), name.as_str())).collect();
        if distinct.len() > 1 << 16 {
            return Err(parameter(format!(
                "labels name {} classes: at most 65,536 are supported",
                distinct.len()
            )));
        }
        let place: HashMap<&str, u16> = distinct.iter().map(|(_, name)| *name).zip(0..=u16::MAX).collect();
        let numbers = names.iter().filter_map(|name| place.get(name.as_str()).copied()).collect();
        let class =
            |(cutkosky, name): &(u8, &str)| ClassInfo { name: (*name).to_owned(), cutkosky: *cutkosky };
        Ok(Self { classes: distinct.iter().map(class).collect(), numbers })
    }
}
