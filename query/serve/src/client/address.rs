//! Where a service is.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use hyper::Uri;

/// The address of a service.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// `http://HOST[:PORT][/PATH]`.
    Http {
        /// HOST:PORT, to connect to.
        authority: String,
        /// What stands before the service's own paths; empty, or begins with a slash and does not
        /// end in one.
        prefix: String,
    },
    /// `unix:PATH`.
    Unix(PathBuf),
}

/// Why a text is no address.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AddressError {
    /// Neither form.
    #[error("an address is http://HOST:PORT or unix:PATH")]
    Form,
    /// Encryption is for others to do.
    #[error("https is not supported: name a proxy on this machine, or a tunnel, by http://")]
    Https,
}

impl FromStr for Address {
    type Err = AddressError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if let Some(path) = text.strip_prefix("unix:") {
            return if path.is_empty() { Err(AddressError::Form) } else { Ok(Self::Unix(path.into())) };
        }
        let uri: Uri = text.parse().map_err(|_| AddressError::Form)?;
        match uri.scheme_str() {
            Some("http") if uri.query().is_none() => {}
            Some("https") => return Err(AddressError::Https),
            _ => return Err(AddressError::Form),
        }
        let host = uri.host().filter(|host| !host.is_empty()).ok_or(AddressError::Form)?;
        let authority = format!("{host}:{}", uri.port_u16().unwrap_or(80));
        Ok(Self::Http { authority, prefix: uri.path().trim_end_matches('/').to_owned() })
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Http { authority, prefix } => write!(f, "http://{authority}{prefix}"),
            Self::Unix(path) => write!(f, "unix:{}", path.display()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_hosts_or_paths() {
        let http = |authority: &str, prefix: &str| {
            Ok(Address::Http { authority: authority.into(), prefix: prefix.into() })
        };
        for (text, expected) in [
            ("http://127.0.0.1:8750", http("127.0.0.1:8750", "")),
            ("http://robot/", http("robot:80", "")),
            ("http://[::1]:8750/grasp/", http("[::1]:8750", "/grasp")),
            ("unix:/run/grasp.sock", Ok(Address::Unix("/run/grasp.sock".into()))),
            ("https://robot", Err(AddressError::Https)),
            ("robot:8750", Err(AddressError::Form)),
            ("unix:", Err(AddressError::Form)),
            ("http://", Err(AddressError::Form)),
            ("http://robot/?a=b", Err(AddressError::Form)),
            ("", Err(AddressError::Form)),
        ] {
            assert_eq!(text.parse::<Address>(), expected, "{text}");
        }
    }
}
