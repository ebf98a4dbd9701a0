//! Which requests may reach the page's server.

use axum::http::{HeaderMap, header};

/// The rules of a listener for its callers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guard {
    /// Whether the listener is on loopback. A name that is not one of loopback's was then made to lead there from outside (DNS
    /// rebinding).
    pub(super) loopback_only: bool,
}

impl Guard {
    /// Checks that the request is for this host.
    pub(super) fn check_host(self, headers: &HeaderMap) -> Result<(), &'static str> {
        let host = text(headers, header::HOST).ok_or("Host: is missing\n")?;
        let name = without_port(host);
        let is_loopback = name.eq_ignore_ascii_case("localhost")
            || name.trim_matches(['[', ']']).parse().is_ok_and(|ip: std::net::IpAddr| ip.is_loopback());
        if self.loopback_only && !is_loopback {
            return Err("Host: must be localhost, 127.0.0.1 or [::1]\n");
        }
        Ok(())
    }

    /// Checks that the page of the request came from here. A request without an origin is not a browser's.
    pub(super) fn check_origin(self, headers: &HeaderMap) -> Result<(), &'static str> {
        let Some(origin) = text(headers, header::ORIGIN) else { return Ok(()) };
        let host = text(headers, header::HOST).unwrap_or_default();
        let asks_for = origin.split_once("://").map(|(_, rest)| rest);
        if asks_for.is_some_and(|asks_for| asks_for.eq_ignore_ascii_case(host)) {
            Ok(())
        } else {
            Err("Origin: only pages that came from this server may open its socket\n")
        }
    }
}

fn text(headers: &HeaderMap, name: header::HeaderName) -> Option<&str> {
    headers.get(name)?.to_str().ok()
}

fn without_port(host: &str) -> &str {
    let end_of_ipv6 = host.rfind(']');
    match host.rfind(':') {
        Some(colon) if end_of_ipv6.is_none_or(|end| colon > end) => &host[..colon],
        _ => host,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(host: &str, origin: Option<&str>) -> HeaderMap {
        let mut headers = HeaderMap::new();
        headers.insert(header::HOST, host.parse().unwrap());
        if let Some(origin) = origin {
            headers.insert(header::ORIGIN, origin.parse().unwrap());
        }
        headers
    }

    #[test]
    fn on_loopback_the_host_is_called_by_its_name() {
        let loopback = Guard { loopback_only: true };
        for host in ["localhost:50052", "127.0.0.1:50052", "[::1]:50052", "LOCALHOST", "127.0.0.1"] {
            assert_eq!(loopback.check_host(&headers(host, None)), Ok(()), "{host}");
        }
        for host in ["evil.example:50052", "localhost.evil.example", "10.0.0.7:1", "127.0.0.1.evil:1", ""] {
            assert!(loopback.check_host(&headers(host, None)).is_err(), "{host}");
        }
        let anywhere = Guard { loopback_only: false };
        assert_eq!(anywhere.check_host(&headers("lab.example:50052", None)), Ok(()));
        assert!(anywhere.check_host(&HeaderMap::new()).is_err());
    }

    #[test]
    fn pages_of_strangers_are_refused() {
        let guard = Guard { loopback_only: true };
        let ok = |host, origin| guard.check_origin(&headers(host, origin)).is_ok();
        assert!(ok("localhost:50052", Some("http://localhost:50052")));
        assert!(ok("localhost:50052", None), "a program");
        assert!(!ok("localhost:50052", Some("http://evil.example")));
        assert!(!ok("localhost:50052", Some("http://localhost:8080")), "another server here");
        assert!(!ok("localhost:50052", Some("null")), "a file, or a frame without rights");
    }
}
