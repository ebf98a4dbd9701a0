//! Pipes: connections to the server's own services in memory.

use std::io::{self, IoSlice};
use std::pin::Pin;
use std::task::{Context, Poll};

use hyper_util::rt::TokioIo;
use tokio::io::{AsyncRead, AsyncWrite, DuplexStream, ReadBuf};
use tokio::sync::mpsc;
use tokio_stream::wrappers::UnboundedReceiverStream;
use tonic::transport::server::Connected;
use tonic::transport::{Channel, Endpoint, Error};

use crate::limits::Peer;

/// Bytes in flight through a pipe.
const PIPE_BYTES: usize = 1 << 20;

/// Makes connections. Clones lead to the same server.
#[derive(Clone)]
pub(crate) struct Pipes(mpsc::UnboundedSender<io::Result<PipeEnd>>);

impl Pipes {
    /// A maker of connections, and the server's ends of them.
    pub(crate) fn new() -> (Self, UnboundedReceiverStream<io::Result<PipeEnd>>) {
        let (pipes, incoming) = mpsc::unbounded_channel();
        (Self(pipes), UnboundedReceiverStream::new(incoming))
    }

    /// A new connection, whose calls are from there.
    ///
    /// # Errors
    /// If the server is stopping.
    pub(crate) async fn channel(&self, peer: Peer) -> Result<Channel, Error> {
        let pipes = self.0.clone();
        let connector = tower::service_fn(move |_| {
            let (near, far) = tokio::io::duplex(PIPE_BYTES);
            let sent = pipes.send(Ok(PipeEnd { io: far, peer: peer.clone() }));
            std::future::ready(
                sent.map(|()| TokioIo::new(near))
                    .map_err(|_| io::Error::from(io::ErrorKind::ConnectionRefused)),
            )
        });
        // The name is never looked up; it has to be some authority.
        Endpoint::from_static("http://localhost").connect_with_connector(connector).await
    }
}

/// The server's end of a pipe.
pub(crate) struct PipeEnd {
    io: DuplexStream,
    peer: Peer,
}

impl Connected for PipeEnd {
    type ConnectInfo = Peer;

    fn connect_info(&self) -> Peer {
        self.peer.clone()
    }
}

impl AsyncRead for PipeEnd {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.io).poll_read(context, buffer)
    }
}

impl AsyncWrite for PipeEnd {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.io).poll_write(context, bytes)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        parts: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.io).poll_write_vectored(context, parts)
    }

    fn is_write_vectored(&self) -> bool {
        self.io.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.io).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.io).poll_shutdown(context)
    }
}
