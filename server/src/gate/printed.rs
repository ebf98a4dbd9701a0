//! Errors that are only shown by the terminal of a caller, whatever they quote.
//!
//! A status quotes what callers have written: names, fields, lines of files. Quotations are escaped where they are made
//! ([`quote`](crate::quote)); here, at the one door that all statuses leave by, what somebody has forgotten is escaped.

use std::pin::Pin;
use std::task::{Context, Poll};

use baudbot_fields::printable::{PrintableLines, is_printable};
use bytes::Bytes;
use http_body::{Body as _, Frame, SizeHint};
use tonic::Status;
use tonic::body::Body;
use tonic::codegen::http::{HeaderMap, Response};

/// The response with the status that it has, or will end with, as it may be shown.
pub(super) fn printed(mut response: Response<Body>) -> Response<Body> {
    print(response.headers_mut());
    if response.body().is_end_stream() { response } else { response.map(|body| Body::new(Printed(body))) }
}

/// Escapes the message of a status, if it has one.
fn print(headers: &mut HeaderMap) {
    if !headers.contains_key(Status::GRPC_MESSAGE) {
        return;
    }
    let Some(status) = Status::from_header_map(headers) else { return };
    let is_plain = |c: char| is_printable(c) || c == '\n' || c == '\t';
    if !status.message().chars().all(is_plain) {
        let message = PrintableLines(status.message()).to_string();
        // A message is percent-encoded, so that it fits into a header.
        let _ = Status::new(status.code(), message).add_header(headers);
    }
}

struct Printed(Body);

impl http_body::Body for Printed {
    type Data = Bytes;
    type Error = Status;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Status>>> {
        Pin::new(&mut self.0).poll_frame(context).map_ok(|mut frame| {
            if let Some(trailers) = frame.trailers_mut() {
                print(trailers);
            }
            frame
        })
    }

    fn is_end_stream(&self) -> bool {
        self.0.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.0.size_hint()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body that has nothing but an end.
    struct Ends(Option<HeaderMap>);

    impl http_body::Body for Ends {
        type Data = Bytes;
        type Error = Status;

        fn poll_frame(
            mut self: Pin<&mut Self>,
            _: &mut Context<'_>,
        ) -> Poll<Option<Result<Frame<Bytes>, Status>>> {
            Poll::Ready(self.0.take().map(|trailers| Ok(Frame::trailers(trailers))))
        }
    }

    #[test]
    fn a_status_is_escaped_in_headers_and_keeps_its_code_and_lines() {
        let message = |text: &str| {
            let response = printed(Status::not_found(text).into_http::<Body>());
            let status = Status::from_header_map(response.headers()).unwrap();
            assert_eq!(status.code(), tonic::Code::NotFound);
            status.message().to_owned()
        };
        assert_eq!(message("a\n\tb — ä"), "a\n\tb — ä");
        assert_eq!(message("\u{1b}[31m\u{7}\u{202e}x"), r"\u{1b}[31m\u{7}\u{202e}x");
    }

    #[tokio::test]
    async fn a_status_is_escaped_in_trailers() {
        let mut trailers = HeaderMap::new();
        Status::internal("\u{1b}c").add_header(&mut trailers).unwrap();
        let mut body = printed(Response::new(Body::new(Ends(Some(trailers))))).into_body();
        let frame = std::future::poll_fn(|context| Pin::new(&mut body).poll_frame(context)).await;
        let status = Status::from_header_map(frame.unwrap().unwrap().trailers_ref().unwrap()).unwrap();
        assert_eq!((status.code(), status.message()), (tonic::Code::Internal, r"\u{1b}c"));
    }
}
