//! `grasp.Sequence`.

use std::sync::{Mutex, PoisonError};

use grasp_recognise::ranges;
use grasp_recognise::sequence::{Filter, SequenceParams};
use pyo3::prelude::*;

use crate::error::parameter;
use crate::mask;
use crate::number::real;
use crate::picture::Input;
use crate::recogniser::Recogniser;

/// Pictures of one hand in their order, each answered by all so far.
///
/// What was seen before counts for what is seen now: the grasp may change from one picture to
/// the next, and the hand turns a little. A sequence can be shared between threads; its pictures
/// count in the order in which they are recognised.
///
/// Parameters
/// ----------
/// recogniser : Recogniser
///     What each picture is recognised by.
/// switch : float, default 0.2
///     The probability that the grasp changes from one picture to the next, 0 to 1.
/// motion_deg : float, default 5.0
///     How far the hand turns from one picture to the next, in degrees, 0 to 180.
///
/// Raises
/// ------
/// ParameterError
///     Where a parameter is out of its range.
///
/// Examples
/// --------
/// >>> sequence = grasp.Sequence(recogniser)
/// >>> answers = [sequence.recognise(frame) for frame in frames]
#[pyclass(frozen, module = "grasp")]
pub(crate) struct Sequence {
    recogniser: Py<Recogniser>,
    params: SequenceParams,
    /// Held by a thread that is attached to Python, as a thread that forks is, and only while one
    /// answer is joined with those before.
    filter: Mutex<Filter>,
}

#[pymethods]
impl Sequence {
    #[new]
    #[pyo3(signature = (recogniser, *, switch=0.2, motion_deg=5.0))]
    fn new(
        recogniser: Py<Recogniser>,
        #[pyo3(from_py_with = real)] switch: f64,
        #[pyo3(from_py_with = real)] motion_deg: f64,
    ) -> PyResult<Self> {
        for (name, value, range) in
            [("switch", switch, ranges::PROBABILITY), ("motion_deg", motion_deg, ranges::MOTION_DEG)]
        {
            let (least, most) = range.clone().into_inner();
            if !range.contains(&value) {
                return Err(parameter(format!("{name} is {value}: it must be from {least} to {most}")));
            }
        }
        let params = SequenceParams { switch, motion_deg };
        Ok(Self { recogniser, params, filter: Mutex::new(Filter::new(params, None)) })
    }

    /// The recogniser that each picture is recognised by.
    #[getter]
    fn recogniser(&self, py: Python<'_>) -> Py<Recogniser> {
        self.recogniser.clone_ref(py)
    }

    /// Recognise the grasp in the next picture, by all so far.
    ///
    /// Parameters
    /// ----------
    /// image : str, os.PathLike or numpy.ndarray
    ///     The picture, as `Recogniser.recognise` takes it.
    /// mask : str, os.PathLike or numpy.ndarray, optional
    ///     Where the hand is, as there.
    /// segmented : bool, default False
    ///     The picture is segmented already: a hand on black.
    ///
    /// Returns
    /// -------
    /// Answer
    ///     What all pictures so far say; `Answer.to_dict` has what this one says by itself
    ///     as ``single``.
    ///
    /// Raises
    /// ------
    /// PictureError, ParameterError, IndexFileError
    ///     As `Recogniser.recognise`. Of a picture that shows no hand nothing is learned, but
    ///     that time goes by.
    #[pyo3(signature = (image, mask=None, *, segmented=false))]
    fn recognise<'py>(
        &self,
        py: Python<'py>,
        image: &Bound<'py, PyAny>,
        mask: Option<&Bound<'py, PyAny>>,
        segmented: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let input = Input::new(image)?;
        let source = mask::source(py, mask, (None, "pixel"), segmented, None, None)?;
        self.recogniser.get().recognise_after(py, &input, &source, |recogniser, found| {
            let mut filter = self.filter.lock().unwrap_or_else(PoisonError::into_inner);
            match found {
                Some(found) => recogniser.follow(found, &mut filter),
                None => filter.pass(),
            }
        })
    }

    /// Forget what was seen: the next picture is the first.
    fn clear(&self) {
        *self.filter.lock().unwrap_or_else(PoisonError::into_inner) = Filter::new(self.params, None);
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let SequenceParams { switch, motion_deg } = self.params;
        let recogniser = self.recogniser.bind(py).repr()?;
        Ok(format!("<grasp.Sequence by {recogniser}: switch={switch}, motion_deg={motion_deg}>"))
    }
}
