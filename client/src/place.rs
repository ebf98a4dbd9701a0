//! The place at which a server listens: an address, and a connection to it.

use std::io;
use std::net::IpAddr;
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpStream, UnixStream, lookup_host};
use tokio::task::JoinSet;
use tokio::time::timeout;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::pki_types::ServerName;

/// The place at which a server listens.
#[derive(Clone, Debug)]
pub(crate) enum Place {
    /// `HOST:PORT`.
    Tcp(String),
    /// The same by TLS, with the name that the server's certificate must have.
    Tls(String, ServerName<'static>),
    /// A path.
    Unix(String),
}

/// A connection for bytes.
pub(crate) trait Pipe: AsyncRead + AsyncWrite + Send + Unpin {}

impl<IO: AsyncRead + AsyncWrite + Send + Unpin> Pipe for IO {}

impl Place {
    /// The place of an address, if it is one.
    pub(crate) fn of(address: &str) -> Option<Self> {
        match address.split_once(':')? {
            ("unix", "") => None,
            ("unix", path) => Some(Self::Unix(path.to_owned())),
            ("http", _) => Some(Self::Tcp(authority(address.strip_prefix("http://")?)?.to_owned())),
            ("https", _) => {
                let authority = authority(address.strip_prefix("https://")?)?;
                let name = host(authority).trim_matches(['[', ']']).to_owned();
                Some(Self::Tls(authority.to_owned(), ServerName::try_from(name).ok()?))
            }
            _ => Some(Self::Tcp(authority(address)?.to_owned())),
        }
    }

    /// A URI for it. The scheme is always `http`: connections are encrypted already, and tonic would else do it once more.
    pub(crate) fn uri(&self) -> String {
        match self {
            Self::Tcp(authority) | Self::Tls(authority, _) => format!("http://{authority}"),
            // The name is never looked up; it has to be some authority.
            Self::Unix(_) => "http://localhost".to_owned(),
        }
    }

    pub(crate) fn is_encrypted(&self) -> bool {
        matches!(self, Self::Tls(..))
    }

    /// `HOST:PORT`, if others can read on the way what is sent there.
    pub(crate) fn unprotected(&self) -> Option<&str> {
        match self {
            Self::Tcp(authority) => Some(authority.as_str()).filter(|_| !is_of_this_machine(host(authority))),
            Self::Tls(..) | Self::Unix(_) => None,
        }
    }

    pub(crate) async fn open(&self, tls: Option<&TlsConnector>) -> io::Result<Box<dyn Pipe>> {
        Ok(match (self, tls) {
            (Self::Tls(authority, name), Some(tls)) => {
                Box::new(tls.connect(name.clone(), connect_to_any(authority).await?).await?)
            }
            (Self::Tcp(authority) | Self::Tls(authority, _), _) => Box::new(connect_to_any(authority).await?),
            (Self::Unix(path), _) => Box::new(UnixStream::connect(path).await?),
        })
    }
}

/// `HOST:PORT`. Without a port a URI means port 80, where no world is.
fn authority(text: &str) -> Option<&str> {
    let authority = text.trim_end_matches('/');
    let (host, port) = authority.rsplit_once(':')?;
    let fits = !host.is_empty() && !host.contains('/') && port.parse::<u16>().is_ok();
    fits.then_some(authority)
}

fn host(authority: &str) -> &str {
    authority.rsplit_once(':').map_or(authority, |(host, _)| host)
}

/// Whether what is sent to this host does not leave the machine. A connection to the unspecified address does not, either.
fn is_of_this_machine(host: &str) -> bool {
    let ip = host.trim_matches(['[', ']']).parse::<IpAddr>().map(|ip| ip.to_canonical());
    is_localhost(host) || ip.is_ok_and(|ip| ip.is_loopback() || ip.is_unspecified())
}

/// Whether it is `localhost` or a name within that, all of which mean this machine (RFC 6761).
fn is_localhost(host: &str) -> bool {
    let name = host.strip_suffix('.').unwrap_or(host);
    name.rsplit_once('.').map_or(name, |(_, last)| last).eq_ignore_ascii_case("localhost")
}

/// Connects to the first of a host's addresses that answers: a silent one does not use up the time of the others.
async fn connect_to_any(authority: &str) -> io::Result<TcpStream> {
    // A resolver of names does not choose the destination of tokens that are not encrypted.
    let is_localhost = is_localhost(host(authority));
    let fits = |ip: IpAddr| !is_localhost || ip.is_loopback();
    let mut addresses = lookup_host(authority).await?.filter(|address| fits(address.ip()));
    let mut tries = JoinSet::new();
    let mut failed = io::Error::new(io::ErrorKind::NotFound, "the host has no address");
    loop {
        match addresses.next() {
            Some(address) => drop(tries.spawn(TcpStream::connect(address))),
            None if tries.is_empty() => return Err(failed),
            None => {}
        }
        match timeout(HEAD_START, tries.join_next()).await {
            Ok(Some(Ok(Ok(stream)))) => {
                // A step is a small message that must go at once: waiting for more to send along would cost 40 ms.
                stream.set_nodelay(true)?;
                return Ok(stream);
            }
            Ok(Some(Ok(Err(error)))) => failed = error,
            Ok(Some(Err(error))) => failed = io::Error::other(error),
            Ok(None) | Err(_) => {}
        }
    }
}

/// So long an address is tried before the next one is, too.
const HEAD_START: Duration = Duration::from_millis(250);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_sent_to_another_machine_is_protected_by_tls_only() {
        for (address, authority) in [
            ("10.99.0.2:7400", "10.99.0.2:7400"),
            ("http://10.99.0.2:7400/", "10.99.0.2:7400"),
            ("robots.lab:7400", "robots.lab:7400"),
            ("[2001:db8::7]:7400", "[2001:db8::7]:7400"),
            ("localhost.lab:7400", "localhost.lab:7400"),
            ("notlocalhost:7400", "notlocalhost:7400"),
            ("127.0.0.1:80@robots.lab:7400", "127.0.0.1:80@robots.lab:7400"),
        ] {
            assert_eq!(Place::of(address).unwrap().unprotected(), Some(authority), "{address}");
        }
        for address in [
            "127.0.0.1:7400",
            "http://127.8.9.10:7400",
            "localhost:7400",
            "LOCALHOST.:7400",
            "robots.localhost:7400",
            "[::1]:7400",
            "[::ffff:127.0.0.1]:7400",
            "0.0.0.0:7400",
            "[::]:7400",
            "unix:/run/b",
            "https://10.99.0.2:7400",
        ] {
            assert_eq!(Place::of(address).unwrap().unprotected(), None, "{address}");
        }
    }
}
