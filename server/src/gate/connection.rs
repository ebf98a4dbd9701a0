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

use super::Admission;
use super::frames::Frames;
use crate::clock;

/// The time for which a peer may leave written bytes unread: as long as the server waits for one that does not answer
/// pings.
const STALLED: Duration = Duration::from_secs(40);

/// Bytes that are read before other tasks have their turn. Frames of HTTP/2 that have come and that no task has taken yet are
/// counted by h2, which closes a connection with too many; so few bytes do not have so many frames.
const AT_ONCE: usize = 16 << 10;

/// A connection. Its place is free again when it is dropped.
pub(crate) struct Connection<IO> {
    io: IO,
    admission: Arc<Admission>,
    /// The instant until which it has to make its first call; `None` once it has.
    patience: Option<Pin<Box<Sleep>>>,
    /// The instant until which its peer has to take what is written; `None` while it does.
    stalled: Option<Pin<Box<Sleep>>>,
    /// Bytes read since other tasks had their turn.
    read: usize,
    /// The counter of the frames of HTTP/2, if the connection speaks that.
    frames: Option<Frames>,
}

impl<IO> Connection<IO> {
    /// `frames` counts what is read, if that is HTTP/2.
    pub(super) fn new(io: IO, admission: Arc<Admission>, frames: Option<Frames>) -> Self {
        let patience = admission.patience();
        Self { io, admission, patience: Some(Box::pin(sleep(patience))), stalled: None, read: 0, frames }
    }

    pub(super) fn io(&self) -> &IO {
        &self.io
    }

    pub(super) fn admission(&self) -> Arc<Admission> {
        Arc::clone(&self.admission)
    }

    /// An error if it has made no call for too long, or has to go. This is asked when it is written, too: a handshake begins with
    /// that, and who does not read what is written is not read either.
    fn stays(&mut self, context: &mut Context<'_>) -> io::Result<()> {
        if self.admission.has_called.load(Ordering::Relaxed) {
            self.patience = None;
        }
        let is_late = self.patience.as_mut().is_some_and(|patience| {
            self.admission.reader.register(context.waker());
            patience.as_mut().poll(context).is_ready()
        });
        if is_late || self.admission.is_evicted.load(Ordering::Relaxed) {
            return Err(io::Error::new(io::ErrorKind::TimedOut, "nothing was asked for"));
        }
        Ok(())
    }

    /// Logs that the connection is closed for frames of this kind.
    fn note_flood(&self, kind: &str) {
        if let Some(times) = self.admission.gate.0.floods.note(clock::now()) {
            let from = self.admission.tally.account().to_string();
            tracing::warn!(
                times,
                from,
                kind,
                "a connection is closed because it sends too many HTTP/2 frames without content"
            );
        }
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

impl<IO> Drop for Connection<IO> {
    fn drop(&mut self) {
        self.admission.gate.leave(&self.admission);
    }
}

impl<IO> Connected for Connection<IO> {
    type ConnectInfo = Arc<Admission>;

    fn connect_info(&self) -> Arc<Admission> {
        self.admission()
    }
}

impl<IO: AsyncRead + Unpin> AsyncRead for Connection<IO> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        self.stays(context)?;
        if self.read >= AT_ONCE {
            // The tasks that wait for what has come get their turn first.
            self.read = 0;
            context.waker().wake_by_ref();
            return Poll::Pending;
        }
        let before = buffer.filled().len();
        let result = Pin::new(&mut self.io).poll_read(context, buffer);
        self.read = if result.is_ready() { self.read + buffer.filled().len() - before } else { 0 };
        if let Some(frames) = &mut self.frames
            && let Err(kind) = frames.read(&buffer.filled()[before..], clock::now())
        {
            self.note_flood(kind);
            return Poll::Ready(Err(io::Error::other(format!("too many frames: {kind}"))));
        }
        result
    }
}

impl<IO: AsyncWrite + Unpin> AsyncWrite for Connection<IO> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        self.stays(context)?;
        let result = Pin::new(&mut self.io).poll_write(context, bytes);
        self.written(context, result)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        parts: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        self.stays(context)?;
        let result = Pin::new(&mut self.io).poll_write_vectored(context, parts);
        self.written(context, result)
    }

    fn is_write_vectored(&self) -> bool {
        self.io.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.stays(context)?;
        Pin::new(&mut self.io).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.io).poll_shutdown(context)
    }
}
