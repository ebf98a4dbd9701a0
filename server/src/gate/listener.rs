//! A listener with its gate.

use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use axum::serve::{IncomingStream, Listener};
use futures_util::stream::{self, Stream};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, UnixListener, UnixStream};

use super::frames::Frames;
use super::tls::{Secured, Tls};
use super::{Admission, Connection, Gate};
use crate::access::Caller;
use crate::clock;
use crate::limits::Account;
use crate::system::is_this_user;

/// The time for which a listener rests that cannot take connections.
const PAUSE: Duration = Duration::from_millis(100);

/// A source of connections.
pub(crate) trait Accept: Send + 'static {
    type Io: AsyncRead + AsyncWrite + Unpin + Send + 'static;

    /// The next connection, with the user at its other end if the system knows it, and the account for which it is
    /// counted.
    fn accept(&self) -> impl Future<Output = io::Result<(Self::Io, Option<Caller>, Account)>> + Send;
}

/// A listener for TCP, with TLS or without.
pub(crate) struct TcpEntry {
    pub(crate) listener: TcpListener,
    pub(crate) tls: Option<Tls>,
}

impl Accept for TcpEntry {
    type Io = Secured;

    async fn accept(&self) -> io::Result<(Secured, Option<Caller>, Account)> {
        let (stream, peer) = self.listener.accept().await?;
        // Small messages wait otherwise for an acknowledgement that the peer delays by 40 ms.
        let _ = stream.set_nodelay(true);
        Ok((Secured::new(stream, self.tls.as_ref()), None, Account::of_address(peer.ip())))
    }
}

impl Accept for UnixListener {
    type Io = UnixStream;

    async fn accept(&self) -> io::Result<(UnixStream, Option<Caller>, Account)> {
        let (stream, _) = Self::accept(self).await?;
        // The user of an unknown peer is none that exists.
        let user = stream.peer_cred().map_or(u32::MAX, |peer| peer.uid());
        let is_own = is_this_user(user);
        Ok((stream, is_own.then_some(Caller::Trusted), Account::User(user)))
    }
}

/// A listener with its gate.
pub(crate) struct GatedListener<L> {
    listener: L,
    gate: Gate,
    /// Whether it is for pages, and not for calls of gRPC.
    is_for_pages: bool,
}

impl<L: Accept> GatedListener<L> {
    pub(crate) fn new(listener: L, gate: Gate) -> Self {
        Self { listener, gate, is_for_pages: false }
    }

    /// One for pages, which speak HTTP/1.1.
    pub(crate) fn for_pages(listener: L, gate: Gate) -> Self {
        Self { listener, gate, is_for_pages: true }
    }

    async fn next(&self) -> Connection<L::Io> {
        loop {
            match self.listener.accept().await {
                Ok((io, caller, account)) => {
                    let frames = (!self.is_for_pages).then(Frames::new);
                    return Connection::new(io, self.gate.admit(caller, &account), frames);
                }
                Err(error) if is_of_one(&error) => {}
                Err(error) => {
                    // Such as too many open files. Connections wait in the kernel meanwhile; accepting again at once is of no use.
                    if let Some(times) = self.gate.0.accept_errors.note(clock::now()) {
                        tracing::warn!(times, %error, "no connection can be accepted");
                    }
                    tokio::time::sleep(PAUSE).await;
                }
            }
        }
    }
}

/// The connections of a listener, one after the other.
pub(crate) fn connections<L: Accept + Sync>(
    listener: GatedListener<L>,
) -> impl Stream<Item = io::Result<Connection<L::Io>>> + Send {
    stream::unfold(listener, |listener| async { Some((Ok(listener.next().await), listener)) })
}

/// Whether this is an error of the connection that was to be taken, and not of the listener.
fn is_of_one(error: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionAborted, ConnectionRefused, ConnectionReset, Interrupted};
    matches!(error.kind(), ConnectionAborted | ConnectionRefused | ConnectionReset | Interrupted)
}

impl Listener for GatedListener<TcpEntry> {
    type Io = Connection<Secured>;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Self::Io, SocketAddr) {
        let connection = self.next().await;
        // The address of a connection that is gone already is not used.
        let address = connection.io().stream().and_then(|stream| stream.peer_addr().ok());
        let address = address.unwrap_or_else(|| SocketAddr::from(([0; 4], 0)));
        (connection, address)
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        self.listener.listener.local_addr()
    }
}

/// The connection that a request of the page came over.
#[derive(Clone)]
pub(crate) struct PageConnection(pub(crate) Arc<Admission>);

impl axum::extract::connect_info::Connected<IncomingStream<'_, GatedListener<TcpEntry>>> for PageConnection {
    fn connect_info(stream: IncomingStream<'_, GatedListener<TcpEntry>>) -> Self {
        Self(stream.io().admission())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;
    use crate::limits::{InForce, Limits};

    /// A process with too many open files.
    struct Exhausted(AtomicU32);

    impl Accept for Exhausted {
        type Io = UnixStream;

        async fn accept(&self) -> io::Result<(UnixStream, Option<Caller>, Account)> {
            self.0.fetch_add(1, Ordering::Relaxed);
            Err(io::Error::other("too many open files"))
        }
    }

    #[tokio::test]
    async fn a_listener_that_cannot_take_connections_rests_between_its_attempts() {
        let gate = Gate::new(InForce::new(Limits::none()), Duration::from_secs(1));
        let entry = GatedListener::new(Exhausted(AtomicU32::new(0)), gate);
        let taken = tokio::time::timeout(PAUSE * 3, entry.next()).await;
        assert!(taken.is_err(), "there is no connection to be taken");
        let attempts = entry.listener.0.load(Ordering::Relaxed);
        assert!((1..=4).contains(&attempts), "{attempts} attempts in three pauses");
    }
}
