//! A server without a network, in the program of its only client: a page that has the world in it.
//!
//! # Need
//!
//! In a browser there are neither sockets nor threads. A page there still speaks to a server, with the worlds and the services of any
//! other, and knows no difference.
//!
//! # Mechanism
//!
//! Its worlds are tasks of the runtime in which it is made ([`pool`](crate::pool)). What a page sends over its socket elsewhere comes
//! through a channel ([`calls`](crate::calls)), and clients in the same program call its services as functions. Everybody who can is this
//! process, and may do everything.

use std::convert::Infallible;
use std::path::PathBuf;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use bytes::Bytes;
use futures_util::stream;
use tokio::sync::mpsc;
use tonic::Status;
use tonic::body::Body;
use tonic::codegen::BoxFuture;
use tonic::codegen::http::{Request, Response};
use tonic::server::NamedService;
use tower::Service;

use crate::access::Caller;
use crate::brain_link::{BrainLink, BrainLinkServer};
use crate::calls::{RESPONSES_AHEAD, take_calls};
use crate::control::{Control, ControlServer, Told};
use crate::limits::{InForce, Limits};
use crate::message::Message;
use crate::observe::{Observe, ObserveServer};
use crate::recording::Folder;
use crate::registry::Registry;

/// A server without a network and without threads. Its worlds are stopped when this is dropped and all clients are gone.
pub struct Embedded {
    services: Services,
}

/// The services of an [`Embedded`] server, for gRPC clients of package `baudbot.v1` in the same program. Clones share them.
#[derive(Clone)]
pub struct Services {
    registry: Registry,
    control: ControlServer,
    observe: ObserveServer,
    brain_link: BrainLinkServer,
}

impl Embedded {
    /// A server without worlds. Its recordings are in this folder, which must be there.
    pub fn new(limits: Limits, recordings: PathBuf) -> Self {
        let registry = Registry::new(InForce::new(limits)).without_threads();
        let observe = Observe { registry: registry.clone() };
        let brain_link = BrainLink { registry: registry.clone(), patience: PATIENCE };
        let control = Control {
            registry: registry.clone(),
            recordings: Some(Folder::new(recordings)),
            told: Told::default(),
        };
        Self {
            services: Services {
                registry,
                control: ControlServer::new(Arc::new(control), crate::calls::MAX_MESSAGE),
                observe: ObserveServer::new(observe),
                brain_link: BrainLinkServer::new(brain_link),
            },
        }
    }

    /// The server's services.
    pub fn services(&self) -> Services {
        self.services.clone()
    }

    /// A page: what it sends, and what it is sent (`page.proto`). It is served by a task until it sends nothing more.
    pub fn page(&self) -> (mpsc::UnboundedSender<Bytes>, mpsc::Receiver<Bytes>) {
        let (requests, messages) = mpsc::unbounded_channel();
        let (responses, queue) = mpsc::channel(RESPONSES_AHEAD);
        let services = self.services();
        tokio::spawn(async move {
            let messages = stream::unfold(messages, async |mut messages: mpsc::UnboundedReceiver<Bytes>| {
                Some((messages.recv().await?, messages))
            });
            take_calls(std::pin::pin!(messages), services, responses).await;
        });
        (requests, queue)
    }
}

impl Services {
    /// The seed of a world's run.
    ///
    /// # Errors
    /// If there is no such world, or it is going.
    pub async fn seed(&self, world: &str) -> Result<u64, Status> {
        let standing = self.registry.find("world", world)?.ask(|reply| Message::Stand(None, reply)).await?;
        let report = standing.report.ok_or_else(|| Status::internal("a world without a report"))?;
        Ok(report.world.scenario().seed)
    }
}

/// Services by the path of a method, `/SERVICE/METHOD`. A router for any services is larger than what it leads to here.
impl Service<Request<Body>> for Services {
    type Response = Response<Body>;
    type Error = Infallible;
    type Future = BoxFuture<Response<Body>, Infallible>;

    fn poll_ready(&mut self, _: &mut Context<'_>) -> Poll<Result<(), Infallible>> {
        Poll::Ready(Ok(()))
    }

    fn call(&mut self, mut request: Request<Body>) -> Self::Future {
        request.extensions_mut().insert(Caller::Trusted);
        match request.uri().path().split('/').nth(1) {
            Some(ControlServer::NAME) => self.control.call(request),
            Some(ObserveServer::NAME) => self.observe.call(request),
            Some(BrainLinkServer::NAME) => self.brain_link.call(request),
            _ => Box::pin(async { Ok(Status::unimplemented("").into_http()) }),
        }
    }
}

/// The time for which a brain's stream may be open without a Hello.
const PATIENCE: Duration = Duration::from_secs(10);
