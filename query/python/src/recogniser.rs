//! `grasp.Recogniser`.

use std::ops::RangeBounds as _;
use std::path::PathBuf;
use std::sync::Arc;

use grasp_answer::record::{Record, SingleRecord};
use grasp_index::{Effort, VoteOptions};
use grasp_recognise::picture;
use grasp_recognise::segment::{Finder, SegmentParams};
use grasp_recognise::{
    Accept, DEFAULT_ROLLS, HandChoice, MaskSource, Prepared, RecogniseError, RecogniseOptions, Recognition,
    Timings, ranges,
};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyList, PyType};

use crate::error::{self, parameter};
use crate::found::Found;
use crate::index::{Index, neighbours};
use crate::mask;
use crate::number::{Integer, count, real};
use crate::parallel::each;
use crate::picture::Input;

/// Pictures a thread after which Python may stop a batch (Ctrl-C).
const AT_ONCE: usize = 4;

/// Recognises which grasp the hand in a picture makes, and how it is turned.
///
/// A recogniser can be shared between threads, works in a forked process, and is pickled
/// with its index as that one's path.
///
/// Parameters
/// ----------
/// index : Index, str or os.PathLike
///     The index, or its file. It must be one of pictures, as `grasp-builder build` makes.
/// hand : {"auto", "left", "right"}, default "auto"
///     Which hand the pictures show; "auto" tries both: neighbours, networks and where
///     the arm comes from say which it is.
/// segment : {"scene", "skin"}, default "scene"
///     What finds the hand in a camera picture: a network that was trained on scenes, or
///     the colour of skin.
/// recall : float, default 0.95
///     How hard to look for neighbours, as in `Index.search`.
/// exact : bool, default False
///     Compare with every entry instead.
/// accept : {"calibrated", "always"}, default "calibrated"
///     Whether a hand may be unknown: by the limits that the index was calibrated with,
///     or not at all.
/// k : int, optional
///     How many neighbours vote, 1 to 100,000; by default what the index was calibrated
///     with.
/// rolls : int, default 1
///     Turn each picture this many times, 1 to 360, evenly over the circle, and take the
///     turn whose neighbours are nearest.
/// thorough : bool, default False
///     Look at camera pictures mirrored, turned, in other light and enlarged as well, and
///     join the answers: ten times the time, a few more of them right.
///
/// Raises
/// ------
/// IndexFileError
///     Where the index cannot be opened, or recognises no pictures.
/// ParameterError
///     Where a parameter cannot be.
///
/// Examples
/// --------
/// >>> recogniser = grasp.Recogniser("grasp.idx")
/// >>> recogniser.recognise("hand.jpg").grasp
/// 'pinch'
#[pyclass(frozen, module = "grasp")]
pub(crate) struct Recogniser {
    index: Py<Index>,
    options: RecogniseOptions,
    /// As they were given, for a pickle.
    given: Py<PyDict>,
}

// Python shows the default only where it is written out.
const _: () = assert!(DEFAULT_ROLLS == 1);

/// How many turns are wanted.
fn turns(rolls: &Bound<'_, PyAny>) -> PyResult<usize> {
    count("rolls", rolls, &ranges::ROLLS)
}

/// A picture's answer, not yet Python's.
type Answered = Result<(Record, Recognition), RecogniseError>;

