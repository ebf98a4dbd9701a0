//! The address of the viewer, a page for browsers.

use std::net::SocketAddr;
use std::str::FromStr;

use baudbot_server::{Address, Builder, Server};

/// The place of the page for `--viewer`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Viewer {
    /// The page is not served.
    Off,
    /// The page is served at this address.
    At(SocketAddr),
}

/// A text that is no place for the page.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is neither an IP:PORT such as 127.0.0.1:7401 nor `off`")]
pub(crate) struct BadViewer(String);

impl FromStr for Viewer {
    type Err = BadViewer;

    fn from_str(text: &str) -> Result<Self, BadViewer> {
        if text == "off" {
            return Ok(Self::Off);
        }
        match text.trim_end_matches('/').parse() {
            Ok(Address::Tcp(address)) => Ok(Self::At(address)),
            Ok(Address::Unix(_)) | Err(_) => Err(BadViewer(text.to_owned())),
        }
    }
}

/// Adds the viewer to a server. By default it is at the usual port, or at a free one if that is taken.
pub(crate) fn add(builder: Builder, asked: Option<Viewer>, usually: bool) -> Builder {
    match asked {
        Some(Viewer::At(address)) => builder.viewer(address),
        None if usually => builder.viewer_or_free_port(USUAL),
        None | Some(Viewer::Off) => builder,
    }
}

/// A line that leads people there; none if there is no viewer.
pub(crate) fn link(server: &Server) -> Option<String> {
    server.viewer_links().first().map(|link| format!("open in a browser: {link}"))
}

/// The usual address of the page, beside the one of servers.
const USUAL: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(std::net::Ipv4Addr::LOCALHOST), 7401);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_read() {
        let at = |text: &str| Viewer::At(text.parse().unwrap());
        assert_eq!("off".parse(), Ok(Viewer::Off));
        for text in ["127.0.0.1:80", "localhost:80", "http://localhost:80/"] {
            assert_eq!(text.parse(), Ok(at("127.0.0.1:80")));
        }
        let problem = "7401".parse::<Viewer>().unwrap_err();
        assert_eq!(problem.to_string(), "`7401` is neither an IP:PORT such as 127.0.0.1:7401 nor `off`");
    }
}
