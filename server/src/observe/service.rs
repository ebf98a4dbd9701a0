//! The observers' service behind its paths: all its responses are in bytes already.

use std::convert::Infallible;
use std::sync::Arc;
use std::task::{Context, Poll};

use baudbot_proto::v1;
use baudbot_proto::v1::observe_service_server::{ObserveServiceServer, SERVICE_NAME};
use tonic::codegen::{Body, BoxFuture, Service, StdError, http};
use tonic::server::NamedService;
use tonic::{Request, Response};

use super::Observe;
use crate::in_bytes::{server_streaming, unary};

const DESCRIBE_WORLD: &str = "/baudbot.v1.ObserveService/DescribeWorld";
const GET_COVERAGE: &str = "/baudbot.v1.ObserveService/GetCoverage";
const WATCH: &str = "/baudbot.v1.ObserveService/Watch";
const WATCH_CABLE: &str = "/baudbot.v1.ObserveService/WatchCable";

/// The service. Clones share it.
#[derive(Clone)]
pub(crate) struct ObserveServer {
    observe: Arc<Observe>,
    others: ObserveServiceServer<Observe>,
}

impl ObserveServer {
    pub(crate) fn new(observe: Observe) -> Self {
        let observe = Arc::new(observe);
        Self { others: ObserveServiceServer::from_arc(Arc::clone(&observe)), observe }
    }
}

impl NamedService for ObserveServer {
    const NAME: &'static str = SERVICE_NAME;
}

/// A method of [`Observe`], as a service of its request.
macro_rules! method {
    ($observe:expr, $request:ty, $call:expr) => {
        |request: Request<$request>| {
            let observe = Arc::clone(&$observe);
            async move { $call(&observe, request).await.map(Response::new) }
        }
    };
}

impl<B> Service<http::Request<B>> for ObserveServer
where
    B: Body + Send + 'static,
    B::Error: Into<StdError> + Send + 'static,
{
    type Response = http::Response<tonic::body::Body>;
    type Error = Infallible;
    type Future = BoxFuture<Self::Response, Self::Error>;

    fn poll_ready(&mut self, _: &mut Context<'_>) -> Poll<Result<(), Infallible>> {
        Poll::Ready(Ok(()))
    }

    fn call(&mut self, request: http::Request<B>) -> Self::Future {
        let observe = Arc::clone(&self.observe);
        match request.uri().path() {
            DESCRIBE_WORLD => Box::pin(async move {
                let describe = async |observe: &Observe, request: Request<v1::DescribeWorldRequest>| {
                    observe.description_in_bytes(&request.get_ref().world).await
                };
                unary(request, method!(observe, v1::DescribeWorldRequest, describe)).await
            }),
            GET_COVERAGE => Box::pin(async move {
                let cover = async |observe: &Observe, request: Request<v1::GetCoverageRequest>| {
                    observe.coverage_in_bytes(&request.get_ref().world).await
                };
                unary(request, method!(observe, v1::GetCoverageRequest, cover)).await
            }),
            WATCH => Box::pin(async move {
                server_streaming(request, method!(observe, v1::WatchRequest, Observe::frames)).await
            }),
            WATCH_CABLE => Box::pin(async move {
                server_streaming(request, method!(observe, v1::WatchCableRequest, Observe::news)).await
            }),
            _ => self.others.call(request),
        }
    }
}
