//! The page's socket: calls of the gRPC services, many at a time on one WebSocket (`page.proto`).

use std::collections::HashMap;
use std::pin::pin;
use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use baudbot_proto::v1;
use baudbot_proto::v1::page_request::Request;
use baudbot_proto::v1::page_response::Response;
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use prost::Message as _;
use prost::bytes::Bytes;
use tokio::sync::{mpsc, watch};
use tokio::task::{AbortHandle, JoinSet};
use tokio::time::MissedTickBehavior;
use tonic::transport::Channel;
use tonic::{Status, Streaming};

use super::method::{Kind, Method};
use super::requests::{self, requests};
use crate::limits::Peer;
use crate::pipe::Pipes;

/// Calls of one page that are under way at a time.
const MAX_CALLS: usize = 64;

/// Responses that wait for a page that does not read. Frames beyond that are missed where they are made.
const RESPONSES_AHEAD: usize = 16;

/// How often a page is pinged. A page that sends nothing for twice as long is gone.
const PING: Duration = Duration::from_secs(20);

/// How long a page has to take the last responses.
const FAREWELL: Duration = Duration::from_secs(1);

/// A call that is under way.
struct Call {
    task: AbortHandle,
    /// Where further requests go, while the page may send any.
    requests: Option<requests::Sender>,
}

/// The calls of one page.
struct Calls {
    channel: Channel,
    responses: mpsc::Sender<v1::PageResponse>,
    under_way: HashMap<u32, Call>,
    /// Each task ends with the number of its call.
    tasks: JoinSet<u32>,
}

/// Serves a page until it is gone, or the server stops.
pub(super) async fn serve(socket: WebSocket, pipes: Pipes, peer: Peer, mut stopped: watch::Receiver<bool>) {
    let Ok(channel) = pipes.channel(peer).await else { return };
    let (sink, stream) = socket.split();
    let (responses, queue) = mpsc::channel(RESPONSES_AHEAD);
    let calls = Calls { channel, responses, under_way: HashMap::new(), tasks: JoinSet::new() };
    let mut write = pin!(write(sink, queue));
    tokio::select! {
        () = listen(stream, calls) => {}
        () = &mut write => return,
        _ = stopped.wait_for(|stopped| *stopped) => {}
    }
    // All calls are dropped by now, so nothing is written but what waits in the queue.
    let _ = tokio::time::timeout(FAREWELL, write).await;
}

async fn listen(mut stream: SplitStream<WebSocket>, mut calls: Calls) {
    loop {
        tokio::select! {
            message = tokio::time::timeout(2 * PING, stream.next()) => match message {
                Ok(Some(Ok(Message::Binary(bytes)))) => {
                    let Ok(request) = v1::PageRequest::decode(bytes) else { return };
                    calls.take(request).await;
                }
                // A pong shows that the page is still there.
                Ok(Some(Ok(Message::Pong(_) | Message::Ping(_)))) => {}
                Ok(Some(Ok(Message::Text(_) | Message::Close(_)) | Err(_)) | None) | Err(_) => return,
            },
            Some(done) = calls.tasks.join_next() => {
                if let Ok(call) = done {
                    calls.under_way.remove(&call);
                }
            }
        }
    }
}

async fn write(mut sink: SplitSink<WebSocket, Message>, mut queue: mpsc::Receiver<v1::PageResponse>) {
    // Pings go out whatever else is sent: a page that only watches sends nothing but pongs.
    let mut ping = tokio::time::interval(PING);
    ping.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        let message = tokio::select! {
            response = queue.recv() => match response {
                Some(response) => Message::Binary(response.encode_to_vec().into()),
                None => break,
            },
            _ = ping.tick() => Message::Ping(Vec::new().into()),
        };
        if sink.send(message).await.is_err() {
            return;
        }
    }
    let close = CloseFrame { code: close_code::AWAY, reason: "the server is done with this page".into() };
    let _ = sink.send(Message::Close(Some(close))).await;
}

