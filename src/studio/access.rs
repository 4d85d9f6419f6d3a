//! Who may ask: a token that only the reader of the terminal knows, and addresses of this machine alone.

use std::fmt::Write;

/// Bytes of a token: 256 bits.
const TOKEN_BYTES: usize = 32;

/// Rules that every request has to keep.
#[derive(Debug)]
pub(super) struct AccessRules {
    token: String,
    port: u16,
}

/// Header fields and address of a request, as far as the rules ask for them.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Credentials<'a> {
    /// Every `Host`.
    pub hosts: &'a [&'a str],
    /// Every `Origin`.
    pub origins: &'a [&'a str],
    /// `X-Morion-Token`.
    pub header: Option<&'a str>,
    /// What follows the question mark of the address.
    pub query: Option<&'a str>,
    /// Whether the address may have the token: a browser that follows a link sends no header of ours.
    pub is_followed: bool,
}

impl AccessRules {
    /// The rules of a server on `port`, with a token of its own; none where the system has no random numbers.
    pub(super) fn new(port: u16) -> Option<Self> {
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes).ok()?;
        let token = bytes.iter().fold(String::new(), |mut text, byte| {
            // (A string takes whatever is written.)
            let _ = write!(text, "{byte:02x}");
            text
        });
        Some(Self { token, port })
    }

    /// The address of the first page.
    pub(super) fn address(&self) -> String {
        format!("http://127.0.0.1:{}/?token={}", self.port, self.token)
    }

    /// Why a request is refused; none if it is not.
    pub(super) fn refusal(&self, asked: &Credentials) -> Option<&'static str> {
        let hosts = [format!("127.0.0.1:{}", self.port), format!("localhost:{}", self.port)];
        let is_here = |host: &str| hosts.iter().any(|here| here == host);
        if !(asked.hosts.len() == 1 && asked.hosts.iter().all(|host| is_here(host))) {
            return Some("the request is for another host");
        }
        let is_ours = |origin: &str| origin.strip_prefix("http://").is_some_and(is_here);
        if !asked.origins.iter().all(|origin| is_ours(origin)) {
            return Some("the request comes from another page");
        }
        let in_query = asked.query.and_then(|query| query.strip_prefix("token="));
        let shown = asked.header.or(in_query.filter(|_| asked.is_followed));
        if !shown.is_some_and(|shown| self.is_token(shown)) {
            return Some(
                "the token is missing or wrong: open the address that `morion studio` printed",
            );
        }
        None
    }

    /// Whether `shown` is the token; the time that it takes does not tell how much of it is right.
    fn is_token(&self, shown: &str) -> bool {
        let (ours, shown) = (self.token.as_bytes(), shown.as_bytes());
        let differs = ours.iter().zip(shown).fold(0, |differs, (a, b)| differs | (a ^ b));
        ours.len() == shown.len() && std::hint::black_box(differs) == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_needs_token_host_and_origin() {
        let rules = AccessRules::new(8080).unwrap();
        let token = rules.token.clone();
        assert_eq!(token.len(), 64);
        assert_ne!(token, AccessRules::new(8080).unwrap().token);
        let query = format!("token={token}");
        let good = Credentials {
            hosts: &["127.0.0.1:8080"],
            origins: &["http://localhost:8080"],
            header: Some(&token),
            ..Credentials::default()
        };
        let page = Credentials { header: None, query: Some(&query), is_followed: true, ..good };
        assert_eq!((rules.refusal(&good), rules.refusal(&page)), (None, None));
        let wrong = "0".repeat(64);
        for bad in [
            Credentials { hosts: &[], ..good },
            Credentials { hosts: &["evil.example:8080"], ..good },
            Credentials { hosts: &["127.0.0.1"], ..good },
            Credentials { hosts: &["127.0.0.1:8080", "127.0.0.1:8080"], ..good },
            Credentials { origins: &["http://evil.example"], ..good },
            Credentials { origins: &["null"], ..good },
            Credentials { origins: &["https://127.0.0.1:8080"], ..good },
            Credentials { header: None, ..good },
            Credentials { header: Some(&token[1..]), ..good },
            Credentials { header: Some(&wrong), ..good },
            Credentials { header: Some(""), ..good },
            Credentials { is_followed: false, ..page },
        ] {
            assert!(rules.refusal(&bad).is_some(), "{bad:?}");
        }
    }
}
