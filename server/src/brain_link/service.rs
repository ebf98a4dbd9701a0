//! The brains' service behind its path. What `baudbot-proto` generates takes responses in the contract's types only; here a
//! Turn is in bytes already (`convert/turn.rs`).

use std::convert::Infallible;
use std::sync::Arc;
use std::task::{Context, Poll};

use baudbot_proto::v1;
use baudbot_proto::v1::brain_link_service_server::SERVICE_NAME;
use bytes::BufMut;
use prost::Message as _;
use tonic::codec::{Codec, EncodeBuf, Encoder};
use tonic::codegen::{Body, BoxFuture, Service, StdError, http};
use tonic::server::{Grpc, NamedService, StreamingService};
use tonic::{Request, Response, Status, Streaming};
use tonic_prost::ProstCodec;

use super::{BrainLink, Responses};
use crate::convert::AttachResponse;

/// The path of the service's only method.
const ATTACH: &str = "/baudbot.v1.BrainLinkService/Attach";

/// The service. Clones share it.
#[derive(Clone)]
pub(crate) struct BrainLinkServer(Arc<BrainLink>);

impl BrainLinkServer {
    pub(crate) fn new(service: BrainLink) -> Self {
        Self(Arc::new(service))
    }
}

impl NamedService for BrainLinkServer {
    const NAME: &'static str = SERVICE_NAME;
}

impl<B> Service<http::Request<B>> for BrainLinkServer
where
    B: Body + Send + 'static,
    B::Error: Into<StdError> + Send + 'static,
{
    type Response = http::Response<tonic::body::Body>;
    type Error = Infallible;
    type Future = BoxFuture<Self::Response, Self::Error>;

    fn poll_ready(&mut self, _: &mut Context<'_>) -> Poll<Result<(), Self::Error>> {
        Poll::Ready(Ok(()))
    }

    fn call(&mut self, request: http::Request<B>) -> Self::Future {
        let is_known = request.uri().path() == ATTACH;
        let method = Attach(Arc::clone(&self.0));
        Box::pin(async move {
            if !is_known {
                return Ok(Status::unimplemented("").into_http());
            }
            Ok(Grpc::new(AttachCodec).streaming(method, request).await)
        })
    }
}

struct Attach(Arc<BrainLink>);

impl StreamingService<v1::AttachRequest> for Attach {
    type Response = AttachResponse;
    type ResponseStream = Responses;
    type Future = BoxFuture<Response<Responses>, Status>;

    fn call(&mut self, request: Request<Streaming<v1::AttachRequest>>) -> Self::Future {
        let service = Arc::clone(&self.0);
        Box::pin(async move { service.attach(request).await })
    }
}

/// The contract's types, but for Turns, which are in bytes.
struct AttachCodec;

type ContractCodec = ProstCodec<v1::AttachResponse, v1::AttachRequest>;

impl Codec for AttachCodec {
    type Encode = AttachResponse;
    type Decode = v1::AttachRequest;
    type Encoder = Self;
    type Decoder = <ContractCodec as Codec>::Decoder;

    fn encoder(&mut self) -> Self::Encoder {
        Self
    }

    fn decoder(&mut self) -> Self::Decoder {
        ContractCodec::default().decoder()
    }
}

impl Encoder for AttachCodec {
    type Item = AttachResponse;
    type Error = Status;

    fn encode(&mut self, response: AttachResponse, buffer: &mut EncodeBuf<'_>) -> Result<(), Status> {
        match response {
            AttachResponse::Turn(bytes) => buffer.put(bytes),
            AttachResponse::Other(response) => response.encode(buffer).map_err(|error| {
                Status::internal(format!("a response does not fit into its buffer: {error}"))
            })?,
        }
        Ok(())
    }
}
