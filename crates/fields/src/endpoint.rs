//! The place at which programs find a serial port: `pty:khepera.tty`, `tcp:10940`. Command lines and scenarios have
//! the same grammar.

use alloc::borrow::ToOwned;
use alloc::string::String;
use core::fmt;
use core::net::{Ipv4Addr, SocketAddr};
use core::str::FromStr;

use thiserror::Error;

use crate::printable::Printable;

/// The place at which programs find a serial port. Paths are relative to the folder of the program that opens it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Endpoint {
    /// A pseudo-terminal, of which this path is a symbolic link.
    Pty(String),
    /// A TCP socket that has the bytes and nothing else.
    Tcp(SocketAddr),
    /// A TCP socket that speaks RFC 2217, by which a program sets baud rate and lines.
    Rfc2217(SocketAddr),
    /// A Unix socket, mode 0600, that has the bytes and nothing else.
    Unix(String),
}

/// A text that is no endpoint.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum BadEndpoint {
    /// The text has no `:`.
    #[error(
        "`{}` is not a serial port; write pty:NAME, tcp:ADDRESS, rfc2217:ADDRESS or unix:PATH",
        Printable(.text)
    )]
    Form {
        /// The text.
        text: String,
    },
    /// The kind is not known.
    #[error("`{}` is not a kind of port; there are pty, tcp, rfc2217 and unix", Printable(.kind))]
    Kind {
        /// The word in that place.
        kind: String,
    },
    /// No address.
    #[error(
        "`{}` is not an address; write a port's number, for this machine only, or HOST:PORT with a numeric host",
        Printable(.address)
    )]
    Address {
        /// The address that was given.
        address: String,
    },
    /// No path.
    #[error("a {kind} needs a path, e.g. {kind}:khepera.tty")]
    NoPath {
        /// The kind of port.
        kind: &'static str,
    },
}

impl Endpoint {
    /// Whether only this machine can reach it.
    pub fn is_local(&self) -> bool {
        match self {
            Self::Pty(_) | Self::Unix(_) => true,
            Self::Tcp(address) | Self::Rfc2217(address) => address.ip().is_loopback(),
        }
    }
}

impl FromStr for Endpoint {
    type Err = BadEndpoint;

    fn from_str(text: &str) -> Result<Self, BadEndpoint> {
        let Some((kind, place)) = text.split_once(':') else {
            return Err(BadEndpoint::Form { text: text.to_owned() });
        };
        let path = |kind| {
            let path = Some(place).filter(|place| !place.is_empty());
            path.map(ToOwned::to_owned).ok_or(BadEndpoint::NoPath { kind })
        };
        match kind {
            "pty" => path("pty").map(Self::Pty),
            "unix" => path("unix").map(Self::Unix),
            "tcp" => socket(place).map(Self::Tcp),
            "rfc2217" => socket(place).map(Self::Rfc2217),
            _ => Err(BadEndpoint::Kind { kind: kind.to_owned() }),
        }
    }
}

/// `HOST:PORT`, or a port of this machine.
fn socket(text: &str) -> Result<SocketAddr, BadEndpoint> {
    let numeric = text.trim_start_matches("//").replace("localhost:", "127.0.0.1:");
    let own = || numeric.parse::<u16>().ok().map(|port| SocketAddr::from((Ipv4Addr::LOCALHOST, port)));
    let address = numeric.parse().ok().or_else(own);
    address.ok_or_else(|| BadEndpoint::Address { address: text.to_owned() })
}

impl fmt::Display for Endpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pty(path) => write!(f, "pty:{}", Printable(path)),
            Self::Tcp(address) => write!(f, "tcp:{address}"),
            Self::Rfc2217(address) => write!(f, "rfc2217:{address}"),
            Self::Unix(path) => write!(f, "unix:{}", Printable(path)),
        }
    }
}

#[cfg(test)]
mod tests {
    use alloc::string::ToString;

    use super::*;

    #[test]
    fn endpoints_are_read_as_the_documents_write_them() {
        let read = |text: &str| text.parse::<Endpoint>();
        let local = |port| SocketAddr::from((Ipv4Addr::LOCALHOST, port));
        assert_eq!(read("pty:a.tty"), Ok(Endpoint::Pty("a.tty".to_owned())));
        assert_eq!(read("tcp:10940"), Ok(Endpoint::Tcp(local(10_940))));
        assert_eq!(read("rfc2217:localhost:2217"), Ok(Endpoint::Rfc2217(local(2217))));
        assert_eq!(read("unix:/tmp/a b").unwrap().to_string(), "unix:/tmp/a b");
        assert!(!read("tcp:0.0.0.0:1").unwrap().is_local() && read("tcp:[::1]:1").unwrap().is_local());
    }

    #[test]
    fn a_text_that_is_none_is_told_what_one_is() {
        let error = |text: &str| text.parse::<Endpoint>().unwrap_err().to_string();
        assert!(error("khepera").starts_with("`khepera` is not a serial port; write pty:NAME"));
        assert_eq!(error("com:3"), "`com` is not a kind of port; there are pty, tcp, rfc2217 and unix");
        assert!(error("tcp:host:1").starts_with("`host:1` is not an address"));
        assert_eq!(error("pty:"), "a pty needs a path, e.g. pty:khepera.tty");
    }
}
