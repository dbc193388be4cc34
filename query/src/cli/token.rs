//! The token that a service asks for and a client shows.

use std::path::Path;

use anyhow::{Context as _, bail};

/// A token: one line of visible characters, that it may stand in a header.
pub(super) fn read(path: &Path) -> anyhow::Result<String> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read the token {}", path.display()))?;
    let token = text.trim();
    let is_visible =
        token.bytes().all(|byte| byte.is_ascii_graphic() && !matches!(byte, b';' | b',' | b'"' | b'\\'));
    if token.len() < 16 || !is_visible {
        bail!(
            "{} holds no token: one line of at least 16 letters and digits is needed, such as `openssl rand -hex 32` writes",
            path.display()
        );
    }
    Ok(token.to_owned())
}
