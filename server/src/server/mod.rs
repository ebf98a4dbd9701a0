//! The server: its listeners, its services, and its end.

mod builder;
mod listeners;

use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use baudbot_proto::v1;
use baudbot_proto::v1::control_service_server::ControlServiceServer;
use baudbot_proto::v1::observe_service_server::ObserveServiceServer;
use tokio::net::TcpListener;
use tokio::sync::{mpsc, watch};
use tokio::task::JoinSet;
use tokio_stream::Stream;
use tonic::service::InterceptorLayer;
use tonic::transport::server::Connected;
use tonic::transport::{Channel, Server as Transport};
use tonic::{Request, Status};
use tower::layer::util::{Identity, Stack};

use crate::address::Address;
use crate::brain_link::{BrainLink, BrainLinkServer};
use crate::control::{Control, status_of, stop_recording};
use crate::gate::{Gate, GatedListener, check_call, connections};
use crate::message::Message;
use crate::metrics::Metrics;
use crate::observe::Observe;
use crate::page::{self, Film};
use crate::pipe::Pipes;
use crate::registry::Registry;
use crate::report::Report;
pub use builder::{Builder, WorldConfig};
use listeners::{Listener, SocketFile};

/// How often a silent connection is pinged, and how long it has to answer.
const KEEPALIVE: Duration = Duration::from_secs(20);

