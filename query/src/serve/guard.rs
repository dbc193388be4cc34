//! Who may ask, and what every answer says to a browser.

use std::net::IpAddr;
use std::time::Instant;

use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::Shared;
use super::metrics::PATHS;
use super::problem::Problem;

/// The cookie by which the page shows the token.
const COOKIE: &str = "grasp_token";

/// Nothing from elsewhere is loaded, nobody may frame the page, and answers are not kept.
const HEADERS: [(HeaderName, &str); 4] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'self'; img-src 'self' blob: data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    ),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::CACHE_CONTROL, "no-store"),
];

/// Checks and counts every request, and puts the headers on every answer.
pub(super) async fn guard(State(service): State<Shared>, request: Request, next: Next) -> Response {
    let started = Instant::now();
    let path = counted(request.uri().path());
    let refused = check(&service, &request);
    let mut response = match refused {
        Err(problem) => problem.into_response(),
        Ok(()) => next.run(request).await,
    };
    for (name, value) in HEADERS {
        response.headers_mut().entry(name).or_insert(HeaderValue::from_static(value));
    }
    service.metrics.answered(path, response.status().as_u16(), started.elapsed());
    response
}

fn check(service: &Shared, request: &Request) -> Result<(), Problem> {
    let Some(token) = &service.settings.token else {
        return match service.settings.local_names_only && !names_this_machine(request) {
            // A page of another site could otherwise reach the service under a name that leads here.
            true => Err(Problem::new(
                StatusCode::FORBIDDEN,
                "host",
                "without a token, the service answers to the names localhost, 127.0.0.1 and [::1] only",
            )),
            false => Ok(()),
        };
    };
    if is_open(request.uri().path()) || shows(request.headers(), token) {
        return Ok(());
    }
    Err(Problem::new(
        StatusCode::UNAUTHORIZED,
        "token",
        "a token is needed: send the header `Authorization: Bearer TOKEN`, with the token of the service's --token-file",
    ))
}

/// What tells nothing and costs nothing: the page without its answers, and whether the service runs.
fn is_open(path: &str) -> bool {
    !(path.starts_with("/v1/") || path.starts_with("/quiz") || path == "/metrics")
}

fn shows(headers: &HeaderMap, token: &str) -> bool {
    let text = |name| headers.get(name).and_then(|value: &HeaderValue| value.to_str().ok());
    let bearer = text(header::AUTHORIZATION).and_then(|value| value.strip_prefix("Bearer "));
    let cookies = text(header::COOKIE).into_iter().flat_map(|cookies| cookies.split(';'));
    let mut cookie = cookies.filter_map(|cookie| cookie.trim().strip_prefix(COOKIE)?.strip_prefix('='));
    bearer.is_some_and(|found| is_same(found.trim(), token)) || cookie.any(|found| is_same(found, token))
}

/// Compares in a time that does not tell how much is right.
fn is_same(found: &str, token: &str) -> bool {
    let differing = found.bytes().zip(token.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
    found.len() == token.len() && differing == 0
}

fn names_this_machine(request: &Request) -> bool {
    let host = request.uri().authority().map(axum::http::uri::Authority::as_str);
    let host = host.or_else(|| request.headers().get(header::HOST)?.to_str().ok());
    let Some(host) = host else {
        return false;
    };
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    };
    let name = name.trim_start_matches('[').trim_end_matches(']');
    name.eq_ignore_ascii_case("localhost") || name.parse().is_ok_and(|address: IpAddr| address.is_loopback())
}

/// `POST /session`: the page trades the token for a cookie that scripts cannot read, so that pictures load by themselves.
pub(super) async fn session(State(service): State<Shared>, headers: HeaderMap) -> Result<Response, Problem> {
    let Some(token) = &service.settings.token else {
        return Ok(StatusCode::NO_CONTENT.into_response());
    };
    if !shows(&headers, token) {
        return Err(Problem::new(StatusCode::UNAUTHORIZED, "token", "this is not the service's token"));
    }
    let cookie = format!("{COOKIE}={token}; HttpOnly; SameSite=Strict; Path=/");
    let cookie = HeaderValue::from_str(&cookie).map_err(|_| Problem::lost())?;
    Ok((StatusCode::NO_CONTENT, [(header::SET_COOKIE, cookie)]).into_response())
}

/// The name under which a path is counted: few, whatever is asked for.
fn counted(path: &str) -> &'static str {
    let other = PATHS.last().copied().unwrap_or_default();
    PATHS.into_iter().find(|name| path.starts_with(name)).unwrap_or(other)
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::body::Body;

    fn is_local(host: &str) -> bool {
        names_this_machine(&Request::builder().header(header::HOST, host).body(Body::empty()).unwrap())
    }

    #[test]
    fn only_names_of_this_machine_are_its_own() {
        for host in ["localhost", "LocalHost:8750", "127.0.0.1:8750", "[::1]:8750", "127.3.2.1", "[::1]"] {
            assert!(is_local(host), "{host}");
        }
        for host in ["", "example.com", "localhost.example.com", "127.0.0.1.example.com:80", "10.0.0.1", "::"]
        {
            assert!(!is_local(host), "{host}");
        }
    }

    #[test]
    fn a_token_is_shown_by_header_or_cookie_and_no_other_will_do() {
        let shows = |name: HeaderName, value: &str| {
            let mut headers = HeaderMap::new();
            headers.insert(name, HeaderValue::from_str(value).unwrap());
            shows(&headers, "sesame")
        };
        assert!(shows(header::AUTHORIZATION, "Bearer sesame"));
        assert!(shows(header::COOKIE, "a=b; grasp_token=sesame"));
        for (name, value) in [
            (header::AUTHORIZATION, "Bearer sesam"),
            (header::AUTHORIZATION, "Bearer sesame2"),
            (header::AUTHORIZATION, "sesame"),
            (header::COOKIE, "grasp_token="),
            (header::COOKIE, "xgrasp_token=sesame"),
        ] {
            assert!(!shows(name, value), "{value}");
        }
    }
}
