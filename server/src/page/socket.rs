//! The page's socket: calls of the gRPC services, many at a time on one WebSocket.

use std::collections::HashMap;
use std::pin::pin;
use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use baudbot_proto::v1;
use baudbot_proto::v1::brain_link_service_client::BrainLinkServiceClient;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_proto::v1::observe_service_client::ObserveServiceClient;
use baudbot_proto::v1::page_request::Request as Asked;
use baudbot_proto::v1::page_response::Response as Answer;
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use prost::Message as _;
use tokio::sync::{mpsc, watch};
use tokio::task::{AbortHandle, JoinSet};
use tokio::time::MissedTickBehavior;
use tonic::transport::Channel;
use tonic::{Response, Status, Streaming};

use super::mailbox::{self, Mailbox};
use crate::pipe::Pipes;

/// Bytes of the longest message: a scenario, and a little around it.
pub(super) const MAX_MESSAGE: usize = baudbot_scenario::MAX_BYTES + (1 << 16);

/// Calls of one page that are under way at a time.
const MAX_CALLS: usize = 64;

/// Answers that wait for a page that does not read. Frames beyond that are missed where they are made.
const ANSWERS_AHEAD: usize = 16;

/// How often a page is asked whether it is there; who says nothing for twice as long is not.
const PING: Duration = Duration::from_secs(20);

/// How long a page has to take what is left for it.
const FAREWELL: Duration = Duration::from_secs(1);

/// A call that is under way.
struct Call {
    task: AbortHandle,
    /// Of an Attach: where further requests go.
    steps: Option<mailbox::Sender>,
}

/// The calls of one page.
struct Calls {
    channel: Channel,
    answers: mpsc::Sender<v1::PageResponse>,
    under_way: HashMap<u32, Call>,
    /// Each ends with the number of its call.
    tasks: JoinSet<u32>,
}

/// Serves a page until it is gone, or the server stops.
pub(super) async fn serve(socket: WebSocket, pipes: Pipes, mut stopped: watch::Receiver<bool>) {
    let Ok(channel) = pipes.channel().await else { return };
    let (sink, stream) = socket.split();
    let (answers, queue) = mpsc::channel(ANSWERS_AHEAD);
    let calls = Calls { channel, answers, under_way: HashMap::new(), tasks: JoinSet::new() };
    let mut write = pin!(write(sink, queue));
    tokio::select! {
        () = listen(stream, calls) => {}
        () = &mut write => return,
        _ = stopped.wait_for(|stopped| *stopped) => {}
    }
    // All calls are over, so nothing more is written but that.
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
                // A pong says that somebody is there.
                Ok(Some(Ok(Message::Pong(_) | Message::Ping(_)))) => {}
                _ => return,
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
    // Whatever is sent meanwhile: a page that only looks says nothing but pongs.
    let mut ping = tokio::time::interval(PING);
    ping.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        let message = tokio::select! {
            answer = queue.recv() => match answer {
                Some(answer) => Message::Binary(answer.encode_to_vec().into()),
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
            (Some(Asked::Close(_)), Some(_)) => self.close(call).await,
            (Some(Asked::Close(_)), None) => {}
            (Some(Asked::Attach(step)), Some(Call { steps: Some(steps), .. })) => {
                steps.send(step);
                let _ = self.answers.send(answer(call, Answer::Taken(v1::Taken {}))).await;
            }
            (_, Some(_)) => self.fail(call, &Status::already_exists("call: is under way")).await,
            (None, None) => {
                self.fail(call, &Status::invalid_argument("request: must be set")).await;
            }
            (Some(_), None) if self.under_way.len() >= MAX_CALLS => {
                let text = format!("{MAX_CALLS} calls are under way, which is the limit");
                self.fail(call, &Status::resource_exhausted(text)).await;
            }
            (Some(asked), None) => self.begin(call, asked),
        }
    }

    fn begin(&mut self, call: u32, asked: Asked) {
        let (channel, answers) = (self.channel.clone(), self.answers.clone());
        let mut steps = None;
        let task = match asked {
            Asked::Watch(request) => self.spawn(call, watch_world(channel, call, request, answers)),
            Asked::Attach(first) => {
                let (sender, requests) = mailbox::mailbox();
                sender.send(first);
                steps = Some(sender);
                self.spawn(call, attach(channel, call, requests, answers))
            }
            asked => self.spawn(call, once(channel, call, asked, answers)),
        };
        self.under_way.insert(call, Call { task, steps });
    }

    fn spawn(
        &mut self,
        call: u32,
        work: impl Future<Output = Result<(), Status>> + Send + 'static,
    ) -> AbortHandle {
        let answers = self.answers.clone();
        self.tasks.spawn(async move {
            if let Err(status) = work.await {
                let _ = answers.send(failure(call, &status)).await;
            }
            call
        })
    }

    async fn close(&mut self, call: u32) {
        // A brain's last requests still go out; the server then ends the stream, and with it the call.
        if let Some(Call { steps: steps @ Some(_), .. }) = self.under_way.get_mut(&call) {
            *steps = None;
        } else if let Some(Call { task, .. }) = self.under_way.remove(&call) {
            task.abort();
            let _ = self.answers.send(answer(call, Answer::Closed(v1::Closed {}))).await;
        }
    }

    async fn fail(&self, call: u32, status: &Status) {
        let _ = self.answers.send(failure(call, status)).await;
    }
}

