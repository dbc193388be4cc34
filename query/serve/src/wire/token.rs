//! The secret that a service asks for and a client shows.

use std::fmt;

use subtle::ConstantTimeEq as _;

/// A token. Its `Debug` does not show it, so that no log of a struct that holds one can.
#[derive(Clone)]
pub struct Token(String);

impl Token {
    /// The shortest token that is accepted, in characters.
    pub const LEAST: usize = 16;

    /// A token of visible ASCII characters that can stand in a header and a cookie; `None` for any
    /// other text, or one that is shorter than [`Self::LEAST`].
    pub fn new(text: &str) -> Option<Self> {
        let is_usable = |byte: u8| byte.is_ascii_graphic() && !matches!(byte, b';' | b',' | b'"' | b'\\');
        (text.len() >= Self::LEAST && text.bytes().all(is_usable)).then(|| Self(text.to_owned()))
    }

    /// Whether `shown` is this token. The time that it takes depends on the lengths of both alone,
    /// so that nobody can guess the token character by character.
    pub fn is(&self, shown: &str) -> bool {
        self.0.as_bytes().ct_eq(shown.as_bytes()).into()
    }

    /// The secret itself, for a header.
    pub fn reveal(&self) -> &str {
        &self.0
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token(..)")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn debug_shows_nothing_of_a_token() {
        let token = Token::new("0123456789abcdef").unwrap();
        assert_eq!(format!("{:?}", Some(&token)), "Some(Token(..))");
    }

    #[test]
    fn only_the_whole_token_is_the_token() {
        let token = Token::new("0123456789abcdef").unwrap();
        assert!(token.is("0123456789abcdef"));
        for other in ["", "0123456789abcde", "0123456789abcdeX", "0123456789abcdef0"] {
            assert!(!token.is(other), "{other}");
        }
    }
}
