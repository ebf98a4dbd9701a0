//! Where a port is: a pseudo-terminal, a socket, or a terminal server.

use std::fmt;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::str::FromStr;

use thiserror::Error;

/// A port that is to be opened: `ROBOT[/DEVICE]=KIND:WHERE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortAddress {
    /// Name of the robot; none if there is only one.
    pub robot: Option<String>,
    /// The sensor whose own cable it is; none for the microcontroller's.
    pub device: Option<String>,
    /// Where it is.
    pub place: Place,
}

/// Where programs find a port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// A pseudo-terminal, of which this path is a symbolic link.
    Pty(PathBuf),
    /// A TCP socket that has the bytes and nothing else.
    Tcp(SocketAddr),
    /// A TCP socket that speaks RFC 2217, by which a program sets baud rate and lines.
    Rfc2217(SocketAddr),
    /// A Unix socket, mode 0600, that has the bytes and nothing else.
    Unix(PathBuf),
}

/// A text that is no port.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum BadPort {
    /// It has no `=`, or nothing before a `:`.
    #[error(
        "`{text}` is no port; write ROBOT=pty:NAME, tcp:ADDRESS, rfc2217:ADDRESS or unix:PATH, e.g. khepera=pty:khepera.tty"
    )]
    Form {
        /// The text.
        text: String,
    },
    /// The kind is not known.
    #[error("`{kind}` is no kind of port; there are pty, tcp, rfc2217 and unix")]
    Kind {
        /// What stands there.
        kind: String,
    },
    /// No address.
    #[error(
        "`{address}` is no address; write a port's number, for this machine only, or HOST:PORT with a numeric host"
    )]
    Address {
        /// What stands there.
        address: String,
    },
    /// No path.
    #[error("a {kind} needs a path, e.g. {kind}:khepera.tty")]
    NoPath {
        /// The kind of port.
        kind: &'static str,
    },
}

impl Place {
    /// Whether only this machine can reach it.
    pub fn is_local(&self) -> bool {
        match self {
            Self::Pty(_) | Self::Unix(_) => true,
            Self::Tcp(address) | Self::Rfc2217(address) => address.ip().is_loopback(),
        }
    }
}

impl FromStr for PortAddress {
    type Err = BadPort;

    fn from_str(text: &str) -> Result<Self, BadPort> {
        let form = || BadPort::Form { text: text.to_owned() };
        let (who, place) = match text.split_once('=') {
            Some((who, place)) if !who.is_empty() => (Some(who), place),
            Some(_) => return Err(form()),
            None => (None, text),
        };
        let (robot, device) = match who.map(|who| who.split_once('/').ok_or(who)) {
            None => (None, None),
            Some(Err(robot)) => (Some(robot.to_owned()), None),
            Some(Ok((robot, device))) => {
                (Some(robot.to_owned()).filter(|name| !name.is_empty()), Some(device.to_owned()))
            }
        };
        if device.as_ref().is_some_and(String::is_empty) {
            return Err(form());
        }
        Ok(Self { robot, device, place: place.parse()? })
    }
}

impl FromStr for Place {
    type Err = BadPort;

    fn from_str(text: &str) -> Result<Self, BadPort> {
        let Some((kind, place)) = text.split_once(':') else {
            return Err(BadPort::Form { text: text.to_owned() });
        };
        let path = |kind| {
            let path = Some(place).filter(|place| !place.is_empty()).ok_or(BadPort::NoPath { kind })?;
            Ok(PathBuf::from(path))
        };
        match kind {
            "pty" => Ok(Self::Pty(path("pty")?)),
            "unix" => Ok(Self::Unix(path("unix")?)),
            "tcp" => Ok(Self::Tcp(socket(place)?)),
            "rfc2217" => Ok(Self::Rfc2217(socket(place)?)),
            _ => Err(BadPort::Kind { kind: kind.to_owned() }),
        }
    }
}

/// `HOST:PORT`, or a port of this machine.
fn socket(text: &str) -> Result<SocketAddr, BadPort> {
    let numeric = text.trim_start_matches("//").replace("localhost:", "127.0.0.1:");
    let own = || numeric.parse::<u16>().ok().map(|port| SocketAddr::from(([127, 0, 0, 1], port)));
    let address = numeric.parse().ok().or_else(own);
    address.ok_or_else(|| BadPort::Address { address: text.to_owned() })
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pty(path) => write!(f, "pty:{}", path.display()),
            Self::Tcp(address) => write!(f, "tcp:{address}"),
            Self::Rfc2217(address) => write!(f, "rfc2217:{address}"),
            Self::Unix(path) => write!(f, "unix:{}", path.display()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ports_are_read_as_the_documents_write_them() {
        let port = |text: &str| text.parse::<PortAddress>();
        let local = |port| SocketAddr::from(([127, 0, 0, 1], port));
        let urg = port("khepera/urg=tcp:10940").unwrap();
        assert_eq!((urg.robot.as_deref(), urg.device.as_deref()), (Some("khepera"), Some("urg")));
        assert_eq!(urg.place, Place::Tcp(local(10_940)));
        assert_eq!(port("pty:a.tty").unwrap().robot, None);
        assert_eq!(port("/gps=pty:a.tty").unwrap().device.as_deref(), Some("gps"));
        assert_eq!(port("c=rfc2217:localhost:2217").unwrap().place, Place::Rfc2217(local(2217)));
        assert_eq!(port("c=unix:/tmp/a b").unwrap().place.to_string(), "unix:/tmp/a b");
        assert!(!port("c=tcp:0.0.0.0:1").unwrap().place.is_local());
        let error = |text: &str| port(text).unwrap_err().to_string();
        assert!(error("khepera").contains("is no port; write ROBOT=pty:NAME"));
        assert!(error("=pty:x").contains("is no port") && error("k/=pty:x").contains("is no port"));
        assert_eq!(error("k=com:3"), "`com` is no kind of port; there are pty, tcp, rfc2217 and unix");
        assert!(error("k=tcp:host:1").contains("`host:1` is no address"));
        assert_eq!(error("k=pty:"), "a pty needs a path, e.g. pty:khepera.tty");
    }
}
