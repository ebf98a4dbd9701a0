//! A connection that reports the first bytes over it.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};

use baudbot_fields::printable::Printable;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::sync::SetOnce;

use crate::error::tls_error;
use crate::place::Pipe;

/// The first bytes from a server.
#[derive(Debug)]
pub(crate) enum First {
    /// Bytes, as they come from a server.
    Bytes,
    /// HTTP/1, as a server speaks to those who speak without TLS where it is wanted: its words for people.
    Words(String),
    /// The end of the connection.
    End(io::Error),
}

/// A connection that reports its first bytes, or its end.
pub(crate) struct Line {
    pipe: Box<dyn Pipe>,
    /// The recipient.
    heard: Option<Arc<SetOnce<First>>>,
}

impl Line {
    /// A connection that reports to `heard`, unless another has reported already.
    pub(crate) fn new(pipe: Box<dyn Pipe>, heard: Arc<SetOnce<First>>) -> Self {
        Self { pipe, heard: Some(heard).filter(|heard| !heard.initialized()) }
    }

    fn tell(&mut self, read: &io::Result<()>, bytes: &[u8]) {
        if let Some(heard) = self.heard.take() {
            // The one before may have reported meanwhile.
            let _ = heard.set(First::of(read, bytes));
        }
    }

    /// Passes on the result of a write. If that failed, the server may have sent the reason before it closed the
    /// connection.
    fn heed<T>(&mut self, context: &mut Context<'_>, written: Poll<io::Result<T>>) -> Poll<io::Result<T>> {
        if self.heard.is_some() && matches!(written, Poll::Ready(Err(_))) {
            let mut bytes = [0; 512];
            let mut buffer = ReadBuf::new(&mut bytes);
            // The answer has come, or the end of the connection has: the wait is short.
            let read = ready!(Pin::new(&mut self.pipe).poll_read(context, &mut buffer));
            self.tell(&read, buffer.filled());
        }
        written
    }
}

impl First {
    fn of(read: &io::Result<()>, bytes: &[u8]) -> Self {
        match read {
            Err(error) => Self::End(copy(error)),
            Ok(()) if bytes.is_empty() => {
                let text = "the connection is closed at once";
                Self::End(io::Error::new(io::ErrorKind::UnexpectedEof, text))
            }
            Ok(()) => words_of_http_1(bytes).map_or(Self::Bytes, Self::Words),
        }
    }
}

/// The same error, as far as it is evaluated.
fn copy(error: &io::Error) -> io::Error {
    match tls_error(error) {
        Some(tls) => io::Error::new(error.kind(), tls.clone()),
        None => io::Error::new(error.kind(), error.to_string()),
    }
}

/// The words for people in an answer of HTTP/1, if this is one.
fn words_of_http_1(bytes: &[u8]) -> Option<String> {
    let answer = bytes.starts_with(b"HTTP/1.").then(|| String::from_utf8_lossy(bytes))?;
    let words =
        answer.split_once("\r\n\r\n").map_or("", |(_, words)| words).lines().next().unwrap_or_default();
    Some(if words.is_empty() {
        "the program that answers there is not a gRPC server".to_owned()
    } else {
        Printable(words).to_string()
    })
}

impl AsyncRead for Line {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let before = buffer.filled().len();
        let read = ready!(Pin::new(&mut self.pipe).poll_read(context, buffer));
        self.tell(&read, &buffer.filled()[before..]);
        Poll::Ready(read)
    }
}

impl AsyncWrite for Line {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.pipe).poll_write(context, bytes);
        self.heed(context, written)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.pipe).poll_write_vectored(context, parts);
        self.heed(context, written)
    }

    fn is_write_vectored(&self) -> bool {
        self.pipe.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        let written = Pin::new(&mut self.pipe).poll_flush(context);
        self.heed(context, written)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.pipe).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use tokio::io::{AsyncReadExt, AsyncWriteExt, duplex};

    use super::*;

    #[tokio::test]
    async fn what_was_said_before_the_end_is_heard_by_one_who_writes() {
        let (near, mut far) = duplex(64);
        far.write_all(b"HTTP/1.1 400 Bad Request\r\n\r\nuse https://\n").await.unwrap();
        drop(far);
        let heard = Arc::new(SetOnce::new());
        let mut line = Line::new(Box::new(near), Arc::clone(&heard));
        line.write_all(b"PRI").await.unwrap_err();
        assert!(matches!(heard.get(), Some(First::Words(words)) if words == "use https://"), "{heard:?}");
    }

    #[tokio::test]
    async fn an_end_is_heard_once() {
        let (near, far) = duplex(64);
        drop(far);
        let heard = Arc::new(SetOnce::new());
        let mut line = Line::new(Box::new(near), Arc::clone(&heard));
        assert_eq!(line.read(&mut [0]).await.unwrap(), 0);
        assert!(matches!(heard.get(), Some(First::End(_))), "{heard:?}");
        assert!(Line::new(Box::new(duplex(1).0), heard).heard.is_none());
    }
}