#[pymethods]
impl Recogniser {
    #[new]
    #[pyo3(signature = (
        index, hand="auto", *, segment="scene", recall=0.95, exact=false, accept="calibrated", k=None,
        rolls=1, thorough=false
    ))]
    #[allow(clippy::too_many_arguments, reason = "Python names them")]
    fn new(
        py: Python<'_>,
        index: &Bound<'_, PyAny>,
        hand: &str,
        segment: &str,
        #[pyo3(from_py_with = real)] recall: f64,
        exact: bool,
        accept: &str,
        k: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = turns)] rolls: usize,
        thorough: bool,
    ) -> PyResult<Self> {
        let k = k.map(neighbours).transpose()?;
        let given = PyDict::new(py);
        for (name, value) in [("hand", hand), ("segment", segment), ("accept", accept)] {
            given.set_item(name, value)?;
        }
        given.set_item("recall", recall)?;
        given.set_item("exact", exact)?;
        given.set_item("k", k)?;
        given.set_item("rolls", rolls)?;
        given.set_item("thorough", thorough)?;
        let is_possible = exact || ranges::RECALL.contains(&recall);
        if !is_possible {
            return Err(parameter(format!(
                "a recall of {recall} is not possible: it must be above 0 and at most 1"
            )));
        }
        let unknown = |name: &str, value: &str, known: &str| {
            parameter(format!("{name} is {value:?}: {known} is needed"))
        };
        let options = RecogniseOptions {
            hand: match hand {
                "auto" => HandChoice::Auto,
                "left" => HandChoice::Left,
                "right" => HandChoice::Right,
                other => return Err(unknown("hand", other, "\"auto\", \"left\" or \"right\"")),
            },
            rolls,
            thorough,
            k,
            effort: if exact { Effort::Exact } else { Effort::Recall(recall) },
            vote: VoteOptions::default(),
            accept: match accept {
                "calibrated" => Accept::Calibrated,
                "always" => Accept::Always,
                other => return Err(unknown("accept", other, "\"calibrated\" or \"always\"")),
            },
            segment: SegmentParams {
                by: match segment {
                    "scene" => Finder::Scene,
                    "skin" => Finder::Skin,
                    other => return Err(unknown("segment", other, "\"scene\" or \"skin\"")),
                },
                ..SegmentParams::default()
            },
            ..RecogniseOptions::default()
        };
        let index = match index.cast::<Index>() {
            Ok(index) => index.clone().unbind(),
            Err(_) => Py::new(py, Index::open(py, index.extract::<PathBuf>()?, true)?)?,
        };
        let opened = index.get().get()?;
        opened.check_recognises().map_err(|cause| error::cannot_recognise(index.get().path(), cause))?;
        Ok(Self { index, options, given: given.unbind() })
    }

    /// The index that answers come from.
    #[getter]
    fn index(&self, py: Python<'_>) -> Py<Index> {
        self.index.clone_ref(py)
    }

    /// Recognise the grasp in a picture.
    ///
    /// Parameters
    /// ----------
    /// image : str, os.PathLike or numpy.ndarray
    ///     A file (PNG, JPEG, WebP, GIF, BMP, PNM), which is turned upright as its EXIF
    ///     data says; or an array of uint8 as it is seen upright: RGB, shape (h, w, 3),
    ///     or grey, shape (h, w). OpenCV's arrays are BGR: convert them
    ///     (``cv2.cvtColor(image, cv2.COLOR_BGR2RGB)``), because nothing in an array says
    ///     which of the two it is, and a hand in wrong colours is recognised worse
    ///     without any error.
    /// mask : str, os.PathLike or numpy.ndarray, optional
    ///     Where the hand is, of the picture's size: a file that is white on black, or an
    ///     array of shape (h, w), bool, or uint8 with hand where it is 128 or more.
    /// landmarks : array_like of shape (21, 2) or (21, 3), optional
    ///     Where a tracker has found the hand's joints in a camera picture, right and down:
    ///     wrist, four of the thumb from its root to its tip, four of each finger from its
    ///     knuckle to its tip, index finger first, as MediaPipe orders them.
    /// landmark_unit : {"pixel", "share"}, default "pixel"
    ///     What they are counted in: pixels, or shares of the picture's width and height.
    /// segmented : bool, default False
    ///     The picture is segmented already: a hand on black.
    /// depth : str, os.PathLike or numpy.ndarray of uint16, shape (h, w), optional
    ///     A depth picture of the picture's size, instead of a mask; 0 where nothing is
    ///     seen.
    /// depth_range : tuple of two ints, optional
    ///     The depths that are hand, (near, far), both included, in the depth picture's
    ///     unit.
    ///
    /// Returns
    /// -------
    /// Answer
    ///     What was recognised. A hand that the index has nothing like is an answer as
    ///     well, whose `grasp` is "unknown".
    ///
    /// Raises
    /// ------
    /// PictureError
    ///     Where the picture cannot be read, is an array that is neither of the two
    ///     forms, or shows no hand.
    /// ParameterError
    ///     Where parameters do not go together.
    /// IndexFileError
    ///     Where the index was changed while it was in use.
    #[pyo3(signature = (
        image, mask=None, *, landmarks=None, landmark_unit="pixel", segmented=false, depth=None,
        depth_range=None
    ))]
    #[allow(clippy::too_many_arguments, reason = "Python names them")]
    fn recognise<'py>(
        &self,
        py: Python<'py>,
        image: &Bound<'py, PyAny>,
        mask: Option<&Bound<'py, PyAny>>,
        landmarks: Option<&Bound<'py, PyAny>>,
        landmark_unit: &str,
        segmented: bool,
        depth: Option<&Bound<'py, PyAny>>,
        depth_range: Option<(Integer, Integer)>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let input = Input::new(image)?;
        let source = mask::source(py, mask, (landmarks, landmark_unit), segmented, depth, depth_range)?;
        let index = self.index.get().get()?;
        let answered = py.detach(|| answer(&index, &self.options, &input, &source));
        self.finish(py, &index, &input, answered)
    }

    /// Recognise the grasps in many pictures, on several cores.
    ///
    /// Parameters
    /// ----------
    /// images : sequence
    ///     Pictures, each as `recognise` takes it.
    /// segmented : bool, default False
    ///     The pictures are segmented already: hands on black.
    /// errors : {"raise", "return"}, default "raise"
    ///     What becomes of a picture without an answer: the first one's PictureError is
    ///     raised, or each stands in its picture's place.
    /// threads : int, optional
    ///     How many threads work, 1 to 1024; by default one a core. Answers do not depend on it.
    ///
    /// Returns
    /// -------
    /// list of Answer
    ///     An answer a picture, in their order; with ``errors="return"`` a PictureError
    ///     where there is none.
    ///
    /// Raises
    /// ------
    /// PictureError, ParameterError, IndexFileError
    ///     As `recognise`.
    #[pyo3(signature = (images, *, segmented=false, errors="raise", threads=None))]
    fn recognise_batch<'py>(
        &self,
        py: Python<'py>,
        images: &Bound<'py, PyAny>,
        segmented: bool,
        errors: &str,
        threads: Option<Integer>,
    ) -> PyResult<Bound<'py, PyList>> {
        let returns = match errors {
            "raise" => false,
            "return" => true,
            other => {
                return Err(parameter(format!("errors is {other:?}: \"raise\" or \"return\" is needed")));
            }
        };
        let index = self.index.get().get()?;
        let threads = crate::parallel::threads(threads)?;
        let source = if segmented { MaskSource::Segmented } else { MaskSource::Camera };
        if images.is_instance_of::<pyo3::types::PyString>() {
            return Err(parameter("images is a single path: give a list of pictures, or call recognise"));
        }
        let answers = PyList::empty(py);
        let keep = |answer: PyResult<Bound<'py, PyAny>>| match answer {
            Err(cause) if returns && error::is_of_picture(py, &cause) => answers.append(cause.value(py)),
            other => answers.append(other?),
        };
        let mut images = images.try_iter()?;
        loop {
            // Their pixels are in memory together.
            let inputs: Vec<PyResult<Input>> =
                images.by_ref().take(AT_ONCE * threads).map(|image| Input::new(&image?)).collect();
            if inputs.is_empty() {
                return Ok(answers);
            }
            let work =
                |input: &Option<&Input>| input.map(|input| answer(&index, &self.options, input, &source));
            let known: Vec<Option<&Input>> = inputs.iter().map(|input| input.as_ref().ok()).collect();
            let answered = py.detach(|| each(&known, threads, work));
            for (input, answered) in inputs.iter().zip(answered) {
                keep(match (input, answered) {
                    (Ok(input), Some(answered)) => self.finish(py, &index, input, answered),
                    (Ok(_), None) => Err(error::internal("a picture was not looked at")),
                    (Err(cause), _) => Err(cause.clone_ref(py)),
                })?;
            }
            py.check_signals()?;
        }
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> ((Py<Index>,), Bound<'py, PyDict>) {
        ((self.index.clone_ref(py),), self.given.bind(py).clone())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let index = self.index.bind(py).repr()?;
        let given: Vec<String> = self
            .given
            .bind(py)
            .iter()
            .map(|(name, value)| Ok(format!("{name}={}", value.repr()?)))
            .collect::<PyResult<_>>()?;
        Ok(format!("<grasp.Recogniser by {index}: {}>", given.join(", ")))
    }
}

