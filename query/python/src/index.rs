//! `grasp.Index`.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use grasp_about::IndexInfo;
use grasp_index::{Effort, SearchError, SearchOptions, guard_against_truncation};
use grasp_recognise::ranges;
use numpy::PyArray2;
use numpy::ndarray::Array2;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::array::Rows;
use crate::error::{self, parameter};
use crate::number::{Integer, count, real};
use crate::parallel::{on_threads, share};

/// Queries after which Python may stop the search (Ctrl-C).
const AT_ONCE: usize = 1 << 14;
/// Queries whose neighbours are found before they are handed on: few enough for a core's cache.
const HANDED_ON: usize = 256;
/// The number of no entry.
const NONE: i64 = -1;
/// Fewer queries a thread are found before the thread would have started.
const LEAST: usize = 64;

/// An index of vectors, opened for search.
///
/// Opening maps the file and takes the same time for any size. An index can be shared
/// between threads, is searched on several cores at once, goes on working in a forked
/// process, and is pickled as its path: whoever unpickles it opens the file again.
///
/// Parameters
/// ----------
/// path : str or os.PathLike
///     The file, as `grasp-builder build`, `grasp.build` or another builder wrote it.
/// mmap : bool, default True
///     Map the file. With False it is read into memory, for instance from a network
///     file system; no other program can change it there.
///
/// Raises
/// ------
/// IndexFileError
///     Where there is no such file, or it is no sound index.
///
/// Notes
/// -----
/// The first index that is mapped installs a handler of SIGBUS, which comes where another
/// program cuts the file short: searches then raise IndexFileError, where the process would
/// have ended. What was handled before still is. To replace an index that is in use, write
/// the new one elsewhere and move it there (`os.replace`).
///
/// Examples
/// --------
/// >>> with grasp.Index("grasp.idx") as index:
/// ...     ids, distances = index.search(queries, k=5)
#[pyclass(frozen, module = "grasp")]
pub(crate) struct Index {
    /// As it was named, for messages.
    named: PathBuf,
    /// From the root, for another process.
    absolute: PathBuf,
    mmap: bool,
    /// `None` when it is closed. Held while the pointer is copied, by a thread that is attached to
    /// Python, as a thread that forks is: no child finds it locked.
    open: Mutex<Option<Arc<grasp_index::Index>>>,
}

impl Index {
    /// The index itself.
    pub(crate) fn get(&self) -> PyResult<Arc<grasp_index::Index>> {
        let open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        open.clone()
            .ok_or_else(|| parameter(format!("the index {} is closed: open it again", self.named.display())))
    }

    pub(crate) fn path(&self) -> &Path {
        &self.named
    }

    /// Opens what is at `path`.
    pub(crate) fn open(py: Python<'_>, path: PathBuf, mmap: bool) -> PyResult<Self> {
        if matches!(path.try_exists(), Ok(false)) {
            return Err(error::no_index(&path));
        }
        let opened = if mmap {
            // Where it cannot be installed, a search is as safe as without it.
            let _ = guard_against_truncation();
            // Attached to Python, as whoever forks is: what opening locks is free in the child.
            // It takes no time that others would notice.
            grasp_index::Index::open(&path)
        } else {
            py.detach(|| grasp_index::Index::read(&path))
        };
        let index = opened.map_err(|cause| error::open(&path, &cause))?;
        let absolute = std::path::absolute(&path).unwrap_or_else(|_| path.clone());
        Ok(Self { named: path, absolute, mmap, open: Mutex::new(Some(Arc::new(index))) })
    }
}

#[pymethods]
impl Index {
    #[new]
    #[pyo3(signature = (path, *, mmap=true))]
    fn new(py: Python<'_>, path: PathBuf, mmap: bool) -> PyResult<Self> {
        Self::open(py, path, mmap)
    }

