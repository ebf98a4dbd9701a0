//! A bare tonic bidirectional stream that gives back what it gets: what gRPC itself costs.

use std::convert::Infallible;
use std::future::{Future, Ready, ready};
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::{Duration, Instant};

use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::body::Body;
use tonic::codegen::Service;
use tonic::codegen::http::uri::PathAndQuery;
use tonic::codegen::http::{Request, Response};
use tonic::server::{NamedService, StreamingService};
use tonic::transport::server::TcpIncoming;
use tonic::transport::{Endpoint, Server};
use tonic::{Status, Streaming};
use tonic_prost::ProstCodec;

use crate::worlds::brains_process;

/// A message of one field, of so many bytes that it has 64 on the wire.
type Message = Vec<u8>;

const BYTES: usize = 62;

const PATH: &str = "/baudbot.bench.Echo/Echo";

#[derive(Clone)]
struct Echo;

impl NamedService for Echo {
    const NAME: &'static str = "baudbot.bench.Echo";
}

impl StreamingService<Message> for Echo {
    type Response = Message;
    type ResponseStream = Streaming<Message>;
    type Future = Ready<Result<tonic::Response<Self::ResponseStream>, Status>>;

    fn call(&mut self, request: tonic::Request<Streaming<Message>>) -> Self::Future {
        ready(Ok(tonic::Response::new(request.into_inner())))
    }
}

impl Service<Request<Body>> for Echo {
    type Response = Response<Body>;
    type Error = Infallible;
    type Future = Pin<Box<dyn Future<Output = Result<Self::Response, Infallible>> + Send>>;

    fn poll_ready(&mut self, _: &mut Context<'_>) -> Poll<Result<(), Infallible>> {
        Poll::Ready(Ok(()))
    }

    fn call(&mut self, request: Request<Body>) -> Self::Future {
        Box::pin(async move {
            let mut grpc = tonic::server::Grpc::new(ProstCodec::<Message, Message>::default());
            Ok(grpc.streaming(Self, request).await)
        })
    }
}

/// Exchanges a second between this process and another.
pub(crate) async fn measure(exchanges: u64) -> f64 {
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    let incoming = TcpIncoming::from(listener).with_nodelay(Some(true));
    let server = tokio::spawn(Server::builder().add_service(Echo).serve_with_incoming(incoming));
    let said = brains_process(&["ping", &address, &exchanges.to_string()]).await;
    server.abort();
    said.parse().expect("a rate")
}

/// The other process.
pub(crate) async fn ping(address: &str, exchanges: u64) -> f64 {
    let endpoint = Endpoint::from_shared(format!("http://{address}")).expect("an address");
    let endpoint = endpoint.tcp_nodelay(true).connect_timeout(Duration::from_secs(5));
    let mut grpc = tonic::client::Grpc::new(endpoint.connect().await.expect("connected"));
    grpc.ready().await.expect("ready");
    let (requests, queue) = mpsc::channel(16);
    requests.send(vec![7; BYTES]).await.expect("room");
    let codec = ProstCodec::<Message, Message>::default();
    let call = grpc.streaming(
        tonic::Request::new(ReceiverStream::new(queue)),
        PathAndQuery::from_static(PATH),
        codec,
    );
    let mut responses = call.await.expect("a call").into_inner();
    let mut begun = Instant::now();
    for i in 0..exchanges + WARM_UP {
        if i == WARM_UP {
            begun = Instant::now();
        }
        let message = responses.message().await.expect("a stream").expect("a message");
        requests.send(message).await.expect("room");
    }
    exchanges as f64 / begun.elapsed().as_secs_f64()
}

const WARM_UP: u64 = 1_000;
