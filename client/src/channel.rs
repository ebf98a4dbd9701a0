//! A connection that shows a token with each call.

use std::task::{Context, Poll};

use baudbot_access::Token;
use tonic::body::Body;
use tonic::codegen::http::header::AUTHORIZATION;
use tonic::codegen::http::{HeaderValue, Request, Response};
use tonic::transport;
use tonic::transport::channel::ResponseFuture;
use tower::Service;

/// A connection to a server, for clients of any of its services. Clones share it.
#[derive(Clone, Debug)]
pub struct Channel {
    inner: transport::Channel,
    /// What is shown with each call.
    authorization: Option<HeaderValue>,
}

impl Channel {
    pub(crate) fn new(inner: transport::Channel, token: Option<&Token>) -> Self {
        let authorization = token.map(|token| {
            let text = format!("Bearer {}", token.reveal());
            let mut value =
                HeaderValue::try_from(text).expect("a token has no other characters than headers");
            value.set_sensitive(true);
            value
        });
        Self { inner, authorization }
    }
}

/// One that shows no token, such as one to a server in the same process.
impl From<transport::Channel> for Channel {
    fn from(inner: transport::Channel) -> Self {
        Self::new(inner, None)
    }
}

impl Service<Request<Body>> for Channel {
    type Response = Response<Body>;
    type Error = transport::Error;
    type Future = ResponseFuture;

    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Result<(), transport::Error>> {
        self.inner.poll_ready(context)
    }

    fn call(&mut self, mut request: Request<Body>) -> ResponseFuture {
        if let Some(authorization) = &self.authorization {
            request.headers_mut().insert(AUTHORIZATION, authorization.clone());
        }
        self.inner.call(request)
    }
}
