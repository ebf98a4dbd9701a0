//! The body of a response whose bytes are counted while they wait for their reader.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, Waker};

use bytes::Bytes;
use http_body::{Body as _, Frame, SizeHint};
use tonic::Status;
use tonic::body::Body;
use tonic::codegen::http::HeaderMap;

use crate::limits::{InForce, Inbox, Outbox, Parts, Tally};

/// Counts what waits here for the caller of any call, so that no service has to. A single message is made at once, and
/// not when the client has room for it: the memory of one that is not made is unknown.
pub(super) struct Metered {
    body: Body,
    outbox: Outbox,
    inbox: Inbox,
    /// The payer whose calls become fewer if much is sent to it.
    pays: Option<(InForce, Arc<Tally>)>,
    trailers: Option<HeaderMap>,
    is_over: bool,
}

impl Metered {
    /// The body of a response to this caller. `pays` if its bytes count as requests.
    pub(super) fn new(body: Body, limits: &InForce, caller: &Arc<Tally>, what: &str, pays: bool) -> Self {
        let (outbox, inbox) = limits.outbox(caller, what, usize::MAX);
        let pays = pays.then(|| (limits.clone(), Arc::clone(caller)));
        let mut metered = Self { body, outbox, inbox, pays, trailers: None, is_over: false };
        // The first poll makes a single message, the second gives its end. The reader polls again, and is woken then.
        for _ in 0..2 {
            if !matches!(metered.fill(&mut Context::from_waker(Waker::noop())), Poll::Ready(Ok(()))) {
                break;
            }
        }
        metered
    }

    /// Takes what the service has; an error if it has failed.
    fn fill(&mut self, context: &mut Context<'_>) -> Poll<Result<(), Status>> {
        if self.is_over {
            return Poll::Ready(Ok(()));
        }
        let Some(frame) = std::task::ready!(Pin::new(&mut self.body).poll_frame(context)) else {
            self.finish();
            return Poll::Ready(Ok(()));
        };
        match frame?.into_data() {
            Ok(bytes) => {
                if let Some((limits, caller)) = &self.pays {
                    limits.charge(caller, bytes.len());
                }
                self.outbox.push(Parts(vec![bytes]));
            }
            Err(frame) => {
                self.trailers = frame.into_trailers().ok();
                self.finish();
            }
        }
        Poll::Ready(Ok(()))
    }

    /// The service is done. Its end of the body goes: what it has encoded lies in memory as long as that does.
    fn finish(&mut self) {
        (self.body, self.is_over) = (Body::empty(), true);
    }

    /// Ends the body with this status, and with it the service.
    fn end(&mut self, status: &Status) -> Frame<Bytes> {
        let mut trailers = HeaderMap::new();
        // The words of a limit fit into headers.
        let _ = status.add_header(&mut trailers);
        self.finish();
        Frame::trailers(trailers)
    }
}

impl http_body::Body for Metered {
    type Data = Bytes;
    type Error = Status;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Status>>> {
        loop {
            self.inbox.register(context);
            if let Some(status) = self.inbox.take_why_cut() {
                return Poll::Ready(Some(Ok(self.end(&status))));
            }
            if let Some(piece) = self.inbox.take_piece() {
                return Poll::Ready(Some(Ok(Frame::data(piece))));
            }
            if self.is_over {
                return Poll::Ready(self.trailers.take().map(|trailers| Ok(Frame::trailers(trailers))));
            }
            if let Err(status) = std::task::ready!(self.fill(context)) {
                self.is_over = true;
                return Poll::Ready(Some(Err(status)));
            }
        }
    }

    fn is_end_stream(&self) -> bool {
        self.is_over && self.trailers.is_none() && self.inbox.is_empty()
    }

    fn size_hint(&self) -> SizeHint {
        SizeHint::default()
    }
}
