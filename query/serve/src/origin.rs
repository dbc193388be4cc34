//! Whose page makes a browser send a request. A browser sends what any page asks it to, also to
//! services that only this machine can reach; what it says of the page in `Host`, `Sec-Fetch-Site`
//! and `Origin` no page can change.

use std::net::{IpAddr, SocketAddr};

use axum::extract::Request;
use axum::http::uri::Authority;
use axum::http::{HeaderName, StatusCode, header};

use super::problem::Problem;

/// How the page that asks relates to this service, as browsers state it to addresses that they
/// trust.
const SEC_FETCH_SITE: HeaderName = HeaderName::from_static("sec-fetch-site");

/// The names under which a service answers. A foreign page can give its own name any address (DNS
/// rebinding), and is then of the same origin as the service: the name alone shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Names {
    /// `localhost` and loopback addresses.
    Loopback,
    /// Besides, names that no foreign page can have: addresses, names without a dot, and names
    /// under `.local`.
    Network,
    /// All; for a service whose token no foreign page knows.
    Any,
}

impl Names {
    /// The names of a service without a token that listens at `address`.
    pub fn of_address(address: SocketAddr) -> Self {
        if address.ip().is_loopback() { Self::Loopback } else { Self::Network }
    }

    fn include(self, name: &str) -> bool {
        let name = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
        let address: Option<IpAddr> = name.parse().ok();
        let is_loopback =
            name.eq_ignore_ascii_case("localhost") || address.is_some_and(|address| address.is_loopback());
        match self {
            Self::Any => true,
            Self::Loopback => is_loopback,
            Self::Network => {
                let is_single = !name.is_empty() && !name.contains(['.', ':']);
                is_loopback || address.is_some() || is_single || is_under_local(name)
            }
        }
    }
}

/// Multicast DNS, which the machines of the network themselves answer.
fn is_under_local(name: &str) -> bool {
    name.rsplit_once('.').is_some_and(|(_, last)| last.eq_ignore_ascii_case("local"))
}

/// Refuses a request under a name that is none of `names`.
pub fn check_host(request: &Request, names: Names) -> Result<(), Problem> {
    if names == Names::Any || host(request).is_some_and(|host| names.include(without_port(host))) {
        return Ok(());
    }
    let message = match names {
        Names::Loopback => {
            "without a token, the service answers to the names localhost, 127.0.0.1 and [::1] only"
        }
        _ => "the service answers to this machine's address or its plain name only",
    };
    Err(Problem::new(StatusCode::FORBIDDEN, "host", message))
}

/// Refuses a request that a page of another origin makes a browser send. Programs that are no
/// browsers send neither header, and no page can make them do anything.
pub fn check_origin(request: &Request) -> Result<(), Problem> {
    let text = |name| request.headers().get(name).map(|value| value.to_str().unwrap_or_default());
    let is_own = match (text(SEC_FETCH_SITE), text(header::ORIGIN)) {
        // `none` is the person at the browser. `same-site` is another port of this machine, say:
        // another program's page.
        (Some(site), _) => matches!(site, "same-origin" | "none"),
        // Over plain HTTP browsers state the origin alone, and only with requests that can change
        // something.
        (None, Some(origin)) => {
            let authority = origin.split_once("://").map(|(_, authority)| authority);
            authority.is_some_and(|of| host(request).is_some_and(|host| of.eq_ignore_ascii_case(host)))
        }
        (None, None) => true,
    };
    if is_own {
        return Ok(());
    }
    let message = "a page of another origin asks: the service answers to its own pages, and to programs";
    Err(Problem::new(StatusCode::FORBIDDEN, "origin", message))
}

/// HOST or HOST:PORT, as the request names the service; `None` where it names several, of which a
/// proxy may have gone by another one (RFC 9112, 3.2).
fn host(request: &Request) -> Option<&str> {
    let mut named = request.headers().get_all(header::HOST).iter();
    let first = named.next();
    if named.next().is_some() {
        return None;
    }
    let authority = request.uri().authority().map(Authority::as_str);
    authority.or_else(|| first?.to_str().ok())
}

fn without_port(host: &str) -> &str {
    match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::body::Body;

    fn request(headers: &[(&str, &str)]) -> Request {
        let mut request = Request::builder();
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        request.body(Body::empty()).unwrap()
    }

    #[test]
    fn a_service_answers_to_its_own_names() {
        let answers = |host: &str, names| check_host(&request(&[("host", host)]), names).is_ok();
        for host in ["localhost", "LocalHost:8750", "127.0.0.1:8750", "[::1]:8750", "127.3.2.1", "[::1]"] {
            assert!(answers(host, Names::Loopback) && answers(host, Names::Network), "{host}");
        }
        for host in ["192.168.1.7:80", "[fe80::1]:80", "laptop:80", "laptop.local"] {
            assert!(!answers(host, Names::Loopback) && answers(host, Names::Network), "{host}");
        }
        for host in
            ["", "example.com", "localhost.example.com", "127.0.0.1.example.com:80", "local.example.com:80"]
        {
            assert!(!answers(host, Names::Loopback) && !answers(host, Names::Network), "{host}");
            assert!(answers(host, Names::Any), "{host}");
        }
        for both in [["localhost", "example.com"], ["example.com", "localhost"], ["localhost", "localhost"]] {
            let request = request(&both.map(|host| ("host", host)));
            assert!(check_host(&request, Names::Loopback).is_err(), "{both:?}");
        }
    }

    #[test]
    fn pages_of_other_origins_are_refused() {
        let host = ("host", "localhost:8750");
        for headers in [
            [].as_slice(),
            &[("sec-fetch-site", "same-origin"), ("origin", "http://localhost:8750")],
            &[("sec-fetch-site", "none")],
            &[("origin", "http://localhost:8750")],
            // Behind a proxy that renames the host, the browser's own word counts.
            &[("sec-fetch-site", "same-origin"), ("origin", "https://grasp.example.com")],
        ] {
            assert!(check_origin(&request(&[&[host], headers].concat())).is_ok(), "{headers:?}");
        }
        for headers in [
            [("sec-fetch-site", "cross-site")].as_slice(),
            &[("sec-fetch-site", "cross-site"), ("origin", "http://localhost:8750")],
            &[("sec-fetch-site", "same-site"), ("origin", "http://localhost:3000")],
            &[("sec-fetch-site", "same-site")],
            &[("sec-fetch-site", "")],
            &[("origin", "http://localhost:3000")],
            &[("origin", "http://localhost")],
            &[("origin", "https://example.com")],
            &[("origin", "null")],
            &[("origin", "")],
        ] {
            assert!(check_origin(&request(&[&[host], headers].concat())).is_err(), "{headers:?}");
        }
    }
}
