//! Bare bidirectional streams of tonic's. Alone, every message comes back; of several streams all are answered as soon as each
//! has brought a message: a barrier.

use std::convert::Infallible;
use std::future::ready;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};

use tokio::net::TcpListener;
use tokio::sync::mpsc;
use tokio::task::JoinSet;
use tokio_stream::wrappers::ReceiverStream;
use tokio_stream::{Stream, StreamExt};
use tonic::body::Body;
use tonic::codegen::http::uri::PathAndQuery;
use tonic::codegen::{BoxFuture, Service, http};
use tonic::server::{NamedService, StreamingService};
use tonic::transport::server::TcpIncoming;
use tonic::transport::{Channel, Endpoint, Server};
use tonic::{Request, Response, Status, Streaming};
use tonic_prost::ProstCodec;

use crate::child::Streams;

/// Bytes of a message, for each robot on its stream.
pub(super) const BYTES: usize = 64;

/// A message.
#[derive(Clone, PartialEq, prost::Message)]
struct Ball {
    #[prost(bytes = "vec", tag = "1")]
    bytes: Vec<u8>,
}

type Balls = Pin<Box<dyn Stream<Item = Result<Ball, Status>> + Send>>;

/// The other player.
#[derive(Clone)]
enum Opponent {
    /// The wall gives each message back.
    Wall,
    /// Answers so many streams together.
    Barrier {
        streams: usize,
        /// Messages that have come, each with the way of its answer.
        waiting: Arc<Mutex<Vec<Waiting>>>,
    },
}

type Waiting = (Ball, mpsc::Sender<Result<Ball, Status>>);

impl StreamingService<Ball> for Opponent {
    type Response = Ball;
    type ResponseStream = Balls;
    type Future = BoxFuture<Response<Balls>, Status>;

    fn call(&mut self, request: Request<Streaming<Ball>>) -> Self::Future {
        let balls = request.into_inner();
        let answers: Balls = match self {
            Self::Wall => Box::pin(balls.filter(Result::is_ok)),
            Self::Barrier { streams, waiting } => Box::pin(wait(balls, *streams, Arc::clone(waiting))),
        };
        Box::pin(ready(Ok(Response::new(answers))))
    }
}

/// The answers to a stream of several that are answered together.
fn wait(
    mut balls: Streaming<Ball>,
    streams: usize,
    waiting: Arc<Mutex<Vec<Waiting>>>,
) -> ReceiverStream<Result<Ball, Status>> {
    let (back, answers) = mpsc::channel(1);
    tokio::spawn(async move {
        while let Ok(Some(ball)) = balls.message().await {
            let mut waiting = waiting.lock().unwrap_or_else(PoisonError::into_inner);
            waiting.push((ball, back.clone()));
            if waiting.len() == streams {
                // There is room: each has taken the answer to its last message. A client that is gone gets none.
                waiting.drain(..).for_each(|(ball, back)| drop(back.try_send(Ok(ball))));
            }
        }
    });
    ReceiverStream::new(answers)
}

/// The service that would be generated from a contract: its only call is [`PATH`].
impl Service<http::Request<Body>> for Opponent {
    type Response = http::Response<Body>;
    type Error = Infallible;
    type Future = BoxFuture<Self::Response, Infallible>;

    fn poll_ready(&mut self, _: &mut Context<'_>) -> Poll<Result<(), Infallible>> {
        Poll::Ready(Ok(()))
    }

    fn call(&mut self, request: http::Request<Body>) -> Self::Future {
        let opponent = self.clone();
        let mut server = tonic::server::Grpc::new(ProstCodec::default());
        Box::pin(async move { Ok(server.streaming(opponent, request).await) })
    }
}

impl NamedService for Opponent {
    const NAME: &'static str = "baudbot.bench.PingService";
}

const PATH: &str = "/baudbot.bench.PingService/Play";

/// Serves so many streams on a free port of this machine, in the runtime that this is called in, and returns where.
pub(super) async fn serve(streams: usize) -> std::io::Result<SocketAddr> {
    let listener = TcpListener::bind("127.0.0.1:0").await?;
    let address = listener.local_addr()?;
    let incoming = TcpIncoming::from(listener).with_nodelay(Some(true));
    let opponent = match streams {
        1 => Opponent::Wall,
        _ => Opponent::Barrier { streams, waiting: Arc::default() },
    };
    let server = Server::builder().add_service(opponent);
    tokio::spawn(server.serve_with_incoming(incoming));
    Ok(address)
}

/// Connects to the address.
pub(super) async fn connect(address: &str) -> Result<Channel, Status> {
    let unavailable = |error: &dyn std::fmt::Display| Status::unavailable(error.to_string());
    let endpoint = Endpoint::from_shared(format!("http://{address}")).map_err(|e| unavailable(&e))?;
    endpoint.tcp_nodelay(true).connect().await.map_err(|e| unavailable(&e))
}

/// A player that throws and catches.
pub(super) struct Player {
    throw: mpsc::Sender<Ball>,
    catch: Streaming<Ball>,
    bytes: usize,
}

impl Player {
    /// Opens a stream for messages of so many bytes. The answer to the call comes at once.
    pub(super) async fn new(channel: Channel, bytes: usize) -> Result<Self, Status> {
        let (throw, balls) = mpsc::channel(1);
        let mut client = tonic::client::Grpc::new(channel);
        client.ready().await.map_err(|error| Status::unavailable(error.to_string()))?;
        let (request, path) = (Request::new(ReceiverStream::new(balls)), PathAndQuery::from_static(PATH));
        let call = client.streaming(request, path, ProstCodec::default()).await?;
        Ok(Self { throw, catch: call.into_inner(), bytes })
    }

    /// Plays a number of times there and back.
    pub(super) async fn play(&mut self, times: u64) -> Result<(), Status> {
        for _ in 0..times {
            let ball = Ball { bytes: vec![1; self.bytes] };
            self.throw.send(ball).await.map_err(|_| Status::aborted("the ping-pong's stream is closed"))?;
            let back = self.catch.message().await?;
            if back.is_none_or(|ball| ball.bytes.len() != self.bytes) {
                return Err(Status::data_loss("the ping-pong lost a ball"));
            }
        }
        Ok(())
    }
}

/// Players on streams of their own.
pub(super) struct Players(Vec<Player>);

impl Players {
    /// The players for as many robots, with streams like theirs, each message of [`BYTES`] for each robot on the
    /// stream.
    pub(super) async fn connect(address: &str, robots: usize, streams: Streams) -> Result<Self, Status> {
        let first = connect(address).await?;
        if streams == Streams::OneStream {
            return Ok(Self(vec![Player::new(first, BYTES * robots).await?]));
        }
        let mut players = Vec::new();
        for i in 0..robots {
            let alone = streams == Streams::Connections && i > 0;
            let channel = if alone { connect(address).await? } else { first.clone() };
            players.push(Player::new(channel, BYTES).await?);
        }
        Ok(Self(players))
    }

    /// Plays a number of times there and back, each player in a task of its own if there are several.
    pub(super) async fn play(&mut self, times: u64) -> Result<(), Status> {
        if let [alone] = self.0.as_mut_slice() {
            return alone.play(times).await;
        }
        let mut tasks = JoinSet::new();
        for mut player in std::mem::take(&mut self.0) {
            tasks.spawn(async move { player.play(times).await.map(|()| player) });
        }
        while let Some(done) = tasks.join_next().await {
            self.0.push(done.expect("a player does not panic")?);
        }
        Ok(())
    }
}
