//! The service that a brain finds in place of a world.

use std::pin::Pin;

use baudbot_proto::v1::brain_link_service_server::BrainLinkService;
use baudbot_proto::v1::{AttachRequest, AttachResponse};
use tokio::sync::mpsc;
use tokio_stream::Stream as Streaming;
use tokio_stream::wrappers::ReceiverStream;
use tonic::{Request, Response, Status};

use crate::relay::Relay;
use crate::spy::Spy;

/// The service: a spy, and a relay for each stream.
pub(crate) struct Service(pub(crate) Spy);

#[tonic::async_trait]
impl BrainLinkService for Service {
    type AttachStream = Pin<Box<dyn Streaming<Item = Result<AttachResponse, Status>> + Send>>;

    async fn attach(
        &self,
        request: Request<tonic::Streaming<AttachRequest>>,
    ) -> Result<Response<Self::AttachStream>, Status> {
        let authorization = request.metadata().get("authorization");
        let authorization = authorization.and_then(|value| value.to_str().ok()).map(str::to_owned);
        let number = self.0.begin(authorization);
        if let Some(refusal) = self.0.provocation.refusal() {
            return Err(refusal);
        }
        let (to_brain, responses) = mpsc::channel(1024);
        let relay = Relay::new(self.0.clone(), number, to_brain);
        tokio::spawn(relay.run(request.into_inner()));
        Ok(Response::new(Box::pin(ReceiverStream::new(responses))))
    }
}
