//! Where a service is.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use ureq::http::Uri;

/// The address of a service.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// `http://HOST:PORT[/PATH]`, without a slash at its end.
    Http(String),
    /// `unix:PATH`.
    Unix(PathBuf),
}

/// Why a text is no address.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AddressError {
    /// Neither form.
    #[error("an address is http://HOST:PORT or unix:PATH")]
    Form,
    /// TLS is left to a proxy.
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
        let port = uri.port_u16().unwrap_or(80);
        Ok(Self::Http(format!("http://{host}:{port}{}", uri.path().trim_end_matches('/'))))
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Http(base) => f.write_str(base),
            Self::Unix(path) => write!(f, "unix:{}", path.display()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_hosts_or_paths() {
        let http = |base: &str| Ok(Address::Http(base.into()));
        for (text, expected) in [
            ("http://127.0.0.1:8750", http("http://127.0.0.1:8750")),
            ("http://robot/", http("http://robot:80")),
            ("http://[::1]:8750/grasp/", http("http://[::1]:8750/grasp")),
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