/// Why a server did not start.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// An address could not be listened on.
    #[error("cannot listen on {address}")]
    Bind {
        /// The address.
        address: Address,
        /// Why.
        source: io::Error,
    },
    /// An address that other machines can reach, although the builder does not allow it.
    #[error(
        "{address} can be reached from other machines, and this server has no authentication; listen on 127.0.0.1, or allow it with --insecure"
    )]
    NotLoopback {
        /// The address.
        address: Address,
    },
    /// A world could not be made.
    #[error("{}", .0.message())]
    World(Box<Status>),
    /// The services could not be described for reflection.
    #[error("reflection: {0}")]
    Reflection(#[from] tonic_reflection::server::Error),
    /// The in-process pipe does not connect.
    #[error("in-process pipe: {0}")]
    Pipe(#[from] tonic::transport::Error),
}

/// A running server. Dropping it stops its worlds; [`shutdown`](Self::shutdown) also waits until they are over.
pub struct Server {
    registry: Registry,
    addresses: Vec<Address>,
    viewers: Vec<SocketAddr>,
    sockets: Vec<SocketFile>,
    pipes: Pipes,
    stop: watch::Sender<bool>,
    tasks: JoinSet<()>,
}

impl Server {
    /// A builder of a server.
    pub fn builder() -> Builder {
        Builder::default()
    }

    async fn start(
        control: Control,
        gate: Gate,
        listeners: Vec<Listener>,
        pages: Vec<TcpListener>,
        films: Option<mpsc::Sender<Film>>,
    ) -> Result<Self, ServerError> {
        let registry = control.registry.clone();
        let router = router(control, gate.patience()).await?;
        let (stop, stopped) = watch::channel(false);
        let (pipes, incoming) = Pipes::new();
        let mut tasks = JoinSet::new();
        let mut addresses = Vec::new();
        let mut sockets = Vec::new();
        let mut viewers = Vec::new();
        for listener in listeners {
            addresses.push(listener.address().clone());
            if let Address::Unix(path) = listener.address() {
                sockets.extend(SocketFile::at(path));
            }
            let (router, gate, stopped) = (router.clone(), gate.clone(), stopped.clone());
            match listener {
                Listener::Tcp(_, tcp) => {
                    tasks.spawn(run(router, connections(GatedListener::new(tcp, gate)), stopped))
                }
                Listener::Unix(_, unix) => {
                    tasks.spawn(run(router, connections(GatedListener::new(unix, gate)), stopped))
                }
            };
        }
        tasks.spawn(run(router, incoming, stopped.clone()));
        let metrics = Metrics::new(registry.clone());
        for page in pages {
            viewers.extend(page.local_addr());
            let page = GatedListener::new(page, gate.clone());
            tasks.spawn(page::serve(page, pipes.clone(), metrics.clone(), films.clone(), stopped.clone()));
        }
        Ok(Self { registry, addresses, viewers, sockets, pipes, stop, tasks })
    }

    /// The addresses on which it listens, with the ports that it got.
    pub fn addresses(&self) -> &[Address] {
        &self.addresses
    }

    /// The addresses of the viewer, with the ports that it got.
    pub fn viewers(&self) -> &[SocketAddr] {
        &self.viewers
    }

    /// A new connection to it, through a pipe in memory.
    ///
    /// # Errors
    /// If the server is stopping.
    pub async fn channel(&self) -> Result<Channel, ServerError> {
        Ok(self.pipes.channel().await?)
    }

    /// Ends a world's recording, and gives the status of the world in the very state that the file ends with. Two calls, one
    /// for each, may find a tick between them.
    ///
    /// # Errors
    /// If there is no such world, or it is not being recorded.
    pub async fn stop_recording(&self, world: &str) -> Result<v1::WorldStatus, Status> {
        let (report, recording) = stop_recording(&self.registry, world).await?;
        Ok(status_of(Report { recording: Some(recording), ..report }).await?.1)
    }

    /// Ends all worlds and streams, and waits until they are over.
    pub async fn shutdown(mut self) {
        self.end();
        while self.tasks.join_next().await.is_some() {}
        let registry = self.registry.clone();
        let _ = tokio::task::spawn_blocking(move || registry.join()).await;
    }

    /// Stops everything, once: another server may have taken the addresses since.
    fn end(&self) {
        if *self.stop.borrow() {
            return;
        }
        for world in self.registry.all() {
            let _ = world.send(Message::Stop);
        }
        let _ = self.stop.send(true);
        for socket in &self.sockets {
            socket.remove();
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.end();
    }
}

/// The services, behind the gate's check of each call.
type Router = tonic::transport::server::Router<Stack<InterceptorLayer<CheckCall>, Identity>>;

type CheckCall = fn(Request<()>) -> Result<Request<()>, Status>;

async fn run<I, IO>(router: Router, incoming: I, mut stopped: watch::Receiver<bool>)
where
    I: Stream<Item = io::Result<IO>>,
    IO: tokio::io::AsyncRead + tokio::io::AsyncWrite + Connected + Unpin + Send + 'static,
{
    let stop = async move {
        let _ = stopped.wait_for(|stopped| *stopped).await;
    };
    if let Err(error) = router.serve_with_incoming_shutdown(incoming, stop).await {
        tracing::error!(%error, "a listener stopped");
    }
}

async fn router(control: Control, patience: Duration) -> Result<Router, ServerError> {
    let registry = &control.registry;
    let (health, health_service) = tonic_health::server::health_reporter();
    health.set_serving::<ControlServiceServer<Control>>().await;
    health.set_serving::<BrainLinkServer>().await;
    health.set_serving::<ObserveServiceServer<Observe>>().await;
    let reflection = || {
        tonic_reflection::server::Builder::configure()
            .register_encoded_file_descriptor_set(baudbot_proto::DESCRIPTORS)
            .register_encoded_file_descriptor_set(tonic_health::pb::FILE_DESCRIPTOR_SET)
    };
    let observe = Observe { registry: registry.clone() };
    let brain_link = BrainLink { registry: registry.clone(), patience };
    Ok(Transport::builder()
        // The brains of a machine that has vanished are detached after a while.
        .http2_keepalive_interval(Some(KEEPALIVE))
        .http2_keepalive_timeout(Some(KEEPALIVE))
        .layer(InterceptorLayer::new(check_call as CheckCall))
        .add_service(health_service)
        // Python's reflection client speaks only v1alpha.
        .add_service(reflection().build_v1()?)
        .add_service(reflection().build_v1alpha()?)
        .add_service(
            // A scenario may have 16 MiB, and a request is a little longer than that.
            ControlServiceServer::new(control)
                .max_decoding_message_size(baudbot_scenario::MAX_BYTES + (1 << 16)),
        )
        .add_service(ObserveServiceServer::new(observe))
        .add_service(BrainLinkServer::new(brain_link)))
}
