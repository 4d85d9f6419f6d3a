//! The server: it listens on this machine alone, lets requests in, and sends answers back.

use super::access::{AccessRules, Credentials};
use super::failure::RequestFailure;
use super::message::{Asked, Content};
use super::routes::Studio;
use oxhttp::model::header::{HOST, HeaderMap, ORIGIN};
use oxhttp::model::{Body, HeaderValue, Request, Response, StatusCode};
use oxhttp::{ListeningServer, Server};
use std::io::{self, ErrorKind, Read};
use std::net::{Ipv4Addr, TcpListener};
use std::sync::Arc;
use std::time::Duration;

/// Largest body of a request, bytes: a profile has some thousands.
const MOST_BYTES: u64 = 1_000_000;
/// Connections at a time: a browser has six.
const MOST_CONNECTIONS: usize = 64;
/// How long a request may stand still.
const PATIENCE: Duration = Duration::from_secs(30);
/// Ports that are tried before giving up: between looking and listening another program may take one.
const TRIES: usize = 8;

/// Fields of every answer.
const FIELDS: [(&str, &str); 8] = [
    ("Cache-Control", "no-store"),
    ("Connection", "close"),
    ("Cross-Origin-Opener-Policy", "same-origin"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    ("Referrer-Policy", "no-referrer"),
    ("X-Content-Type-Options", "nosniff"),
    ("X-Frame-Options", "DENY"),
    ("Vary", "Origin"),
];
/// What a report of a build may do: its own scripts and styles, nothing from elsewhere, and nothing with this server.
const OF_REPORTS: &str = "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; \
                          style-src 'unsafe-inline'; img-src data: blob:";

/// Starts to listen on `port`, or on a free one for 0, and returns the address of the first page.
///
/// # Errors
/// Those of the system, and of its random numbers.
pub(super) fn listen(studio: Arc<Studio>, port: u16) -> io::Result<(ListeningServer, String)> {
    let mut tries = if port == 0 { TRIES } else { 1 };
    loop {
        tries -= 1;
        // What is listened on is told by this listener alone.
        let probe = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let found = probe.local_addr()?.port();
        drop(probe);
        let rules = AccessRules::new(found).ok_or_else(|| io::Error::other("no random numbers"))?;
        let address = rules.address();
        let studio = Arc::clone(&studio);
        let server = Server::new(move |request| respond(&studio, &rules, request))
            .with_global_timeout(PATIENCE)
            .with_max_concurrent_connections(MOST_CONNECTIONS)
            .bind((Ipv4Addr::LOCALHOST, found));
        match server.spawn() {
            Err(error) if error.kind() == ErrorKind::AddrInUse && tries > 0 => {}
            listening => return Ok((listening?, address)),
        }
    }
}

fn respond(studio: &Studio, rules: &AccessRules, request: &mut Request<Body>) -> Response<Body> {
    let content = body_of(rules, request).and_then(|body| {
        let (method, path) = (request.method().as_str(), request.uri().path());
        studio.answer(&Asked { method, path, body: &body })
    });
    let (status, kind, policy, body) = match content {
        Ok(Content::Page { html, nonce }) => (200, "text/html", of_page(&nonce), html.into()),
        Ok(Content::Json(json)) => (200, "application/json", none(), json.to_string().into()),
        Ok(Content::Png(bytes)) => (200, "image/png", none(), bytes.into()),
        Ok(Content::File(name, file)) => {
            (200, kind_of(&name), OF_REPORTS.to_owned(), Body::from_read(file))
        }
        Err(failure) => {
            (failure.status, "application/json", none(), failure.json().to_string().into())
        }
    };
    let mut response = Response::new(body);
    *response.status_mut() = StatusCode::from_u16(status).unwrap_or_default();
    let charset = if kind.starts_with("text/") { "; charset=utf-8" } else { "" };
    let own = [("Content-Security-Policy", policy), ("Content-Type", format!("{kind}{charset}"))];
    let fields = FIELDS.into_iter().map(|(name, value)| (name, value.to_owned())).chain(own);
    for (name, value) in fields {
        if let (Ok(name), Ok(value)) = (name.parse(), HeaderValue::from_str(&value)) {
            let _: Option<HeaderValue> =
                response.headers_mut().insert::<oxhttp::model::HeaderName>(name, value);
        }
    }
    response
}

/// The body of a request that keeps the rules.
fn body_of(rules: &AccessRules, request: &mut Request<Body>) -> Result<Vec<u8>, RequestFailure> {
    let all = |name| fields(request.headers(), name);
    let (hosts, origins) = (all(HOST.as_str()), all(ORIGIN.as_str()));
    let (Some(hosts), Some(origins)) = (hosts, origins) else {
        return Err(RequestFailure::said(403, "the request has fields that are no text"));
    };
    let path = request.uri().path();
    let credentials = Credentials {
        hosts: &hosts,
        origins: &origins,
        header: request.headers().get("X-Morion-Token").and_then(|token| token.to_str().ok()),
        query: request.uri().query(),
        is_followed: request.method() == "GET" && (path == "/" || path.starts_with("/files/")),
    };
    if let Some(refusal) = rules.refusal(&credentials) {
        return Err(RequestFailure::said(403, refusal));
    }
    let mut body = Vec::new();
    request.body_mut().take(MOST_BYTES + 1).read_to_end(&mut body)?;
    if body.len() as u64 > MOST_BYTES {
        let sentence = format!("the body must have at most {MOST_BYTES} bytes");
        return Err(RequestFailure::said(413, sentence));
    }
    Ok(body)
}

/// Every field of a name; none where one is no text.
fn fields<'a>(headers: &'a HeaderMap, name: &str) -> Option<Vec<&'a str>> {
    headers.get_all(name).iter().map(|value| value.to_str().ok()).collect()
}

/// What the page may do: its own scripts and styles, pictures that it holds itself, and requests to this server.
fn of_page(nonce: &str) -> String {
    format!(
        "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; img-src data: blob:; \
         connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )
}

fn none() -> String {
    "default-src 'none'; frame-ancestors 'none'".to_owned()
}

/// The kind of a file, by the ending of its name.
fn kind_of(name: &str) -> &'static str {
    match name.rsplit_once('.') {
        Some((_, "html")) => "text/html",
        Some((_, "png")) => "image/png",
        Some((_, "svg")) => "image/svg+xml",
        Some((_, "json")) => "application/json",
        Some((_, "csv")) => "text/csv",
        _ => "application/octet-stream",
    }
}