    /// Find the nearest entries of each query.
    ///
    /// Parameters
    /// ----------
    /// queries : array_like of float32, shape (n, dim) or (dim,)
    ///     The vectors to search for. A C-contiguous float32 array is read where it
    ///     lies; other real numbers are copied. Nobody may write to it meanwhile.
    /// k : int, default 10
    ///     How many neighbours to find, 1 to 100,000.
    /// recall : float, default 0.95
    ///     Find this share of the true 10 nearest, on average, as measured when the
    ///     index was built; above 0, at most 1.
    /// exact : bool, default False
    ///     Compare with every entry instead: the true nearest, and `recall` is of no
    ///     account.
    /// threads : int, optional
    ///     How many threads search, 1 to 1024; by default one a core. Answers do not depend on it.
    ///
    /// Returns
    /// -------
    /// ids : numpy.ndarray of int64, shape (n, k)
    ///     The numbers of the entries, from 0 in the order in which they were added,
    ///     nearest first; -1 where the index has fewer entries than k. n is 1 for a
    ///     single query.
    /// distances : numpy.ndarray of float32, shape (n, k)
    ///     Euclidean distances, not squared; inf beside -1.
    ///
    /// Raises
    /// ------
    /// ParameterError
    ///     Where queries do not fit the index or are not finite, or a parameter is out
    ///     of its range.
    /// IndexFileError
    ///     Where the file was changed while it was in use.
    #[pyo3(signature = (queries, k=10, recall=0.95, exact=false, *, threads=None))]
    #[allow(clippy::type_complexity, reason = "a pair of arrays")]
    fn search<'py>(
        &self,
        py: Python<'py>,
        queries: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = neighbours)] k: usize,
        #[pyo3(from_py_with = real)] recall: f64,
        exact: bool,
        threads: Option<Integer>,
    ) -> PyResult<(Bound<'py, PyArray2<i64>>, Bound<'py, PyArray2<f32>>)> {
        let index = self.get()?;
        let threads = crate::parallel::threads(threads)?;
        let effort = if exact { Effort::Exact } else { Effort::Recall(recall) };
        let options = SearchOptions { k, effort };
        let rows = Rows::new(queries, "queries", true)?;
        if rows.dim != index.dim() {
            let wrong = SearchError::WrongLength { expected: index.dim(), found: rows.dim };
            return Err(error::search(&wrong));
        }
        let values = rows.values()?;
        let wanted = rows.count.saturating_mul(options.k);
        let (mut ids, mut distances) = (Vec::new(), Vec::new());
        if ids.try_reserve_exact(wanted).is_err() || distances.try_reserve_exact(wanted).is_err() {
            return Err(parameter(format!(
                "{wanted} neighbours do not fit into memory: search fewer queries at a time, or lower k"
            )));
        }
        // Where there is none, what is wrong with the options is reported all the same.
        if rows.count == 0 {
            let checked = index.searcher().batch(&[], &options, &mut Vec::new());
            checked.map_err(|cause| error::search(&cause))?;
        }
        ids.resize(wanted, NONE);
        distances.resize(wanted, f32::INFINITY);
        let at_once = AT_ONCE * options.k;
        let answers = ids.chunks_mut(at_once).zip(distances.chunks_mut(at_once));
        for ((number, part), answers) in values.chunks(AT_ONCE * rows.dim.max(1)).enumerate().zip(answers) {
            let searched = py.detach(|| search_all(&index, part, &options, threads, answers));
            searched.map_err(|cause| {
                error::queries(&behind(cause, number * AT_ONCE * rows.dim), |at| rows.place(at))
            })?;
            py.check_signals()?;
        }
        index.check_unchanged().map_err(|cause| error::changed(&self.named, cause))?;
        let shape = (rows.count, options.k);
        let unfit = |_| error::internal("the index answered another number of queries");
        let ids = Array2::from_shape_vec(shape, ids).map_err(unfit)?;
        let distances = Array2::from_shape_vec(shape, distances).map_err(unfit)?;
        Ok((PyArray2::from_owned_array(py, ids), PyArray2::from_owned_array(py, distances)))
    }

    /// What the index keeps of an entry besides its vector.
    ///
    /// Parameters
    /// ----------
    /// id : int
    ///     Its number, as `search` returns it.
    ///
    /// Returns
    /// -------
    /// dict
    ///     `id`, `grasp` (its label; None without labels), `file`, `hand_shape`, `stage`
    ///     and `object` (empty where they are not kept), and `quaternion_xyzw` (None
    ///     where it is not kept).
    ///
    /// Raises
    /// ------
    /// ParameterError
    ///     Where there is no such entry.
    fn entry<'py>(&self, py: Python<'py>, id: Integer) -> PyResult<Bound<'py, PyDict>> {
        let index = self.get()?;
        let number: u32 = id.get().ok_or_else(|| {
            parameter(format!("there is no entry {id}: the index holds {}, counted from 0", index.len()))
        })?;
        let entry = index.entry(number).map_err(|cause| parameter(cause.to_string()))?;
        let class = entry.class.and_then(|class| index.catalogue().classes.get(usize::from(class)));
        let record = PyDict::new(py);
        record.set_item("id", number)?;
        record.set_item("grasp", class.map(|class| class.name.as_str()))?;
        record.set_item("file", entry.file)?;
        record.set_item("hand_shape", entry.hand_shape)?;
        record.set_item("stage", entry.stage)?;
        record.set_item("object", entry.object)?;
        let quaternion = entry.orientation.map(|rotation| grasp_recognise::orientation::xyzw(&rotation));
        record.set_item("quaternion_xyzw", quaternion.map(|xyzw| xyzw.to_vec()))?;
        index.check_unchanged().map_err(|cause| error::changed(&self.named, cause))?;
        Ok(record)
    }

    /// What is known about the index.
    ///
    /// Returns
    /// -------
    /// dict
    ///     Under the keys of `grasp-builder inspect --json`: among others `file`,
    ///     `entries`, `bytes`, `descriptor` (`name`, `dim`), `classes`, `hash`, `seed`,
    ///     `provenance`, `measured`, whose `curve` says what recall each effort has, and
    ///     `recognises`, whether it can tell what a picture shows.
    fn info<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let index = self.get()?;
        let named = self.named.display().to_string();
        let text = py.detach(|| serde_json::to_string(&IndexInfo::new(named, &index)));
        let text = text.map_err(|cause| error::failure(&cause))?;
        index.check_unchanged().map_err(|cause| error::changed(&self.named, cause))?;
        py.import("json")?.call_method1("loads", (text,))
    }

    /// Values of a vector.
    #[getter]
    fn dim(&self) -> PyResult<usize> {
        Ok(self.get()?.dim())
    }

    /// The file, from the root.
    #[getter]
    #[pyo3(name = "path")]
    fn absolute(&self) -> PyResult<String> {
        Ok(self.absolute.display().to_string())
    }

    /// Whether the index was closed.
    #[getter]
    fn closed(&self) -> bool {
        self.get().is_err()
    }

    /// Let go of the file.
    ///
    /// What is asked of the index afterwards raises ParameterError. The memory is free when
    /// searches under way have ended and no Answer that came of the index is left.
    fn close(&self) {
        let closed = self.open.lock().unwrap_or_else(PoisonError::into_inner).take();
        drop(closed);
    }

    fn __len__(&self) -> PyResult<usize> {
        Ok(self.get()?.len())
    }

    fn __enter__(slf: PyRef<'_, Self>) -> PyResult<PyRef<'_, Self>> {
        slf.get()?;
        Ok(slf)
    }

    #[pyo3(signature = (*_exception))]
    fn __exit__(&self, _exception: &Bound<'_, PyTuple>) {
        self.close();
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((PathBuf,), Bound<'py, PyDict>)> {
        self.get()?;
        let options = PyDict::new(py);
        options.set_item("mmap", self.mmap)?;
        Ok(((self.absolute.clone(),), options))
    }

    fn __repr__(&self) -> String {
        let name = self.named.display().to_string();
        match self.get() {
            Ok(index) => format!("<grasp.Index {name:?}: {} entries of {} values>", index.len(), index.dim()),
            Err(_) => format!("<grasp.Index {name:?}, closed>"),
        }
    }
}

/// How many neighbours are wanted.
pub(crate) fn neighbours(k: &Bound<'_, PyAny>) -> PyResult<usize> {
    count("k", k, &ranges::NEIGHBOURS)
}

/// Finds the neighbours of all queries: their numbers and their distances, a row of `k` a query.
fn search_all(
    index: &grasp_index::Index,
    queries: &[f32],
    options: &SearchOptions,
    threads: usize,
    (ids, distances): (&mut [i64], &mut [f32]),
) -> Result<(), SearchError> {
    let dim = index.dim().max(1);
    // Comparing with all entries takes long enough for any number of queries.
    let least = if options.effort == Effort::Exact { 1 } else { LEAST };
    let each = share(queries.len() / dim, threads, least);
    let answers = ids.chunks_mut(each * options.k).zip(distances.chunks_mut(each * options.k));
    let parts = queries.chunks(each * dim).zip(answers.map(Mutex::new)).enumerate();
    let parts: Vec<_> = parts.collect();
    let searched = on_threads(&parts, |(number, (queries, answers))| {
        let mut answers = answers.lock().unwrap_or_else(PoisonError::into_inner);
        let (ids, distances) = &mut *answers;
        search_part(index, queries, options, ids, distances)
            .map_err(|cause| behind(cause, number * each * dim))
    });
    searched.into_iter().collect()
}

/// The same on this thread.
fn search_part(
    index: &grasp_index::Index,
    queries: &[f32],
    options: &SearchOptions,
    ids: &mut [i64],
    distances: &mut [f32],
) -> Result<(), SearchError> {
    let (dim, k) = (index.dim().max(1), options.k);
    // Comparing with all entries goes through them once for all queries.
    let at_once = if options.effort == Effort::Exact { queries.len() / dim } else { HANDED_ON };
    let (mut searcher, mut found) = (index.searcher(), Vec::new());
    let answers = ids.chunks_mut(at_once * k).zip(distances.chunks_mut(at_once * k));
    for ((number, queries), (ids, distances)) in queries.chunks(at_once * dim).enumerate().zip(answers) {
        found.clear();
        let searched = searcher.batch(queries, options, &mut found);
        searched.map_err(|cause| behind(cause, number * at_once * dim))?;
        for ((id, distance), neighbour) in ids.iter_mut().zip(distances).zip(&found) {
            *id = if neighbour.id == u32::MAX { NONE } else { i64::from(neighbour.id) };
            *distance = neighbour.distance;
        }
    }
    Ok(())
}

/// The same error, counted over the values before as well.
fn behind(error: SearchError, before: usize) -> SearchError {
    match error {
        SearchError::NotFinite { at } => SearchError::NotFinite { at: before + at },
        SearchError::Huge { at } => SearchError::Huge { at: before + at },
        other => other,
    }
}
