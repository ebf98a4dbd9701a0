//! Responses that are in bytes already, because they were made once for many.
//!
//! The generated code of `baudbot-proto` takes responses in the contract's types only, so methods with such responses
//! are served beside it, by their paths.

use std::convert::Infallible;
use std::marker::PhantomData;

use bytes::BufMut;
use prost::Message;
use tonic::codec::{Codec, EncodeBuf, Encoder};
use tonic::codegen::{Body, StdError, http};
use tonic::server::Grpc;
use tonic::{Request, Response, Status};
use tonic_prost::ProstCodec;
use tower::service_fn;

use crate::limits::{Inbox, Parts};

type Served = Result<http::Response<tonic::body::Body>, Infallible>;

/// Serves a call with a single response.
pub(crate) async fn unary<M, B, F>(
    request: http::Request<B>,
    method: impl FnMut(Request<M>) -> F + Send,
) -> Served
where
    M: Message + Default + Send + 'static,
    B: Body + Send + 'static,
    B::Error: Into<StdError> + Send + 'static,
    F: Future<Output = Result<Response<Parts>, Status>> + Send + 'static,
{
    Ok(Grpc::new(InBytes(PhantomData)).unary(service_fn(method), request).await)
}

/// Serves a call with a stream of responses.
pub(crate) async fn server_streaming<M, B, F>(
    request: http::Request<B>,
    method: impl FnMut(Request<M>) -> F + Send,
) -> Served
where
    M: Message + Default + Send + 'static,
    B: Body + Send + 'static,
    B::Error: Into<StdError> + Send + 'static,
    F: Future<Output = Result<Response<Inbox>, Status>> + Send + 'static,
{
    Ok(Grpc::new(InBytes(PhantomData)).server_streaming(service_fn(method), request).await)
}

/// A response in the contract's type.
///
/// # Errors
/// `INTERNAL` if it is not of that type.
pub(crate) fn decoded<M: Message + Default>(response: Parts) -> Result<M, Status> {
    response
        .decode()
        .map_err(|error| Status::internal(format!("a response is not what it was made to be: {error}")))
}

/// Takes requests of one type, and gives bytes.
struct InBytes<M>(PhantomData<M>);

impl<M: Message + Default + Send + 'static> Codec for InBytes<M> {
    type Encode = Parts;
    type Decode = M;
    type Encoder = Joined;
    type Decoder = <ProstCodec<(), M> as Codec>::Decoder;

    fn encoder(&mut self) -> Joined {
        Joined
    }

    fn decoder(&mut self) -> Self::Decoder {
        ProstCodec::<(), M>::default().decoder()
    }
}

/// Puts the parts of a message one behind the other.
struct Joined;

impl Encoder for Joined {
    type Item = Parts;
    type Error = Status;

    fn encode(&mut self, message: Parts, buffer: &mut EncodeBuf<'_>) -> Result<(), Status> {
        buffer.reserve(message.len());
        message.0.into_iter().for_each(|part| buffer.put(part));
        Ok(())
    }
}
