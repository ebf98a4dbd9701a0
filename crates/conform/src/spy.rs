//! The spy before a world: it knows what is to happen, and notes what is said.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use baudbot_proto::v1::brain_link_service_client::BrainLinkServiceClient;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_proto::v1::{self, AttachRequest, AttachResponse};
use tokio::sync::{Notify, mpsc};
use tokio::time::{Instant, sleep};
use tokio_stream::wrappers::ReceiverStream;
use tonic::transport::Channel;
use tonic::{Code, Status};

use crate::provocation::Provocation;
use crate::record::{Event, Record, Stream};
use crate::scene::WORLD;

/// The spy.
#[derive(Clone)]
pub(crate) struct Spy {
    pub(crate) provocation: Provocation,
    /// The server of the world.
    pub(crate) world: Channel,
    log: Arc<Log>,
}

struct Log {
    record: Mutex<Record>,
    /// Told whenever something is noted.
    news: Notify,
    /// Told when there is nothing more to see.
    done: Notify,
}

impl Spy {
    /// A spy before this server.
    pub(crate) fn new(provocation: Provocation, world: Channel) -> Self {
        let log = Log { record: Mutex::default(), news: Notify::new(), done: Notify::new() };
        Self { provocation, world, log: Arc::new(log) }
    }

    /// The record until now.
    pub(crate) fn record(&self) -> MutexGuard<'_, Record> {
        self.log.record.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until something is noted.
    pub(crate) async fn news(&self) {
        self.log.news.notified().await;
    }

    /// Waits until there is nothing more to see.
    pub(crate) async fn done(&self) {
        self.log.done.notified().await;
    }

    /// There is nothing more to see.
    pub(crate) fn finish(&self) {
        self.log.done.notify_one();
    }

    /// A new stream of the brain's; its number.
    pub(crate) fn begin(&self, authorization: Option<String>) -> usize {
        let number = {
            let mut record = self.record();
            record.streams.push(Stream { authorization, ..Stream::default() });
            record.streams.len() - 1
        };
        self.log.news.notify_one();
        number
    }

    /// Notes something on a stream.
    pub(crate) fn note(&self, stream: usize, event: Event) {
        self.on_stream(stream, |stream| stream.events.push(event));
    }

    /// Notes something of a stream.
    pub(crate) fn on_stream(&self, stream: usize, change: impl FnOnce(&mut Stream)) {
        if let Some(stream) = self.record().streams.get_mut(stream) {
            change(stream);
        }
        self.log.news.notify_one();
    }

    /// The operator of the world.
    pub(crate) fn operator(&self) -> ControlServiceClient<Channel> {
        ControlServiceClient::new(self.world.clone())
    }

    /// Resets the world. The spy is the only operator, so that nothing is in the way.
    pub(crate) async fn reset(&self) {
        let request = v1::ResetWorldRequest { world: WORLD.to_owned(), ..Default::default() };
        let _ = self.operator().reset_world(request).await;
    }

    /// Attaches to the world as the brain does. A stream of the brain's that has just ended may still hold the robots.
    pub(crate) async fn attach(
        &self,
        hello: v1::Hello,
    ) -> Result<(mpsc::Sender<AttachRequest>, tonic::Streaming<AttachResponse>), Status> {
        let patience = Instant::now() + FREED_WITHIN;
        loop {
            let (requests, sent) = mpsc::channel(1024);
            let hello = AttachRequest { request: Some(v1::attach_request::Request::Hello(hello.clone())) };
            let _ = requests.send(hello).await;
            let mut brain = BrainLinkServiceClient::new(self.world.clone());
            match brain.attach(ReceiverStream::new(sent)).await {
                Ok(answer) => return Ok((requests, answer.into_inner())),
                Err(status) if status.code() == Code::AlreadyExists && Instant::now() < patience => {
                    sleep(A_MOMENT).await;
                }
                Err(status) => return Err(status),
            }
        }
    }
}

/// The time in which the server frees the robots of a stream that has ended.
const FREED_WITHIN: Duration = Duration::from_secs(5);

const A_MOMENT: Duration = Duration::from_millis(10);
