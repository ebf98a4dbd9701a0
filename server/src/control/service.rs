//! The operators' service behind its paths: responses for many callers are in bytes already.

use std::convert::Infallible;
use std::sync::Arc;
use std::task::{Context, Poll};

use baudbot_proto::v1;
use baudbot_proto::v1::control_service_server::{ControlServiceServer, SERVICE_NAME};
use tonic::codegen::{Body, BoxFuture, Service, StdError, http};
use tonic::server::NamedService;
use tonic::{Request, Response};

use super::Control;
use crate::in_bytes::unary;

const GET_WORLD: &str = "/baudbot.v1.ControlService/GetWorld";
const LIST_WORLDS: &str = "/baudbot.v1.ControlService/ListWorlds";

/// The service. Clones share it.
#[derive(Clone)]
pub(crate) struct ControlServer {
    control: Arc<Control>,
    others: ControlServiceServer<Control>,
}

impl ControlServer {
    /// The service, for requests of at most so many bytes.
    pub(crate) fn new(control: Arc<Control>, longest: usize) -> Self {
        let others = ControlServiceServer::from_arc(Arc::clone(&control)).max_decoding_message_size(longest);
        Self { control, others }
    }
}

impl NamedService for ControlServer {
    const NAME: &'static str = SERVICE_NAME;
}

impl<B> Service<http::Request<B>> for ControlServer
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
        let control = Arc::clone(&self.control);
        match request.uri().path() {
            GET_WORLD => Box::pin(async move {
                let method = |request: Request<v1::GetWorldRequest>| {
                    let control = Arc::clone(&control);
                    async move { control.world_in_bytes(&request.get_ref().world).await.map(Response::new) }
                };
                unary(request, method).await
            }),
            LIST_WORLDS => Box::pin(async move {
                let method = |_: Request<v1::ListWorldsRequest>| {
                    let control = Arc::clone(&control);
                    async move { control.list_in_bytes().await.map(Response::new) }
                };
                unary(request, method).await
            }),
            _ => self.others.call(request),
        }
    }
}
