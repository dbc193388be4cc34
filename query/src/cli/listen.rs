//! Where a server listens.

use std::net::{SocketAddr, ToSocketAddrs as _};

/// An address and a port, or a name that this machine knows the address of, as `localhost:8750`.
pub(super) fn parse_listen(text: &str) -> Result<SocketAddr, String> {
    let found = text.to_socket_addrs().ok().and_then(|mut found| found.next());
    found.ok_or_else(|| "an address and a port are needed, as 127.0.0.1:8750 or localhost:8750".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_and_names_are_known_and_need_a_port() {
        assert_eq!(parse_listen("127.0.0.1:8750").unwrap().to_string(), "127.0.0.1:8750");
        assert_eq!(parse_listen("[::1]:0").unwrap().to_string(), "[::1]:0");
        let local = parse_listen("localhost:1").unwrap();
        assert!(local.ip().is_loopback() && local.port() == 1);
        for wrong in ["8750", "127.0.0.1", "localhost", "127.0.0.1:99999"] {
            assert!(parse_listen(wrong).is_err(), "{wrong}");
        }
    }
}
