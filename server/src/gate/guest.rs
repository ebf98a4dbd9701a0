//! A connection as it is read and written.

use std::io::{self, IoSlice};
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::task::{Context, Poll};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::{Sleep, sleep};
use tonic::transport::server::Connected;

use super::Visit;

/// A connection. Its place is free again when it is dropped.
pub(crate) struct Guest<IO> {
    io: IO,
    visit: Arc<Visit>,
    /// Until when it has to ask for something; `None` once it has.
    patience: Option<Pin<Box<Sleep>>>,
    /// Until when its peer has to take what is written; `None` while it does.
    stalled: Option<Pin<Box<Sleep>>>,
    /// Bytes read without a rest.
    read: usize,
}

impl<IO> Guest<IO> {
    pub(super) fn new(io: IO, visit: Arc<Visit>) -> Self {
        let patience = visit.patience();
        Self { io, visit, patience: Some(Box::pin(sleep(patience))), stalled: None, read: 0 }
    }

    pub(super) fn io(&self) -> &IO {
        &self.io
    }

    pub(super) fn visit(&self) -> Arc<Visit> {
        Arc::clone(&self.visit)
    }

    /// Whether it has asked for nothing for too long, or has to make room.
    fn is_over(&mut self, context: &mut Context<'_>) -> bool {
        let Some(patience) = &mut self.patience else { return false };
        if self.visit.is_known.load(Ordering::Relaxed) {
            self.patience = None;
            return false;
        }
        self.visit.reader.register(context.waker());
        self.visit.is_over.load(Ordering::Relaxed) || patience.as_mut().poll(context).is_ready()
    }

    /// The result of a write, or an error if the peer has taken nothing for too long.
    fn written<T>(&mut self, context: &mut Context<'_>, result: Poll<io::Result<T>>) -> Poll<io::Result<T>> {
        if result.is_ready() {
            self.stalled = None;
            return result;
        }
        let stalled = self.stalled.get_or_insert_with(|| Box::pin(sleep(STALLED)));
        let too_long = || Err(io::Error::new(io::ErrorKind::TimedOut, "the peer does not read"));
        stalled.as_mut().poll(context).map(|()| too_long())
    }
}

impl<IO> Drop for Guest<IO> {
    fn drop(&mut self) {
        self.visit.gate.leave(&self.visit);
    }
}

impl<IO> Connected for Guest<IO> {
    type ConnectInfo = Arc<Visit>;

    fn connect_info(&self) -> Arc<Visit> {
        self.visit()
    }
}

impl<IO: AsyncRead + Unpin> AsyncRead for Guest<IO> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        if self.is_over(context) {
            return Poll::Ready(Err(io::Error::new(io::ErrorKind::TimedOut, "nothing was asked for")));
        }
        if self.read >= AT_ONCE {
            // Those who wait for what came come first.
            self.read = 0;
            context.waker().wake_by_ref();
            return Poll::Pending;
        }
        let before = buffer.filled().len();
        let result = Pin::new(&mut self.io).poll_read(context, buffer);
        self.read = if result.is_ready() { self.read + buffer.filled().len() - before } else { 0 };
        result
    }
}

impl<IO: AsyncWrite + Unpin> AsyncWrite for Guest<IO> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let result = Pin::new(&mut self.io).poll_write(context, bytes);
        self.written(context, result)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        parts: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let result = Pin::new(&mut self.io).poll_write_vectored(context, parts);
        self.written(context, result)
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

/// How long a peer may leave unread what is written: as long as one that does not answer pings is waited for.
const STALLED: Duration = Duration::from_secs(40);

/// Bytes that are read before others have their turn. Frames that have come and that nobody has taken yet are counted,
/// and there is an end to them; in so many bytes there are not so many frames.
const AT_ONCE: usize = 16 << 10;
