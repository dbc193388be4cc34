//! The descriptors of an index, as rows of numbers.

use super::read_ahead::ReadAhead;

/// The descriptors of an index: rows of `dim` values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows<'a> {
    pub(crate) values: &'a [f32],
    pub(crate) dim: usize,
}

impl<'a> Rows<'a> {
    pub(crate) fn len(&self) -> usize {
        self.values.len() / self.dim.max(1)
    }

    /// Row `id`; `None` past the end, as an id read from a file may be.
    pub(crate) fn get(&self, id: u32) -> Option<&'a [f32]> {
        let start = (id as usize).checked_mul(self.dim)?;
        self.values.get(start..start.checked_add(self.dim)?)
    }
}

/// The descriptors that an index is made of, and the file that they lie in.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    pub(crate) rows: Rows<'a>,
    pub(crate) file: &'a dyn ReadAhead,
}

impl Source<'_> {
    /// Rows will be read here and there from now on.
    pub(crate) fn will_jump(&self) {
        self.file.will_jump();
    }

    /// Rows will be read from front to back from now on.
    pub(crate) fn will_pass(&self) {
        self.file.will_pass(bytemuck::cast_slice(self.rows.values));
    }
}
