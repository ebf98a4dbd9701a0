//! The requests that may reach the page's server.

use std::net::IpAddr;
use std::sync::Arc;

use axum::http::{HeaderMap, header};

use crate::gate::TcpEntry;

/// A request that is for no host of this server. The text is the body of the answer.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum HostError {
    #[error("Host: is missing\n")]
    Missing,
    #[error(
        "Host: must be localhost, 127.0.0.1, [::1]{}; if the server is to have another name, start it with --host NAME\n",
        own.iter().map(|own| format!(", {own}")).collect::<String>()
    )]
    Other { own: Arc<[String]> },
}

/// The rules of a listener for its callers.
#[derive(Clone, Debug)]
pub(crate) struct Guard {
    /// Names and addresses by which it is reached besides those of loopback. A request for any other was made by a name
    /// that an attacker made lead here (DNS rebinding).
    hosts: Arc<[String]>,
    /// Whether it is reached by TLS.
    secure: bool,
}

impl Guard {
    /// The guard of a listener with these names.
    pub(crate) fn new(entry: &TcpEntry, names: &[String], behind_proxy: bool) -> Self {
        let own = entry.listener.local_addr().ok().map(|address| address.ip());
        let own = own.filter(|ip| !ip.is_loopback() && !ip.is_unspecified()).map(|ip| ip.to_string());
        Self {
            hosts: names.iter().cloned().chain(own).collect(),
            secure: behind_proxy || entry.tls.is_some(),
        }
    }

    /// Whether it is reached by TLS.
    pub(super) fn is_secure(&self) -> bool {
        self.secure
    }

    /// Checks that the request is for this host.
    pub(super) fn check_host(&self, headers: &HeaderMap) -> Result<(), HostError> {
        let host = text(headers, header::HOST).ok_or(HostError::Missing)?;
        let name = without_port(host).trim_matches(['[', ']']);
        let is_loopback =
            name.eq_ignore_ascii_case("localhost") || name.parse().is_ok_and(|ip: IpAddr| ip.is_loopback());
        if is_loopback || self.hosts.iter().any(|own| own.eq_ignore_ascii_case(name)) {
            return Ok(());
        }
        Err(HostError::Other { own: Arc::clone(&self.hosts) })
    }

    /// Checks that the page of the request came from here. A request without an origin is not a browser's.
    pub(super) fn check_origin(&self, headers: &HeaderMap) -> Result<(), &'static str> {
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

    fn guard(hosts: &[&str]) -> Guard {
        Guard { hosts: hosts.iter().map(|&host| host.to_owned()).collect(), secure: false }
    }

    #[test]
    fn the_host_is_called_by_its_name() {
        for host in ["localhost:50052", "127.0.0.1:50052", "[::1]:50052", "LOCALHOST", "127.0.0.1"] {
            assert_eq!(guard(&[]).check_host(&headers(host, None)), Ok(()), "{host}");
        }
        for host in ["evil.example:50052", "localhost.evil.example", "10.0.0.7:1", "127.0.0.1.evil:1", ""] {
            assert!(guard(&[]).check_host(&headers(host, None)).is_err(), "{host}");
            assert!(guard(&["lab.example"]).check_host(&headers(host, None)).is_err(), "{host}");
        }
        let lab = guard(&["lab.example", "10.0.0.7", "fe80::7"]);
        for host in ["lab.example:50052", "Lab.Example", "10.0.0.7:1", "[fe80::7]:80", "localhost:1"] {
            assert_eq!(lab.check_host(&headers(host, None)), Ok(()), "{host}");
        }
        assert!(lab.check_host(&HeaderMap::new()).is_err());
    }

    #[test]
    fn pages_of_strangers_are_refused() {
        let ok = |host, origin| guard(&[]).check_origin(&headers(host, origin)).is_ok();
        assert!(ok("localhost:50052", Some("http://localhost:50052")));
        assert!(ok("localhost:50052", None), "a program");
        assert!(!ok("localhost:50052", Some("http://evil.example")));
        assert!(!ok("localhost:50052", Some("http://localhost:8080")), "another server here");
        assert!(!ok("localhost:50052", Some("null")), "a file, or a frame without rights");
    }
}
