//! Responses that end when the caller's token does.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::SystemTime;

use baudbot_access::Grant;
use bytes::Bytes;
use http_body::{Frame, SizeHint};
use tokio::time::{Sleep, sleep};
use tokio_stream::Stream;
use tokio_stream::wrappers::WatchStream;
use tonic::Status;
use tonic::body::Body;
use tonic::codegen::http::HeaderMap;

use super::Caller;
use super::tokens::Access;

/// The body of a response to the holder of a token. It ends with a status when the token is revoked, has expired, or is good for
/// something else than when the call began.
pub(crate) struct Guarded {
    body: Body,
    access: Access,
    grant: Arc<Grant>,
    changes: Option<WatchStream<()>>,
    /// The expiry of the token, if it is within the time that the clock can wait.
    expiry: Option<Pin<Box<Sleep>>>,
    is_over: bool,
}

impl Guarded {
    pub(crate) fn new(body: Body, access: Access, grant: Arc<Grant>) -> Self {
        let changes = access.changes().map(WatchStream::from_changes);
        let left = grant.expires_at.map(|end| end.duration_since(SystemTime::now()).unwrap_or_default());
        let expiry = left.map(|left| Box::pin(sleep(left)));
        Self { body, access, grant, changes, expiry, is_over: false }
    }

    /// The reason for its end here, if it ends.
    fn poll_end(&mut self, context: &mut Context<'_>) -> Option<Status> {
        let mut has_changed = false;
        while let Some(changes) = &mut self.changes
            && let Poll::Ready(change) = Pin::new(changes).poll_next(context)
        {
            has_changed = true;
            if change.is_none() {
                self.changes = None;
            }
        }
        if let Some(expiry) = &mut self.expiry
            && expiry.as_mut().poll(context).is_ready()
        {
            (has_changed, self.expiry) = (true, None);
        }
        if !has_changed {
            return None;
        }
        match self.access.still(&Caller::Holder(Arc::clone(&self.grant))) {
            Ok(Caller::Holder(grant)) if grant.rights != self.grant.rights => {
                Some(Status::permission_denied("the rights of the token have changed; call again"))
            }
            Ok(Caller::Holder(_) | Caller::Trusted | Caller::Nobody) => None,
            Err(refused) => Some(Status::unauthenticated(refused.to_string())),
        }
    }
}

impl http_body::Body for Guarded {
    type Data = Bytes;
    type Error = Status;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Status>>> {
        if self.is_over {
            return Poll::Ready(None);
        }
        if let Some(status) = self.poll_end(context) {
            // The body that makes the response goes, too: a brain's robots are released.
            (self.is_over, self.body) = (true, Body::empty());
            let mut trailers = HeaderMap::new();
            return Poll::Ready(Some(status.add_header(&mut trailers).map(|()| Frame::trailers(trailers))));
        }
        Pin::new(&mut self.body).poll_frame(context)
    }

    fn is_end_stream(&self) -> bool {
        self.is_over || self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        SizeHint::default()
    }
}
