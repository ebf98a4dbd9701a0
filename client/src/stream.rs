//! The two directions of an Attach call, in gRPC's form.

use baudbot_proto::v1::brain_link_service_client::BrainLinkServiceClient;
use baudbot_proto::v1::{AttachRequest, AttachResponse};
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::{Status, Streaming};

use crate::channel::Channel;

/// An Attach call.
#[derive(Debug)]
pub(crate) struct Stream {
    requests: mpsc::Sender<AttachRequest>,
    responses: Streaming<AttachResponse>,
    closed: bool,
}

impl Stream {
    /// Opens the call with its first request: a server may wait for that before it answers at all.
    pub(crate) async fn open(channel: Channel, hello: AttachRequest) -> Result<Self, Status> {
        let (requests, queue) = mpsc::channel(QUEUE);
        // The queue is new and has room, and its other end is in our hands.
        let _ = requests.try_send(hello);
        let mut client = BrainLinkServiceClient::new(channel).max_decoding_message_size(LARGEST);
        let call = client.attach(ReceiverStream::new(queue)).await?;
        Ok(Self { requests, responses: call.into_inner(), closed: false })
    }

    /// Sends a request. If the server has ended the call, the request is lost and this gives the error with which it
    /// ended; if it ended in good order, that is left for [`receive`](Self::receive).
    pub(crate) async fn send(&mut self, request: AttachRequest) -> Result<(), Status> {
        if self.requests.send(request).await.is_err() {
            while self.receive().await?.is_some() {}
        }
        Ok(())
    }

    /// The next response; `None` once the server has closed the stream in good order.
    pub(crate) async fn receive(&mut self) -> Result<Option<AttachResponse>, Status> {
        if self.closed {
            return Ok(None);
        }
        let response = self.responses.message().await;
        self.closed = !matches!(response, Ok(Some(_)));
        response
    }

    pub(crate) fn is_closed(&self) -> bool {
        self.closed
    }
}

/// Largest response that is read, in bytes: a camera's images of the time that a slow brain thought.
const LARGEST: usize = 64 << 20;

/// Requests that may wait to be sent; a brain that is faster than its network then waits too.
const QUEUE: usize = 16;
