//! A way to a server: a connection that shows a token with each call, or services in the same program.

use std::fmt;
use std::task::{Context, Poll};

#[cfg(feature = "network")]
use baudbot_access::Token;
use tonic::body::Body;
#[cfg(feature = "network")]
use tonic::codegen::http::{HeaderValue, header::AUTHORIZATION};
use tonic::codegen::http::{Request, Response};
use tonic::codegen::{BoxFuture, StdError};
#[cfg(feature = "network")]
use tonic::transport;
use tower::util::BoxCloneSyncService;
use tower::{Service, ServiceExt};

/// A way to a server, for clients of any of its services. Clones share it.
#[derive(Clone)]
pub struct Channel(Way);

#[derive(Clone)]
enum Way {
    #[cfg(feature = "network")]
    Network {
        channel: transport::Channel,
        /// The header that goes with each call.
        authorization: Option<HeaderValue>,
    },
    Here(BoxCloneSyncService<Request<Body>, Response<Body>, StdError>),
}

impl Channel {
    #[cfg(feature = "network")]
    pub(crate) fn new(channel: transport::Channel, token: Option<&Token>) -> Self {
        let authorization = token.map(|token| {
            let text = format!("Bearer {}", token.reveal());
            let mut value =
                HeaderValue::try_from(text).expect("a token has no other characters than headers");
            value.set_sensitive(true);
            value
        });
        Self(Way::Network { channel, authorization })
    }

    /// A channel to these services of the same program, which are called as functions.
    pub fn to<S>(services: S) -> Self
    where
        S: Service<Request<Body>, Response = Response<Body>, Error: Into<StdError>, Future: Send>,
        S: Clone + Send + Sync + 'static,
    {
        Self(Way::Here(BoxCloneSyncService::new(services.map_err(Into::into))))
    }
}

/// One that shows no token, such as one to a server in the same process.
#[cfg(feature = "network")]
impl From<transport::Channel> for Channel {
    fn from(channel: transport::Channel) -> Self {
        Self::new(channel, None)
    }
}

impl fmt::Debug for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Channel")
    }
}

impl Service<Request<Body>> for Channel {
    type Response = Response<Body>;
    type Error = StdError;
    type Future = BoxFuture<Response<Body>, StdError>;

    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Result<(), StdError>> {
        match &mut self.0 {
            #[cfg(feature = "network")]
            Way::Network { channel, .. } => channel.poll_ready(context).map_err(Into::into),
            Way::Here(services) => services.poll_ready(context),
        }
    }

    #[cfg_attr(not(feature = "network"), expect(unused_mut, reason = "only a connection shows a token"))]
    fn call(&mut self, mut request: Request<Body>) -> Self::Future {
        match &mut self.0 {
            #[cfg(feature = "network")]
            Way::Network { channel, authorization } => {
                if let Some(authorization) = authorization {
                    request.headers_mut().insert(AUTHORIZATION, authorization.clone());
                }
                let answered = channel.call(request);
                Box::pin(async move { Ok(answered.await?) })
            }
            Way::Here(services) => services.call(request),
        }
    }
}
