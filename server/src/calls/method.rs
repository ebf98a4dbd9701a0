//! Methods of the contract, called by name with serialised messages.
//!
//! The names and the kinds of the methods come from the contract's descriptors, so a method that is added to a service can
//! be called without a line here. Messages pass through as bytes: the services check them.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use baudbot_proto::v1::brain_link_service_server::SERVICE_NAME as BRAIN_LINK;
use baudbot_proto::v1::control_service_server::SERVICE_NAME as CONTROL;
use baudbot_proto::v1::observe_service_server::SERVICE_NAME as OBSERVE;
use prost::Message as _;
use prost::bytes::{Buf as _, BufMut as _, Bytes};
use prost_types::FileDescriptorSet;
use tokio_stream::Stream;
use tonic::body::Body;
use tonic::client::{Grpc, GrpcService};
use tonic::codec::{Codec, DecodeBuf, Decoder, EncodeBuf, Encoder};
use tonic::codegen::StdError as BoxError;
use tonic::codegen::http::uri::PathAndQuery;
use tonic::{IntoStreamingRequest, Request, Status, Streaming};

use super::MAX_MESSAGE;
use crate::quote::brief;

/// The services of a server, over a connection or in memory.
pub(crate) trait Services:
    GrpcService<Body, ResponseBody = Body, Error: Into<BoxError>, Future: Send> + Clone + Send + 'static
{
}

impl<S> Services for S where
    S: GrpcService<Body, ResponseBody = Body, Error: Into<BoxError>, Future: Send> + Clone + Send + 'static
{
}

/// Whether a method takes and gives single messages or streams of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Unary,
    ServerStreaming,
    /// The method takes a stream of requests, and gives one response or a stream of them.
    ClientStreaming,
}

/// A method of one of the contract's three services.
#[derive(Clone, Debug)]
pub(super) struct Method {
    pub(super) kind: Kind,
    path: PathAndQuery,
}

impl Method {
    /// The method of this full name, such as `baudbot.v1.ControlService/ListWorlds`.
    ///
    /// # Errors
    /// `UNIMPLEMENTED` if none of the three services has it.
    pub(super) fn find(name: &str) -> Result<Self, Status> {
        METHODS.get(name).cloned().ok_or_else(|| {
            let services = [CONTROL, BRAIN_LINK, OBSERVE].join(", ");
            let name = brief(name);
            Status::unimplemented(format!("method: there is no method `{name}`; services are {services}"))
        })
    }

    /// Calls a method with a single request and a single response.
    pub(super) async fn unary<S: Services>(self, services: S, request: Bytes) -> Result<Bytes, Status> {
        let mut client = client(services).await?;
        Ok(client.unary(Request::new(request), self.path, Passthrough).await?.into_inner())
    }

    /// Calls a method with a single request and a stream of responses.
    pub(super) async fn server_streaming<S: Services>(
        self,
        services: S,
        request: Bytes,
    ) -> Result<Streaming<Bytes>, Status> {
        let mut client = client(services).await?;
        Ok(client.server_streaming(Request::new(request), self.path, Passthrough).await?.into_inner())
    }

    /// Calls a method with a stream of requests.
    pub(super) async fn client_streaming<S: Services>(
        self,
        services: S,
        requests: impl Stream<Item = Bytes> + Send + 'static,
    ) -> Result<Streaming<Bytes>, Status> {
        let mut client = client(services).await?;
        let requests = requests.into_streaming_request();
        Ok(client.streaming(requests, self.path, Passthrough).await?.into_inner())
    }
}

/// A client that takes messages as long as the page's socket does: a frame of many robots is long.
async fn client<S: Services>(services: S) -> Result<Grpc<S>, Status> {
    let mut client =
        Grpc::new(services).max_decoding_message_size(MAX_MESSAGE).max_encoding_message_size(MAX_MESSAGE);
    client
        .ready()
        .await
        .map_err(|error| Status::unknown(format!("service was not ready: {}", error.into())))?;
    Ok(client)
}

/// The methods of the three services, by full name.
static METHODS: LazyLock<BTreeMap<String, Method>> = LazyLock::new(|| {
    let contract = FileDescriptorSet::decode(baudbot_proto::TYPES).expect("the contract is sound");
    let mut methods = BTreeMap::new();
    for file in &contract.file {
        for service in &file.service {
            let service_name = format!("{}.{}", file.package(), service.name());
            if ![CONTROL, BRAIN_LINK, OBSERVE].contains(&service_name.as_str()) {
                continue;
            }
            for method in &service.method {
                let name = format!("{service_name}/{}", method.name());
                let path = format!("/{name}").parse().expect("names of methods are paths");
                let kind = match (method.client_streaming(), method.server_streaming()) {
                    (false, false) => Kind::Unary,
                    (false, true) => Kind::ServerStreaming,
                    (true, _) => Kind::ClientStreaming,
                };
                methods.insert(name, Method { kind, path });
            }
        }
    }
    methods
});

/// Passes messages on as they are.
#[derive(Clone, Copy)]
struct Passthrough;

impl Codec for Passthrough {
    type Encode = Bytes;
    type Decode = Bytes;
    type Encoder = Self;
    type Decoder = Self;

    fn encoder(&mut self) -> Self {
        Self
    }

    fn decoder(&mut self) -> Self {
        Self
    }
}

impl Encoder for Passthrough {
    type Item = Bytes;
    type Error = Status;

    fn encode(&mut self, message: Bytes, buffer: &mut EncodeBuf<'_>) -> Result<(), Status> {
        buffer.put(message);
        Ok(())
    }
}

impl Decoder for Passthrough {
    type Item = Bytes;
    type Error = Status;

    fn decode(&mut self, buffer: &mut DecodeBuf<'_>) -> Result<Option<Bytes>, Status> {
        Ok(Some(buffer.copy_to_bytes(buffer.remaining())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_are_those_of_the_three_services_with_their_kinds() {
        let kind = |name: &str| Method::find(name).unwrap().kind;
        assert_eq!(kind("baudbot.v1.ControlService/ListWorlds"), Kind::Unary);
        assert_eq!(kind("baudbot.v1.ObserveService/Watch"), Kind::ServerStreaming);
        assert_eq!(kind("baudbot.v1.BrainLinkService/Attach"), Kind::ClientStreaming);
        let services: Vec<_> = [CONTROL, BRAIN_LINK, OBSERVE].map(|name| format!("{name}/")).into();
        assert!(METHODS.keys().all(|name| services.iter().any(|service| name.starts_with(service))));
    }

    #[test]
    fn other_names_are_refused() {
        for name in ["", "ListWorlds", "/baudbot.v1.ControlService/ListWorlds", "grpc.health.v1.Health/Check"]
        {
            let status = Method::find(name).unwrap_err();
            assert_eq!(status.code(), tonic::Code::Unimplemented);
            let expected = format!("method: there is no method `{name}`; services are {CONTROL}, ");
            assert!(status.message().starts_with(&expected), "{status:?}");
        }
    }
}
