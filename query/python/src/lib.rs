//! The Python package `grasp`: what its classes do, by the libraries that the programs stand on.
//!
//! In order of what uses what: `error` raises Python's exceptions, `number` takes numbers of any
//! size, `array` reads NumPy's arrays, `parallel` shares work among threads; `index` searches,
//! `building` writes indexes and `progress` says how far that is; `picture`, `mask` and `landmarks`
//! say what is to be recognised, `recogniser` recognises it, and with `sequence` one picture after
//! the other; `found` is what the answer came from, `strategy` what a robot makes of it.
//!
//! Docstrings are NumPy's, because Python shows them. Whatever takes long lets other Python threads
//! run. No thread works for a call that has returned and no lock is held between calls, so that a
//! process may fork at any moment.

mod array;
mod building;
mod error;
mod found;
mod index;
mod landmarks;
mod mask;
mod number;
mod parallel;
mod picture;
mod progress;
mod recogniser;
mod sequence;
mod strategy;

/// The compiled half of the package.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use super::building::build;
    #[pymodule_export]
    use super::found::Found;
    #[pymodule_export]
    use super::index::Index;
    #[pymodule_export]
    use super::recogniser::Recogniser;
    #[pymodule_export]
    use super::sequence::Sequence;
    #[pymodule_export]
    use super::strategy::strategy;
}
