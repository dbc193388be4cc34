//! The token that a service asks for and a client shows.

use std::path::Path;

use anyhow::Context as _;

use grasp_serve::wire::Token;

/// A token: one line of visible characters, that it may stand in a header.
pub(super) fn read(path: &Path) -> anyhow::Result<Token> {
    let text = grasp_bounded::read_text(path)
        .with_context(|| format!("cannot read the token {}", path.display()))?;
    Token::new(text.trim()).with_context(|| {
        format!(
            "{} holds no token: one line of at least {} letters and digits is needed, such as `openssl rand -hex 32` writes",
            path.display(),
            Token::LEAST
        )
    })
}