fn answer(call: u32, response: Answer) -> v1::PageResponse {
    v1::PageResponse { call, response: Some(response) }
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
    answer(call, Answer::Failure(failure))
}

type Answers = mpsc::Sender<v1::PageResponse>;

async fn watch_world(
    channel: Channel,
    call: u32,
    request: v1::WatchRequest,
    answers: Answers,
) -> Result<(), Status> {
    // Of many robots a frame is long.
    let mut client = ObserveServiceClient::new(channel).max_decoding_message_size(MAX_MESSAGE);
    let frames = client.watch(request).await?.into_inner();
    forward(frames, call, Answer::Watch, &answers).await
}

async fn attach(channel: Channel, call: u32, requests: Mailbox, answers: Answers) -> Result<(), Status> {
    let mut client = BrainLinkServiceClient::new(channel).max_decoding_message_size(MAX_MESSAGE);
    let responses = client.attach(requests).await?.into_inner();
    forward(responses, call, Answer::Attach, &answers).await
}

/// Passes on what comes, no faster than the page reads.
async fn forward<T>(
    mut stream: Streaming<T>,
    call: u32,
    wrap: impl Fn(T) -> Answer,
    answers: &Answers,
) -> Result<(), Status> {
    while let Some(message) = stream.message().await? {
        if answers.send(answer(call, wrap(message))).await.is_err() {
            return Ok(());
        }
    }
    let _ = answers.send(answer(call, Answer::Closed(v1::Closed {}))).await;
    Ok(())
}

/// A call with one answer.
async fn once(channel: Channel, call: u32, asked: Asked, answers: Answers) -> Result<(), Status> {
    let response = unary(channel, asked).await?;
    let _ = answers.send(answer(call, response)).await;
    Ok(())
}

async fn unary(channel: Channel, asked: Asked) -> Result<Answer, Status> {
    let mut control = ControlServiceClient::new(channel.clone())
        .max_encoding_message_size(MAX_MESSAGE)
        .max_decoding_message_size(MAX_MESSAGE);
    let mut observe = ObserveServiceClient::new(channel).max_decoding_message_size(MAX_MESSAGE);
    Ok(match asked {
        Asked::ListWorlds(r) => Answer::ListWorlds(inner(control.list_worlds(r).await)?),
        Asked::CreateWorld(r) => Answer::CreateWorld(inner(control.create_world(r).await)?),
        Asked::GetWorld(r) => Answer::GetWorld(inner(control.get_world(r).await)?),
        Asked::StartWorld(r) => Answer::StartWorld(inner(control.start_world(r).await)?),
        Asked::PauseWorld(r) => Answer::PauseWorld(inner(control.pause_world(r).await)?),
        Asked::StepWorld(r) => Answer::StepWorld(inner(control.step_world(r).await)?),
        Asked::SetPace(r) => Answer::SetPace(inner(control.set_pace(r).await)?),
        Asked::ResetWorld(r) => Answer::ResetWorld(inner(control.reset_world(r).await)?),
        Asked::SnapshotWorld(r) => Answer::SnapshotWorld(inner(control.snapshot_world(r).await)?),
        Asked::RestoreWorld(r) => Answer::RestoreWorld(inner(control.restore_world(r).await)?),
        Asked::DeleteWorld(r) => Answer::DeleteWorld(inner(control.delete_world(r).await)?),
        Asked::Intervene(r) => Answer::Intervene(inner(control.intervene(r).await)?),
        Asked::GetBudget(r) => Answer::GetBudget(inner(control.get_budget(r).await)?),
        Asked::SaveWorld(r) => Answer::SaveWorld(inner(control.save_world(r).await)?),
        Asked::StartRecording(r) => Answer::StartRecording(inner(control.start_recording(r).await)?),
        Asked::StopRecording(r) => Answer::StopRecording(inner(control.stop_recording(r).await)?),
        Asked::ListRecordings(r) => Answer::ListRecordings(inner(control.list_recordings(r).await)?),
        Asked::OpenRecording(r) => Answer::OpenRecording(inner(control.open_recording(r).await)?),
        Asked::DescribeReplay(r) => Answer::DescribeReplay(inner(control.describe_replay(r).await)?),
        Asked::SeekReplay(r) => Answer::SeekReplay(inner(control.seek_replay(r).await)?),
        Asked::ForkReplay(r) => Answer::ForkReplay(inner(control.fork_replay(r).await)?),
        Asked::DescribeWorld(r) => Answer::DescribeWorld(inner(observe.describe_world(r).await)?),
        Asked::GetCoverage(r) => Answer::GetCoverage(inner(observe.get_coverage(r).await)?),
        // Streams, and what is no call, do not come here.
        Asked::Watch(_) | Asked::Attach(_) | Asked::Close(_) => {
            return Err(Status::internal("request: is no call with one answer"));
        }
    })
}

fn inner<T>(response: Result<Response<T>, Status>) -> Result<T, Status> {
    response.map(Response::into_inner)
}
