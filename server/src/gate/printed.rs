//! Errors that are only shown by the terminal of a caller, whatever they quote.
//!
//! A status quotes what callers have written: names, fields, lines of files. Quotations are escaped where they are made
//! ([`quote`](crate::quote)); here, at the one door that all statuses leave by, what was not escaped before is.

use baudbot_fields::printable::{PrintableLines, is_printable};
use http_body::Body as _;
use http_body_util::BodyExt;
use tonic::Status;
use tonic::body::Body;
use tonic::codegen::http::{HeaderMap, Response};

/// The response with the status that it has, or will end with, as it may be shown.
pub(super) fn printed(mut response: Response<Body>) -> Response<Body> {
    print(response.headers_mut());
    if response.body().is_end_stream() {
        return response;
    }
    let with_trailers = |body: Body| {
        body.map_frame(|mut frame| {
            if let Some(trailers) = frame.trailers_mut() {
                print(trailers);
            }
            frame
        })
    };
    response.map(|body| Body::new(with_trailers(body)))
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

#[cfg(test)]
mod tests {
    use bytes::Bytes;
    use http_body_util::Empty;

    use super::*;

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
        let ends = Empty::<Bytes>::new().with_trailers(std::future::ready(Some(Ok(trailers))));
        let body = printed(Response::new(Body::new(ends))).into_body().collect().await.unwrap();
        let status = Status::from_header_map(body.trailers().unwrap()).unwrap();
        assert_eq!((status.code(), status.message()), (tonic::Code::Internal, r"\u{1b}c"));
    }
}
