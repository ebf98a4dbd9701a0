//! A listener, behind which the gate stands.

use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::serve::{IncomingStream, Listener};
use futures_util::stream::{self, Stream};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream, UnixListener, UnixStream};

use super::{Gate, Guest, Visit};

/// Where connections come from.
pub(crate) trait Accept: Send + 'static {
    type Io: AsyncRead + AsyncWrite + Unpin + Send + 'static;

    fn accept(&self) -> impl Future<Output = io::Result<Self::Io>> + Send;
}

impl Accept for TcpListener {
    type Io = TcpStream;

    async fn accept(&self) -> io::Result<TcpStream> {
        let (stream, _) = Self::accept(self).await?;
        // Without this, small messages wait for an acknowledgement that the peer delays by 40 ms.
        let _ = stream.set_nodelay(true);
        Ok(stream)
    }
}

impl Accept for UnixListener {
    type Io = UnixStream;

    async fn accept(&self) -> io::Result<UnixStream> {
        Ok(Self::accept(self).await?.0)
    }
}

/// A listener with its gate.
pub(crate) struct Entry<L> {
    listener: L,
    gate: Gate,
}

impl<L: Accept> Entry<L> {
    pub(crate) fn new(listener: L, gate: Gate) -> Self {
        Self { listener, gate }
    }

    async fn next(&self) -> Guest<L::Io> {
        loop {
            match self.listener.accept().await {
                Ok(io) => return Guest::new(io, self.gate.admit()),
                Err(error) if is_of_one(&error) => {}
                Err(error) => {
                    // Such as too many open files: whoever waits goes on waiting, and asking again at once is of no use.
                    if let Some(times) = self.gate.0.trouble.note(Instant::now()) {
                        tracing::warn!(times, %error, "no connection can be taken");
                    }
                    tokio::time::sleep(PAUSE).await;
                }
            }
        }
    }
}

/// Those who come in, one after the other.
pub(crate) fn guests<L: Accept + Sync>(
    entry: Entry<L>,
) -> impl Stream<Item = io::Result<Guest<L::Io>>> + Send {
    stream::unfold(entry, |entry| async { Some((Ok(entry.next().await), entry)) })
}

/// An error of the connection that was to be taken, and not of the listener.
fn is_of_one(error: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionAborted, ConnectionRefused, ConnectionReset, Interrupted};
    matches!(error.kind(), ConnectionAborted | ConnectionRefused | ConnectionReset | Interrupted)
}

impl Listener for Entry<TcpListener> {
    type Io = Guest<TcpStream>;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Self::Io, SocketAddr) {
        let guest = self.next().await;
        // Of one that is gone already nobody asks.
        let address = guest.io().peer_addr().unwrap_or_else(|_| SocketAddr::from(([0; 4], 0)));
        (guest, address)
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }
}

/// The connection that a request of the page came over.
#[derive(Clone)]
pub(crate) struct Visitor(pub(crate) Arc<Visit>);

impl axum::extract::connect_info::Connected<IncomingStream<'_, Entry<TcpListener>>> for Visitor {
    fn connect_info(stream: IncomingStream<'_, Entry<TcpListener>>) -> Self {
        Self(stream.io().visit())
    }
}

/// How long a listener rests that cannot take connections.
const PAUSE: Duration = Duration::from_millis(100);

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;

    /// A process with too many open files.
    struct Exhausted(AtomicU32);

    impl Accept for Exhausted {
        type Io = UnixStream;

        async fn accept(&self) -> io::Result<UnixStream> {
            self.0.fetch_add(1, Ordering::Relaxed);
            Err(io::Error::other("too many open files"))
        }
    }

    #[tokio::test]
    async fn a_listener_that_cannot_take_connections_rests_between_its_attempts() {
        let entry = Entry::new(Exhausted(AtomicU32::new(0)), Gate::new(1, Duration::from_secs(1)));
        let taken = tokio::time::timeout(PAUSE * 3, entry.next()).await;
        assert!(taken.is_err(), "there is nobody to be taken");
        let attempts = entry.listener.0.load(Ordering::Relaxed);
        assert!((1..=4).contains(&attempts), "{attempts} attempts in three pauses");
    }
}
