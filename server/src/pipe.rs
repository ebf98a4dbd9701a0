//! Pipes: connections to the server's own services in memory.

use std::io;

use hyper_util::rt::TokioIo;
use tokio::io::DuplexStream;
use tokio::sync::mpsc;
use tokio_stream::wrappers::UnboundedReceiverStream;
use tonic::transport::{Channel, Endpoint, Error};

/// Bytes in flight through a pipe.
const PIPE_BYTES: usize = 1 << 20;

/// Makes connections. Clones lead to the same server.
#[derive(Clone)]
pub(crate) struct Pipes(mpsc::UnboundedSender<io::Result<DuplexStream>>);

impl Pipes {
    /// A maker of connections, and the server's ends of them.
    pub(crate) fn new() -> (Self, UnboundedReceiverStream<io::Result<DuplexStream>>) {
        let (pipes, incoming) = mpsc::unbounded_channel();
        (Self(pipes), UnboundedReceiverStream::new(incoming))
    }

    /// A new connection.
    ///
    /// # Errors
    /// If the server is stopping.
    pub(crate) async fn channel(&self) -> Result<Channel, Error> {
        let pipes = self.0.clone();
        let connector = tower::service_fn(move |_| {
            let (near, far) = tokio::io::duplex(PIPE_BYTES);
            let sent = pipes.send(Ok(far));
            std::future::ready(
                sent.map(|()| TokioIo::new(near))
                    .map_err(|_| io::Error::from(io::ErrorKind::ConnectionRefused)),
            )
        });
        // The name is never looked up; it has to be some authority.
        Endpoint::from_static("http://localhost").connect_with_connector(connector).await
    }
}
