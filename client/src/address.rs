//! Where a server is, and whether it is one.

use std::io;
use std::pin::Pin;
use std::sync::{Arc, OnceLock};
use std::task::{Context, Poll};
use std::time::Duration;

use baudbot_fields::printable::Printable;
use hyper_util::rt::TokioIo;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpStream, UnixStream, lookup_host};
use tokio::sync::Notify;
use tokio::task::JoinSet;
use tokio::time::timeout;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::pki_types::ServerName;
use tonic::transport::Endpoint;
use tower::service_fn;

use crate::channel::Channel;
use crate::credentials::Credentials;
use crate::error::Error;

/// Connects to the server at `HOST:PORT`, `http://HOST:PORT`, `https://HOST:PORT` or `unix:/PATH`.
pub(crate) async fn connect(address: &str, credentials: &Credentials) -> Result<Channel, Error> {
    connect_within(address, credentials, PATIENCE).await
}

async fn connect_within(
    address: &str,
    credentials: &Credentials,
    patience: Duration,
) -> Result<Channel, Error> {
    let (place, endpoint) = place(address).ok_or_else(|| Error::Address { address: address.to_owned() })?;
    let tls = if place.is_encrypted() { Some(TlsConnector::from(credentials.tls()?)) } else { None };
    let token = credentials.token_for(address)?;
    let heard = Arc::new(Heard::default());
    // Also makes the connections that take the place of one that is lost.
    let connector = service_fn({
        let heard = Arc::clone(&heard);
        move |_| {
            let (place, tls, heard) = (place.clone(), tls.clone(), Arc::clone(&heard));
            async move {
                let pipe = place.open(tls.as_ref()).await?;
                Ok::<_, io::Error>(TokioIo::new(Line { pipe, heard: Some(heard) }))
            }
        }
    });
    let channel = endpoint.connect_timeout(patience).connect_with_connector(connector).await;
    let channel = channel.map_err(|error| Error::connect(address, &error))?;
    // A server tells its settings at once. What does not would leave the first call without an answer.
    let silent = |_| Error::Connect {
        address: address.to_owned(),
        cause: format!("something accepts connections there, but has not answered for {patience:?}"),
    };
    timeout(patience, heard.first.notified()).await.map_err(silent)?;
    if let Some(words) = heard.words.get() {
        return Err(Error::Connect { address: address.to_owned(), cause: words.clone() });
    }
    Ok(Channel::new(channel, token.as_deref()))
}

/// Where a server listens.
#[derive(Clone, Debug)]
enum Place {
    /// `HOST:PORT`.
    Tcp(String),
    /// The same by TLS, with the name that the server's certificate must have.
    Tls(String, ServerName<'static>),
    /// A path.
    Unix(String),
}

impl Place {
    fn is_encrypted(&self) -> bool {
        matches!(self, Self::Tls(..))
    }

    async fn open(&self, tls: Option<&TlsConnector>) -> io::Result<Box<dyn Pipe>> {
        Ok(match (self, tls) {
            (Self::Tls(authority, name), Some(tls)) => {
                Box::new(tls.connect(name.clone(), connect_to_any(authority).await?).await?)
            }
            (Self::Tcp(authority) | Self::Tls(authority, _), _) => Box::new(connect_to_any(authority).await?),
            (Self::Unix(path), _) => Box::new(UnixStream::connect(path).await?),
        })
    }
}

/// Connects to the first of a host's addresses that answers: one at which nobody says anything does not use up the time of the
/// others.
async fn connect_to_any(authority: &str) -> io::Result<TcpStream> {
    let mut addresses = lookup_host(authority).await?;
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

/// A connection for bytes.
trait Pipe: AsyncRead + AsyncWrite + Send + Unpin {}

impl<IO: AsyncRead + AsyncWrite + Send + Unpin> Pipe for IO {}

/// What a server says first.
#[derive(Default)]
struct Heard {
    /// It has said something, or is gone.
    first: Notify,
    /// It speaks HTTP/1, as a server does to those who speak without TLS where it is wanted.
    words: OnceLock<String>,
}

/// A connection that tells when the first bytes have come, or its end.
struct Line {
    pipe: Box<dyn Pipe>,
    /// The recipient.
    heard: Option<Arc<Heard>>,
}

impl AsyncRead for Line {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let before = buffer.filled().len();
        let result = Pin::new(&mut self.pipe).poll_read(context, buffer);
        if result.is_ready()
            && let Some(heard) = self.heard.take()
        {
            if let Some(words) = words_of_http_1(&buffer.filled()[before..]) {
                let _ = heard.words.set(words);
            }
            heard.first.notify_one();
        }
        result
    }
}

impl AsyncWrite for Line {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.pipe).poll_write(context, bytes)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.pipe).poll_write_vectored(context, parts)
    }

    fn is_write_vectored(&self) -> bool {
        self.pipe.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.pipe).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.pipe).poll_shutdown(context)
    }
}