impl Calls {
    async fn take(&mut self, v1::PageRequest { call, request }: v1::PageRequest) {
        let under_way = self.under_way.get(&call);
        match (request, under_way) {
            (Some(Request::Close(_)), Some(_)) => self.close(call).await,
            // The call was over before the page knew.
            (Some(Request::Close(_)), None) => {}
            (Some(Request::Next(request)), Some(Call { requests: Some(requests), .. })) => {
                requests.send(request.into());
                self.respond(call, Response::Taken(v1::Taken {})).await;
            }
            (Some(Request::Next(_)), None) => {
                self.fail(call, &Status::failed_precondition("next: the call is not under way")).await;
            }
            (_, Some(_)) => self.fail(call, &Status::already_exists("call: is under way")).await,
            (None, None) => {
                self.fail(call, &Status::invalid_argument("request: must be set")).await;
            }
            (Some(Request::Begin(_)), None) if self.under_way.len() >= MAX_CALLS => {
                let text = format!("{MAX_CALLS} calls are under way, which is the limit");
                self.fail(call, &Status::resource_exhausted(text)).await;
            }
            (Some(Request::Begin(begin)), None) => match Method::find(&begin.method) {
                Ok(method) => self.begin(call, method, begin.request.into()),
                Err(status) => self.fail(call, &status).await,
            },
        }
    }

    fn begin(&mut self, call: u32, method: Method, request: Bytes) {
        let channel = self.channel.clone();
        let responses = Responses { call, queue: self.responses.clone() };
        let mut sender = None;
        let task = match method.kind {
            Kind::Unary => self.spawn(call, async move {
                responses.send(Response::Message(method.unary(channel, request).await?.into())).await;
                Ok(())
            }),
            Kind::ServerStreaming => self.spawn(call, async move {
                responses.forward(method.server_streaming(channel, request).await?).await
            }),
            Kind::ClientStreaming => {
                let (requests_sender, requests) = requests(request);
                sender = Some(requests_sender);
                self.spawn(call, async move {
                    responses.forward(method.client_streaming(channel, requests).await?).await
                })
            }
        };
        self.under_way.insert(call, Call { task, requests: sender });
    }

    fn spawn(
        &mut self,
        call: u32,
        work: impl Future<Output = Result<(), Status>> + Send + 'static,
    ) -> AbortHandle {
        let queue = self.responses.clone();
        self.tasks.spawn(async move {
            if let Err(status) = work.await {
                let _ = queue.send(failure(call, &status)).await;
            }
            call
        })
    }

    async fn close(&mut self, call: u32) {
        // The last requests of a stream still reach the service, which then ends the stream, and with it the call.
        if let Some(Call { requests: requests @ Some(_), .. }) = self.under_way.get_mut(&call) {
            *requests = None;
        } else if let Some(Call { task, .. }) = self.under_way.remove(&call) {
            task.abort();
            self.respond(call, Response::Closed(v1::Closed {})).await;
        }
    }

    async fn fail(&self, call: u32, status: &Status) {
        let _ = self.responses.send(failure(call, status)).await;
    }

    async fn respond(&self, call: u32, response: Response) {
        let _ = self.responses.send(v1::PageResponse { call, response: Some(response) }).await;
    }
}

/// Where the responses of a call go.
struct Responses {
    call: u32,
    queue: mpsc::Sender<v1::PageResponse>,
}

impl Responses {
    /// Waits for room in the queue; `false` if the page is gone.
    async fn send(&self, response: Response) -> bool {
        self.queue.send(v1::PageResponse { call: self.call, response: Some(response) }).await.is_ok()
    }

    /// Passes on what comes, no faster than the page reads, and then that the call is over.
    async fn forward(&self, mut stream: Streaming<Bytes>) -> Result<(), Status> {
        while let Some(message) = stream.message().await? {
            if !self.send(Response::Message(message.into())).await {
                return Ok(());
            }
        }
        self.send(Response::Closed(v1::Closed {})).await;
        Ok(())
    }
}

fn failure(call: u32, status: &Status) -> v1::PageResponse {
    let code = format!("{:?}", status.code());
    // As gRPC writes it: NotFound is NOT_FOUND.
    let mut name = String::new();
    for (i, c) in code.chars().enumerate() {
        if i > 0 && c.is_ascii_uppercase() {
            name.push('_');
        }
        name.push(c.to_ascii_uppercase());
    }
    let failure = v1::Failure { code: name, message: status.message().to_owned() };
    v1::PageResponse { call, response: Some(Response::Failure(failure)) }
}
