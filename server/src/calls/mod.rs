//! Calls of the services by name and bytes, many at a time in one stream of messages (`page.proto`): those of a page over its socket, or in
//! memory.

mod method;
mod requests;

use std::collections::HashMap;
use std::pin::Pin;
use std::sync::Arc;

use baudbot_proto::v1;
use baudbot_proto::v1::page_request::Request;
use baudbot_proto::v1::page_response::Response;
use futures_util::StreamExt;
use prost::Message as _;
use prost::bytes::Bytes;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc};
use tokio::task::{AbortHandle, JoinSet};
use tokio_stream::Stream;
use tonic::{Status, Streaming};

pub(crate) use method::Services;
use method::{Kind, Method};
use requests::requests;

/// Bytes of the longest message: a scenario, and a little around it.
pub(crate) const MAX_MESSAGE: usize = baudbot_scenario::MAX_BYTES + (1 << 16);

/// Responses that wait for a page that does not read. Frames beyond that are missed where they are made.
pub(crate) const RESPONSES_AHEAD: usize = 16;

/// The most kilobytes of these responses.
const KILOBYTES_AHEAD: usize = 1 << 10;

/// Calls of one page that are under way at a time.
const MAX_CALLS: usize = 64;

/// A call that is under way.
struct Call {
    task: AbortHandle,
    /// The channel for further requests, while the page may send any.
    requests: Option<requests::Sender>,
}

/// The calls of one page.
struct Calls<S> {
    services: S,
    responses: Queue,
    under_way: HashMap<u32, Call>,
    /// Each task ends with the number of its call.
    tasks: JoinSet<u32>,
}

/// Takes the calls of a page until it sends nothing more, or what is none. Its responses go to the sender.
pub(crate) async fn take_calls<S: Services>(
    mut messages: Pin<&mut (impl Stream<Item = Bytes> + ?Sized)>,
    services: S,
    responses: mpsc::Sender<Bytes>,
) {
    let responses = Queue { sender: responses, room: Arc::new(Semaphore::new(KILOBYTES_AHEAD)) };
    let mut calls = Calls { services, responses, under_way: HashMap::new(), tasks: JoinSet::new() };
    loop {
        tokio::select! {
            message = messages.next() => {
                let Some(Ok(request)) = message.map(v1::PageRequest::decode) else { return };
                calls.take(request).await;
            }
            Some(done) = calls.tasks.join_next() => {
                if let Ok(call) = done {
                    calls.under_way.remove(&call);
                }
            }
        }
    }
}

impl<S: Services> Calls<S> {
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
        let services = self.services.clone();
        let responses = Responses { call, queue: self.responses.clone() };
        let mut sender = None;
        let task = match method.kind {
            Kind::Unary => self.spawn(call, async move {
                responses.send(Response::Message(method.unary(services, request).await?.into())).await;
                Ok(())
            }),
            Kind::ServerStreaming => self.spawn(call, async move {
                responses.forward(method.server_streaming(services, request).await?).await
            }),
            Kind::ClientStreaming => {
                let (requests_sender, requests) = requests(request);
                sender = Some(requests_sender);
                self.spawn(call, async move {
                    responses.forward(method.client_streaming(services, requests).await?).await
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
                queue.send(failure(call, &status)).await;
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
        self.responses.send(failure(call, status)).await;
    }

    async fn respond(&self, call: u32, response: Response) {
        self.responses.send(v1::PageResponse { call, response: Some(response) }).await;
    }
}

/// The destination of a call's responses.
struct Responses {
    call: u32,
    queue: Queue,
}

impl Responses {
    /// Waits for room in the queue; `false` if the page is gone.
    async fn send(&self, response: Response) -> bool {
        let response = v1::PageResponse { call: self.call, response: Some(response) };
        self.queue.send(response).await
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
    // The name is converted to gRPC's form: NotFound is NOT_FOUND.
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

/// The queue of a page: so many responses, and so many bytes, unless it is a single long one.
#[derive(Clone)]
struct Queue {
    sender: mpsc::Sender<Bytes>,
    /// The room that is left, in kilobytes.
    room: Arc<Semaphore>,
}

impl Queue {
    /// Waits for room; `false` if the page is gone.
    async fn send(&self, response: v1::PageResponse) -> bool {
        let bytes = response.encode_to_vec();
        let kilobytes = bytes.len().div_ceil(1 << 10).clamp(1, KILOBYTES_AHEAD);
        let needed = u32::try_from(kilobytes).unwrap_or(u32::MAX);
        let room = tokio::select! {
            room = Arc::clone(&self.room).acquire_many_owned(needed) => room,
            () = self.sender.closed() => return false,
        };
        let Ok(room) = room else { return false };
        self.sender.send(Bytes::from_owner(Waiting { bytes, _room: room })).await.is_ok()
    }
}

/// A response that takes room until it is written.
struct Waiting {
    bytes: Vec<u8>,
    _room: OwnedSemaphorePermit,
}

impl AsRef<[u8]> for Waiting {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

#[cfg(test)]
mod tests {
    use futures_util::FutureExt as _;

    use super::*;

    #[tokio::test]
    async fn a_page_that_does_not_read_has_a_megabyte_waiting_and_not_sixteen_messages() {
        let (sender, mut waiting) = mpsc::channel(RESPONSES_AHEAD);
        let queue = Queue { sender, room: Arc::new(Semaphore::new(KILOBYTES_AHEAD)) };
        let long = || v1::PageResponse { call: 1, response: Some(Response::Message(vec![0; 300 << 10])) };
        let sent =
            (0..RESPONSES_AHEAD).take_while(|_| queue.send(long()).now_or_never() == Some(true)).count();
        assert_eq!(sent, 3);
        drop(waiting.recv().await);
        assert_eq!(queue.send(long()).now_or_never(), Some(true), "what is read makes room");
        drop(waiting);
        assert!(!queue.send(long()).await, "the page is gone");
    }
}
