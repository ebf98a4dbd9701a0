//! A connection that shows a token with each call, or a way to services in the same program.

use std::fmt;
use std::task::{Context, Poll};

#[cfg(feature = "network")]
use baudbot_access::Token;
use tonic::body::Body;
use tonic::codegen::http::header::AUTHORIZATION;
use tonic::codegen::http::{HeaderValue, Request, Response};
use tonic::codegen::{BoxFuture, StdError};
use tower::util::BoxCloneSyncService;
use tower::{Service, ServiceExt};

/// A connection to a server, for clients of any of its services. Clones share it.
#[derive(Clone)]
pub struct Channel {
    inner: BoxCloneSyncService<Request<Body>, Response<Body>, StdError>,
    /// What is shown with each call.
    authorization: Option<HeaderValue>,
}

impl Channel {
    /// To services in the same program, which are called as functions.
    pub fn to<S>(services: S) -> Self
    where
        S: Service<Request<Body>, Response = Response<Body>, Error: Into<StdError>, Future: Send + 'static>,
        S: Clone + Send + Sync + 'static,
    {
        Self { inner: BoxCloneSyncService::new(services.map_err(Into::into)), authorization: None }
    }

    #[cfg(feature = "network")]
    pub(crate) fn new(inner: tonic::transport::Channel, token: Option<&Token>) -> Self {
        let authorization = token.map(|token| {
            let text = format!("Bearer {}", token.reveal());
            let mut value =
                HeaderValue::try_from(text).expect("a token has no other characters than headers");
            value.set_sensitive(true);
            value
        });
        Self { authorization, ..Self::to(inner) }
    }
}

/// One that shows no token, such as one to a server in the same process.
#[cfg(feature = "network")]
impl From<tonic::transport::Channel> for Channel {
    fn from(inner: tonic::transport::Channel) -> Self {
        Self::new(inner, None)
    }
}

impl fmt::Debug for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Channel").field("authorization", &self.authorization).finish_non_exhaustive()
    }
}

impl Service<Request<Body>> for Channel {
    type Response = Response<Body>;
    type Error = StdError;
    type Future = BoxFuture<Response<Body>, StdError>;

    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Result<(), StdError>> {
        self.inner.poll_ready(context)
    }

    fn call(&mut self, mut request: Request<Body>) -> Self::Future {
        if let Some(authorization) = &self.authorization {
            request.headers_mut().insert(AUTHORIZATION, authorization.clone());
        }
        self.inner.call(request)
    }
}
