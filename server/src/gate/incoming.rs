//! Connections that are accepted outside of the server.

use std::future::pending;
use std::io;
use std::pin::Pin;

use futures_util::stream::{Stream, StreamExt};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::sync::Mutex;

use super::listener::Accept;
use crate::access::Caller;
use crate::limits::Account;

/// A connection of any kind.
pub(crate) trait Duplex: AsyncRead + AsyncWrite + Unpin + Send {}

impl<IO: AsyncRead + AsyncWrite + Unpin + Send> Duplex for IO {}

/// Connections that are accepted outside of the server. The peers are unknown, and the program that accepts the
/// connections counts them.
pub(crate) struct Incoming(Mutex<Connections>);

type Connections = Pin<Box<dyn Stream<Item = Box<dyn Duplex>> + Send>>;

impl Incoming {
    pub(crate) fn new<IO: Duplex + 'static>(connections: impl Stream<Item = IO> + Send + 'static) -> Self {
        let connections = connections.map(|io| -> Box<dyn Duplex> { Box::new(io) });
        Self(Mutex::new(Box::pin(connections)))
    }
}

impl Accept for Incoming {
    type Io = Box<dyn Duplex>;

    async fn accept(&self) -> io::Result<(Box<dyn Duplex>, Option<Caller>, Account)> {
        match self.0.lock().await.next().await {
            Some(io) => Ok((io, None, Account::Process)),
            // No further ones come; those that are there stay.
            None => pending().await,
        }
    }
}
