//! What an answer came from.

use std::path::PathBuf;
use std::sync::Arc;

use grasp_answer::explain;
use grasp_answer::record::Answer;
use grasp_index::Index;
use grasp_recognise::Recognition;
use numpy::PyArray3;
use numpy::ndarray::Array3;
use pyo3::prelude::*;

use crate::error;

/// A recognition with all that led to it, for the drawing that explains it.
#[pyclass(frozen, module = "grasp._native")]
pub(crate) struct Found {
    pub(crate) index: Arc<Index>,
    pub(crate) path: PathBuf,
    pub(crate) recognition: Recognition,
    pub(crate) answer: Box<Answer>,
}

#[pymethods]
impl Found {
    /// Draw how the answer came about.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray of uint8, shape (h, w, 3)
    ///     RGB.
    fn explain<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let drawing = py.detach(|| explain::draw(&self.recognition, &self.answer, &self.index));
        self.index.check_unchanged().map_err(|cause| error::changed(&self.path, cause))?;
        let shape = (drawing.height() as usize, drawing.width() as usize, 3);
        let pixels = Array3::from_shape_vec(shape, drawing.into_raw());
        let pixels = pixels.map_err(|_| error::internal("the drawing has another size than it says"))?;
        Ok(PyArray3::from_owned_array(py, pixels))
    }
}