/// What an answer of HTTP/1 says for people, if this is one.
fn words_of_http_1(bytes: &[u8]) -> Option<String> {
    let answer = bytes.starts_with(b"HTTP/1.").then(|| String::from_utf8_lossy(bytes))?;
    let words =
        answer.split_once("\r\n\r\n").map_or("", |(_, words)| words).lines().next().unwrap_or_default();
    Some(if words.is_empty() {
        "what answers there is no gRPC server".to_owned()
    } else {
        Printable(words).to_string()
    })
}

fn place(address: &str) -> Option<(Place, Endpoint)> {
    let (place, uri) = match address.split_once(':')? {
        // The name is never looked up; it has to be some authority.
        ("unix", "") => return None,
        ("unix", path) => (Place::Unix(path.to_owned()), "http://localhost".to_owned()),
        ("http", _) => tcp(address.strip_prefix("http://")?)?,
        ("https", _) => tls(address.strip_prefix("https://")?)?,
        _ => tcp(address)?,
    };
    // A brain that waits for its turn hears nothing for long, and would not notice that nobody is there any more.
    let endpoint =
        Endpoint::from_shared(uri).ok()?.http2_keep_alive_interval(KEEPALIVE).keep_alive_timeout(KEEPALIVE);
    Some((place, endpoint))
}

/// Without a port a URI means port 80, where no world is.
fn tcp(authority: &str) -> Option<(Place, String)> {
    let authority = authority.trim_end_matches('/');
    let (host, port) = authority.rsplit_once(':')?;
    let fits = !host.is_empty() && !host.contains('/') && port.parse::<u16>().is_ok();
    fits.then(|| (Place::Tcp(authority.to_owned()), format!("http://{authority}")))
}

/// The scheme of the URI stays `http`: the connector encrypts, and tonic would else do it once more.
fn tls(authority: &str) -> Option<(Place, String)> {
    let (place, uri) = tcp(authority)?;
    let Place::Tcp(authority) = place else { return None };
    let (host, _) = authority.rsplit_once(':')?;
    let name = ServerName::try_from(host.trim_matches(['[', ']']).to_owned()).ok()?;
    Some((Place::Tls(authority, name), uri))
}

/// How long a server may take to be reached, and then to say the first word.
const PATIENCE: Duration = Duration::from_secs(5);

/// How long a server that says nothing is left in peace, and then how long it has for an answer.
const KEEPALIVE: Duration = Duration::from_secs(20);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses() {
        for good in [
            "127.0.0.1:7400",
            "localhost:7400",
            "[::1]:7400",
            "http://127.0.0.1:7400",
            "http://box:1/",
            "https://box:7400",
            "https://[::1]:7400/",
            "unix:/run/b",
        ] {
            assert!(place(good).is_some(), "{good}");
        }
        for bad in [
            "",
            "7400",
            ":7400",
            "box",
            "box:",
            "box:http",
            "https://box",
            "https://a b:7400",
            "unix:",
            "a b:7400",
            "http://box",
        ] {
            assert!(place(bad).is_none(), "{bad}");
        }
    }

    #[tokio::test]
    async fn a_port_that_takes_connections_and_says_nothing_is_given_up() {
        let silent = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = silent.local_addr().unwrap().to_string();
        let text = connect_within(&address, &Credentials::default(), Duration::from_millis(100))
            .await
            .unwrap_err()
            .to_string();
        let words = "something accepts connections there, but has not answered for 100ms";
        let expected = format!("no server answers at {address} ({words}); is `baudbot serve` running there?");
        assert_eq!(text, expected);
    }

    #[tokio::test]
    async fn a_silent_address_is_named_with_the_fix() {
        // Port 1 needs a privileged server, of which a test machine has none.
        let text = connect("127.0.0.1:1", &Credentials::default()).await.unwrap_err().to_string();
        assert!(text.starts_with("no server answers at 127.0.0.1:1 ("), "{text}");
        assert!(text.ends_with("is `baudbot serve` running there?"), "{text}");
        let text = connect("nowhere", &Credentials::default()).await.unwrap_err().to_string();
        assert!(text.starts_with("`nowhere` is not a server address"), "{text}");
    }
}
