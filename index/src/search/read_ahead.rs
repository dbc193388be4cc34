//! What a search says of its reads to come to whoever holds the bytes.

/// A file that can be read ahead. None of this has any effect besides time.
pub(crate) trait ReadAhead: Sync {
    /// Bytes will be read here and there: reading on beyond each page that is touched is wasted.
    fn will_jump(&self);

    /// `part`, if it is this file's, will be read soon: all of it at once instead of page by page.
    fn will_need(&self, part: &[u8]);

    /// `part`, if it is this file's, will be read next and from front to back.
    fn will_pass(&self, part: &[u8]);
}
