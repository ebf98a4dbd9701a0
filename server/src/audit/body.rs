//! The body of a response whose end is noted.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use bytes::Bytes;
use http_body::{Frame, SizeHint};
use tonic::body::Body;
use tonic::codegen::http::{HeaderMap, Response};
use tonic::{Code, Status};

use super::Record;

/// The body of a response to a call that is audited.
pub(crate) struct Audited {
    body: Body,
    /// `None` once its end is noted.
    record: Option<Arc<Record>>,
}

impl Audited {
    /// The same response; its end is noted.
    pub(crate) fn response(response: Response<Body>, record: Arc<Record>) -> Response<Body> {
        if let Some(status) = Status::from_header_map(response.headers()) {
            record.end(status.code(), status.message());
            return response;
        }
        response.map(|body| Body::new(Self { body, record: Some(record) }))
    }

    fn note(&mut self, trailers: Option<&HeaderMap>) {
        let Some(record) = self.record.take() else { return };
        match trailers.map(Status::from_header_map) {
            Some(Some(status)) => record.end(status.code(), status.message()),
            Some(None) | None => record.end(Code::Cancelled, "the client is gone"),
        }
    }
}

impl http_body::Body for Audited {
    type Data = Bytes;
    type Error = Status;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Status>>> {
        let frame = Pin::new(&mut self.body).poll_frame(context);
        match &frame {
            Poll::Ready(Some(Ok(frame))) => {
                if let Some(trailers) = frame.trailers_ref() {
                    self.note(Some(trailers));
                }
            }
            Poll::Ready(Some(Err(status))) => {
                if let Some(record) = self.record.take() {
                    record.end(status.code(), status.message());
                }
            }
            Poll::Ready(None) | Poll::Pending => {}
        }
        frame
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

impl Drop for Audited {
    fn drop(&mut self) {
        self.note(None);
    }
}
