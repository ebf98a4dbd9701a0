//! The observers' service.

use std::pin::Pin;

use baudbot_proto::v1;
use baudbot_proto::v1::observe_service_server::ObserveService;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tokio_stream::{Stream, StreamExt};
use tonic::{Request, Response, Status};

use crate::convert;
use crate::letter::Letter;
use crate::registry::Registry;

/// Frames that wait for an observer before it misses some.
const FRAMES_AHEAD: usize = 8;

/// Frames a simulated second that an observer gets who does not say.
const DEFAULT_RATE_HZ: u64 = 20;

pub(crate) struct Observe {
    pub(crate) registry: Registry,
}

#[tonic::async_trait]
impl ObserveService for Observe {
    async fn describe_world(
        &self,
        request: Request<v1::DescribeWorldRequest>,
    ) -> Result<Response<v1::DescribeWorldResponse>, Status> {
        let world = self.registry.find("world", &request.get_ref().world)?;
        let scenario = world.ask(Letter::Describe).await?;
        Ok(Response::new(convert::world_description(&scenario)))
    }

    type WatchStream = Pin<Box<dyn Stream<Item = Result<v1::WatchResponse, Status>> + Send>>;

    async fn watch(&self, request: Request<v1::WatchRequest>) -> Result<Response<Self::WatchStream>, Status> {
        let v1::WatchRequest { world, every_ticks } = request.into_inner();
        let world = self.registry.find("world", &world)?;
        let every_ticks = match every_ticks {
            0 => 1_000_000_000 / DEFAULT_RATE_HZ / world.ask(Letter::Describe).await?.step_ns(),
            ticks => ticks,
        };
        let (frames, stream) = mpsc::channel(FRAMES_AHEAD);
        world.send(Letter::Watch { every_ticks, frames })?;
        let stream = ReceiverStream::new(stream).map(|frame| Ok(convert::frame(frame)));
        Ok(Response::new(Box::pin(stream)))
    }
}
