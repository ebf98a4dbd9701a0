//! A bare bidirectional stream of tonic's: every message comes back.

use std::net::SocketAddr;
use std::pin::Pin;

use tokio::net::TcpListener;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tokio_stream::{Stream, StreamExt};
use tonic::transport::server::TcpIncoming;
use tonic::transport::{Endpoint, Server};
use tonic::{Request, Response, Status, Streaming};

use self::contract::Ball;
use self::contract::ping_service_client::PingServiceClient;
use self::contract::ping_service_server::{PingService, PingServiceServer};

#[allow(missing_docs, unreachable_pub, unused_qualifications, clippy::all, reason = "generated code")]
mod contract {
    include!("generated/baudbot.bench.rs");
}

/// Bytes of a message.
const BYTES: usize = 64;

struct Wall;

#[tonic::async_trait]
impl PingService for Wall {
    type PlayStream = Pin<Box<dyn Stream<Item = Result<Ball, Status>> + Send>>;

    async fn play(&self, request: Request<Streaming<Ball>>) -> Result<Response<Self::PlayStream>, Status> {
        let balls = request.into_inner();
        Ok(Response::new(Box::pin(balls.filter(Result::is_ok))))
    }
}

/// Serves it on a free port of this machine, in the runtime that this is called in, and says where.
pub(super) async fn serve() -> std::io::Result<SocketAddr> {
    let listener = TcpListener::bind("127.0.0.1:0").await?;
    let address = listener.local_addr()?;
    let incoming = TcpIncoming::from(listener).with_nodelay(Some(true));
    tokio::spawn(Server::builder().add_service(PingServiceServer::new(Wall)).serve_with_incoming(incoming));
    Ok(address)
}

/// One who throws and catches.
pub(super) struct Player {
    throw: mpsc::Sender<Ball>,
    catch: Streaming<Ball>,
}

impl Player {
    /// Connects to the address.
    pub(super) async fn connect(address: &str) -> Result<Self, Status> {
        let unavailable = |error: &dyn std::fmt::Display| Status::unavailable(error.to_string());
        let endpoint = Endpoint::from_shared(format!("http://{address}")).map_err(|e| unavailable(&e))?;
        let channel = endpoint.tcp_nodelay(true).connect().await.map_err(|e| unavailable(&e))?;
        let (throw, balls) = mpsc::channel(1);
        let call = PingServiceClient::new(channel).play(ReceiverStream::new(balls)).await?;
        Ok(Self { throw, catch: call.into_inner() })
    }

    /// So many times there and back.
    pub(super) async fn play(&mut self, times: u64) -> Result<(), Status> {
        for _ in 0..times {
            let ball = Ball { bytes: vec![1; BYTES] };
            self.throw.send(ball).await.map_err(|_| Status::aborted("the ping-pong's stream is closed"))?;
            let back = self.catch.message().await?;
            if back.is_none_or(|ball| ball.bytes.len() != BYTES) {
                return Err(Status::data_loss("the ping-pong lost a ball"));
            }
        }
        Ok(())
    }
}