impl Recogniser {
    /// The answer to one picture after others: `follow` updates the picture's own answer, and gets
    /// `None` where there is none.
    pub(crate) fn recognise_after<'py>(
        &self,
        py: Python<'py>,
        input: &Input,
        source: &MaskSource,
        follow: impl FnOnce(&grasp_recognise::Recogniser<'_>, Option<&mut Recognition>),
    ) -> PyResult<Bound<'py, PyAny>> {
        let index = self.index.get().get()?;
        let mut found = py.detach(|| recognise(&index, &self.options, input, source));
        let single = found.as_ref().ok().map(SingleRecord::new);
        let recogniser = grasp_recognise::Recogniser::new(&index, self.options.clone());
        follow(&recogniser, found.as_mut().ok());
        let answered = found.map(|found| {
            let mut record = record(&index, input, &found);
            if let Record::Answer(answer) = &mut record {
                answer.single = single;
            }
            (record, found)
        });
        self.finish(py, &index, input, answered)
    }

    /// The answer as Python has it, where the index is still what was asked.
    fn finish<'py>(
        &self,
        py: Python<'py>,
        index: &Arc<grasp_index::Index>,
        input: &Input,
        answered: Answered,
    ) -> PyResult<Bound<'py, PyAny>> {
        let path = self.index.get().path();
        index.check_unchanged().map_err(|cause| error::changed(path, cause))?;
        let (record, recognition) =
            answered.map_err(|cause| error::picture(input.file().as_deref(), &cause))?;
        let json = serde_json::to_string(&record).map_err(|cause| error::failure(&cause))?;
        let answer = match record {
            Record::Answer(answer) => answer,
            // An entry of the index that cannot be read.
            Record::Failure(failure) => return Err(error::index_file(failure.error.message)),
        };
        let found = Found { index: Arc::clone(index), path: path.to_owned(), recognition, answer };
        static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
        CLASS.import(py, "grasp.answer", "Answer")?.call1((json, found))
    }
}

/// Recognises a picture, and writes down what was.
fn answer(
    index: &grasp_index::Index,
    options: &RecogniseOptions,
    input: &Input,
    source: &MaskSource,
) -> Answered {
    let found = recognise(index, options, input, source)?;
    Ok((record(index, input, &found), found))
}

fn recognise(
    index: &grasp_index::Index,
    options: &RecogniseOptions,
    input: &Input,
    source: &MaskSource,
) -> Result<Recognition, RecogniseError> {
    let recogniser = grasp_recognise::Recogniser::new(index, options.clone());
    match input {
        Input::File(path) => recogniser.recognise(&picture::read(path)?, source),
        Input::Pixels(pixels) => {
            let prepared = Prepared::new(pixels.clone(), false, source, &options.segment)?;
            recogniser.recognise_prepared(prepared, Timings::default())
        }
    }
}

fn record(index: &grasp_index::Index, input: &Input, found: &Recognition) -> Record {
    let name = input.name();
    Record::answer(name.clone(), None, found, index, false)
        .unwrap_or_else(|cause| Record::failed(name, None, "index", cause.to_string()))
}
