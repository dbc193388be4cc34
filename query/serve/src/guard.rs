//! Who may ask.

use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::browser::protected;
use super::linger::Linger;
use super::metrics::PATHS;
use super::origin::{Names, check_host, check_origin};
use super::page;
use super::problem::Problem;
use super::refusals::Guarded;
use super::request_log::RequestLog;
use super::service::Shared;
use super::tags;
use crate::wire::Token;

/// The cookie by which the page shows the token.
const COOKIE: &str = "grasp_token";

/// What anybody may ask for, besides the page's own files: paths that cost little, and of the index
/// say only whether it is served, and why not. Every other path needs the token and the service's
/// own origin, so that a new one is protected unless it is added here.
const OPEN: [&str; 5] = ["/docs", "/docs.css", "/openapi.json", "/healthz", "/readyz"];

/// Checks and counts every request, and puts the headers on every answer.
pub(super) async fn guard(State(service): State<Shared>, request: Request, next: Next) -> Response {
    let asked = RequestLog::of(&request);
    let request = Linger::around(request);
    let path = counted(request.uri().path());
    let response = match check(&service, &request) {
        Err(problem) => problem.into_response(),
        Ok(()) => next.run(request).await,
    };
    let response = protected(response);
    let (status, took) = (response.status().as_u16(), asked.at.elapsed());
    service.metrics.answered(path, status, took);
    asked.log(status, took);
    response
}

fn check(service: &Shared, request: &Request) -> Result<(), Problem> {
    // No page that took the service's name could show its token.
    let names = if service.settings.token.is_some() { Names::Any } else { Names::Loopback };
    check_host(request, names)?;
    if is_open(request.uri().path()) {
        return Ok(());
    }
    check_origin(request)?;
    match &service.settings.token {
        Some(token) => check_token(request.headers(), token),
        None => Ok(()),
    }
}

fn is_open(path: &str) -> bool {
    OPEN.contains(&path) || page::has(path)
}

fn check_token(headers: &HeaderMap, token: &Token) -> Result<(), Problem> {
    let text = |name| headers.get(name).and_then(|value: &HeaderValue| value.to_str().ok());
    // A scheme's letters may be of either case (RFC 9110, 11.1).
    let bearer = text(header::AUTHORIZATION)
        .and_then(|value| value.split_once(' '))
        .filter(|(scheme, _)| scheme.eq_ignore_ascii_case("bearer"))
        .map(|(_, token)| token.trim());
    let cookies = text(header::COOKIE).into_iter().flat_map(|cookies| cookies.split(';'));
    let cookies = cookies.filter_map(|cookie| cookie.trim().strip_prefix(COOKIE)?.strip_prefix('='));
    let mut shown = bearer.into_iter().chain(cookies).peekable();
    let message = match shown.peek() {
        None => {
            "a token is needed: send the header `Authorization: Bearer TOKEN`, with the token of the service's --token-file"
        }
        Some(_) => "this is not the service's token: show the one in its --token-file",
    };
    if shown.any(|shown| token.is(shown)) {
        return Ok(());
    }
    Err(Problem::new(StatusCode::UNAUTHORIZED, "token", message))
}

/// `POST /session`: the page trades the token for a cookie that scripts cannot read, so that
/// pictures load by themselves.
#[utoipa::path(post, path = "/session", tag = tags::OPERATION,
    summary = "Trade the token for a cookie",
    description = "For the page in a browser: the cookie `grasp_token` shows the token from now on. Without `--token-file` nothing is \
        needed, and none is set.",
    responses((status = 204, description = "The cookie is set, where one is needed"), Guarded))]
pub(super) async fn session(State(service): State<Shared>) -> Result<Response, Problem> {
    let Some(token) = &service.settings.token else {
        return Ok(StatusCode::NO_CONTENT.into_response());
    };
    let cookie = format!("{COOKIE}={}; HttpOnly; SameSite=Strict; Path=/", token.reveal());
    let mut cookie = HeaderValue::from_str(&cookie).map_err(|_| Problem::lost())?;
    cookie.set_sensitive(true);
    Ok((StatusCode::NO_CONTENT, [(header::SET_COOKIE, cookie)]).into_response())
}

/// The name under which a path is counted: few, whatever is asked for.
fn counted(path: &str) -> &'static str {
    let other = PATHS.last().copied().unwrap_or_default();
    let is_below =
        |name: &str| path.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'));
    PATHS.into_iter().find(|name| is_below(name)).unwrap_or(other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_shown_by_header_or_cookie_and_no_other_will_do() {
        let token = Token::new("sesame-sesame-16").unwrap();
        let shows = |name: axum::http::HeaderName, value: &str| {
            let mut headers = HeaderMap::new();
            headers.insert(name, HeaderValue::from_str(value).unwrap());
            check_token(&headers, &token).is_ok()
        };
        for scheme in ["Bearer", "bearer", "BEARER", "bEARER"] {
            assert!(shows(header::AUTHORIZATION, &format!("{scheme} sesame-sesame-16")), "{scheme}");
        }
        assert!(shows(header::COOKIE, "a=b; grasp_token=sesame-sesame-16"));
        for (name, value) in [
            (header::AUTHORIZATION, "Bearer sesame-sesame-1"),
            (header::AUTHORIZATION, "Bearer sesame-sesame-167"),
            (header::AUTHORIZATION, "sesame-sesame-16"),
            (header::AUTHORIZATION, "Basic sesame-sesame-16"),
            (header::AUTHORIZATION, "bearersesame-sesame-16"),
            (header::COOKIE, "grasp_token="),
            (header::COOKIE, "xgrasp_token=sesame-sesame-16"),
        ] {
            assert!(!shows(name, value), "{value}");
        }
    }

    #[test]
    fn whatever_is_not_named_is_protected() {
        for path in ["/", "/page.js", "/healthz", "/readyz", "/docs", "/openapi.json"] {
            assert!(is_open(path), "{path}");
        }
        for path in
            ["/v1/index", "/metrics", "/session", "/quiz/", "/new", "//", "/healthz/", "/V1/index", ""]
        {
            assert!(!is_open(path), "{path}");
        }
    }
}
