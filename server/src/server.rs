//! The server: its builder, its listeners, and its end.

use std::io;
use std::net::SocketAddr;
use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use baudbot_proto::v1::brain_link_service_server::BrainLinkServiceServer;
use baudbot_proto::v1::control_service_server::ControlServiceServer;
use baudbot_proto::v1::observe_service_server::ObserveServiceServer;
use baudbot_recording::Replay;
use baudbot_sim::{Scenario, World};
use tokio::net::{TcpListener, UnixListener, UnixStream};
use tokio::sync::{mpsc, watch};
use tokio::task::JoinSet;
use tokio_stream::Stream;
use tonic::service::InterceptorLayer;
use tonic::transport::server::Connected;
use tonic::transport::{Channel, Server as Transport};
use tonic::{Request, Status};
use tower::layer::util::{Identity, Stack};

use crate::address::Address;
use crate::brain_link::BrainLink;
use crate::control::Control;
use crate::descriptors::usual_connections;
use crate::gate::{Entry, Gate, check_call, guests};
use crate::host::OnTick;
use crate::letter::Letter;
use crate::metrics::Metrics;
use crate::observe::Observe;
use crate::pace::Pace;
use crate::page::{self, Film};
use crate::pipe::Pipes;
use crate::recording::{Folder, RecordConfig};
use crate::registry::{NewWorld, Registry};

/// How often a silent connection is asked whether it is there, and how long it has to answer.
const KEEPALIVE: Duration = Duration::from_secs(20);

/// How long a connection has to ask for something, if nobody says otherwise.
const FIRST_CALL_WITHIN: Duration = Duration::from_secs(10);

/// Why a server did not start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServerError {
    /// An address could not be listened on.
    #[error("cannot listen on {address}")]
    Bind {
        /// The address.
        address: Address,
        /// Why.
        source: io::Error,
    },
    /// An address that other machines reach, without leave.
    #[error(
        "{address} can be reached from other machines, and this server asks nobody who they are; listen on 127.0.0.1, or allow it with --insecure"
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

/// A world that a server starts with.
pub struct WorldConfig {
    new: NewWorld,
}

impl WorldConfig {
    /// A world of this name, at real time.
    pub fn new(name: impl Into<String>, scenario: impl Into<Arc<Scenario>>) -> Self {
        Self::from_state(name, World::new(scenario.into()))
    }

    /// A world of this name that goes on from a state, at real time. Brains that held its robots are not attached.
    pub fn from_state(name: impl Into<String>, world: World) -> Self {
        Self { new: NewWorld::new(name.into(), world, Pace::REAL_TIME) }
    }

    /// A world of this name that does a recording again: this replay's, as it stands in this world. It stands still until
    /// it is started, and no brain can attach to it.
    pub fn replay(name: impl Into<String>, (replay, world): (Replay, World)) -> Self {
        let new = NewWorld::new(name.into(), world, Pace::REAL_TIME);
        Self { new: NewWorld { replay: Some(replay), paused: true, ..new } }
    }

    /// Records it into this file, which must not be there yet, with so many frames a simulated second of what an
    /// observer sees; 0 for none.
    #[must_use]
    pub fn record(mut self, path: PathBuf, look_hz: f64) -> Self {
        let name = path.display().to_string();
        self.new.record = Some(RecordConfig { name, path, look_hz });
        self
    }

    /// Its pace.
    #[must_use]
    pub fn pace(mut self, pace: Pace) -> Self {
        self.new.pace = pace;
        self
    }

    /// Whether it stands until it is started.
    #[must_use]
    pub fn paused(mut self, paused: bool) -> Self {
        self.new.paused = paused;
        self
    }

    /// Called at the start of every tick, and at the end of the run, on the world's own thread: what it
    /// takes, the world waits.
    #[must_use]
    pub fn on_tick(mut self, on_tick: OnTick) -> Self {
        self.new.on_tick = Some(on_tick);
        self
    }
}

/// Collects what a server starts with.
#[derive(Default)]
pub struct Builder {
    worlds: Vec<WorldConfig>,
    addresses: Vec<Address>,
    /// Each with whether another port will do.
    viewers: Vec<(SocketAddr, bool)>,
    recordings: Option<Folder>,
    films: Option<mpsc::Sender<Film>>,
    insecure: bool,
    connections: Option<usize>,
    first_call_within: Option<Duration>,
}

impl Builder {
    /// Starts with this world.
    #[must_use]
    pub fn world(mut self, world: WorldConfig) -> Self {
        self.worlds.push(world);
        self
    }

    /// Listens here.
    #[must_use]
    pub fn listen(mut self, address: Address) -> Self {
        self.addresses.push(address);
        self
    }

    /// Serves the viewer, a page for browsers, here, and `/metrics` for monitoring.
    #[must_use]
    pub fn viewer(mut self, address: SocketAddr) -> Self {
        self.viewers.push((address, false));
        self
    }

    /// As [`viewer`](Self::viewer), but if this port is taken on another one that is free.
    #[must_use]
    pub fn viewer_or_free_port(mut self, address: SocketAddr) -> Self {
        self.viewers.push((address, true));
        self
    }

    /// Lets operators record worlds into this folder, which must be there, and replay what is in it.
    #[must_use]
    pub fn recordings(mut self, folder: PathBuf) -> Self {
        self.recordings = Some(Folder::new(folder));
        self
    }

    /// Lets the viewer's page hand in films, which go here.
    #[must_use]
    pub fn films(mut self, films: mpsc::Sender<Film>) -> Self {
        self.films = Some(films);
        self
    }

    /// Allows addresses that other machines can reach.
    #[must_use]
    pub fn insecure(mut self, insecure: bool) -> Self {
        self.insecure = insecure;
        self
    }

    /// Takes at most so many connections at a time, over all addresses and viewers, and not three quarters of the files that
    /// the process may have open ([`raise_descriptor_limit`](crate::raise_descriptor_limit)). When all places are taken,
    /// a new connection gets that of whoever has been silent since it came; if nobody has, its calls are refused with
    /// `UNAVAILABLE`: it may go well later.
    #[must_use]
    pub fn connections(mut self, connections: usize) -> Self {
        self.connections = Some(connections);
        self
    }

    /// Closes a connection that has not asked for anything within so long, and not within 10 s, and a brain's stream that has
    /// not said Hello by then. Those that have may be silent for as long as they like.
    #[must_use]
    pub fn first_call_within(mut self, patience: Duration) -> Self {
        self.first_call_within = Some(patience);
        self
    }

    /// Starts the server without any port: it is reached through [`Server::channel`] only.
    ///
    /// # Errors
    /// If a world cannot be made.
    pub async fn in_process(self) -> Result<Server, ServerError> {
        Self { addresses: Vec::new(), viewers: Vec::new(), ..self }.serve().await
    }

    /// Starts the server on its addresses.
    ///
    /// # Errors
    /// If an address cannot be listened on, or a world cannot be made.
    pub async fn serve(self) -> Result<Server, ServerError> {
        let mut listeners = Vec::new();
        for address in self.addresses {
            if !self.insecure && !address.is_local() {
                return Err(ServerError::NotLoopback { address });
            }
            listeners.push(Listener::bind(address).await?);
        }
        let mut pages = Vec::new();
        for viewer in self.viewers {
            pages.push(listen_for_pages(viewer, self.insecure).await?);
        }
        let registry = Registry::default();
        for world in self.worlds {
            registry.create(world.new).map_err(|status| ServerError::World(Box::new(status)))?;
        }
        let control = Control { registry, recordings: self.recordings };
        let gate = Gate::new(
            self.connections.unwrap_or_else(usual_connections),
            self.first_call_within.unwrap_or(FIRST_CALL_WITHIN),
        );
        Server::start(control, gate, listeners, pages, self.films).await
    }
}

/// A running server. Dropping it tells its worlds to end; [`shutdown`](Self::shutdown) also waits until they have.
pub struct Server {
    pub(crate) registry: Registry,
    addresses: Vec<Address>,
    viewers: Vec<SocketAddr>,
    sockets: Vec<SocketFile>,
    pipes: Pipes,
    stop: watch::Sender<bool>,
    tasks: JoinSet<()>,
}

impl Server {
    /// Begins a new server.
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
                Listener::Tcp(_, tcp) => tasks.spawn(run(router, guests(Entry::new(tcp, gate)), stopped)),
                Listener::Unix(_, unix) => tasks.spawn(run(router, guests(Entry::new(unix, gate)), stopped)),
            };
        }
        tasks.spawn(run(router, incoming, stopped.clone()));
        let metrics = Metrics::new(registry.clone());
        for page in pages {
            viewers.extend(page.local_addr());
            let page = Entry::new(page, gate.clone());
            tasks.spawn(page::serve(page, pipes.clone(), metrics.clone(), films.clone(), stopped.clone()));
        }
        Ok(Self { registry, addresses, viewers, sockets, pipes, stop, tasks })
    }

    /// Where it listens, free ports filled in.
    pub fn addresses(&self) -> &[Address] {
        &self.addresses
    }

    /// Where the viewer is, free ports filled in.
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

    /// Ends all worlds and streams, and waits until they are over.
    pub async fn shutdown(mut self) {
        self.end();
        while self.tasks.join_next().await.is_some() {}
        let registry = self.registry.clone();
        let _ = tokio::task::spawn_blocking(move || registry.join()).await;
    }

    /// Once: another server may have taken the addresses since.
    fn end(&self) {
        if *self.stop.borrow() {
            return;
        }
        for world in self.registry.all() {
            let _ = world.send(Letter::End);
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

/// The services, behind a check of each call.
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
    health.set_serving::<BrainLinkServiceServer<BrainLink>>().await;
    health.set_serving::<ObserveServiceServer<Observe>>().await;
    let reflection = || {
        tonic_reflection::server::Builder::configure()
            .register_encoded_file_descriptor_set(baudbot_proto::DESCRIPTORS)
            .register_encoded_file_descriptor_set(tonic_health::pb::FILE_DESCRIPTOR_SET)
    };
    let observe = Observe { registry: registry.clone() };
    let brain_link = BrainLink { registry: registry.clone(), patience };
    Ok(Transport::builder()
        // A machine that vanished without a word lets its robots go after a while.
        .http2_keepalive_interval(Some(KEEPALIVE))
        .http2_keepalive_timeout(Some(KEEPALIVE))
        .layer(InterceptorLayer::new(check_call as CheckCall))
        .add_service(health_service)
        // Python's reflection client speaks only v1alpha.
        .add_service(reflection().build_v1()?)
        .add_service(reflection().build_v1alpha()?)
        .add_service(
            // A scenario may have 16 MiB, and a little is around it.
            ControlServiceServer::new(control)
                .max_decoding_message_size(baudbot_scenario::MAX_BYTES + (1 << 16)),
        )
        .add_service(ObserveServiceServer::new(observe))
        .add_service(BrainLinkServiceServer::new(brain_link)))
}

async fn listen_for_pages(
    (socket, or_free_port): (SocketAddr, bool),
    insecure: bool,
) -> Result<TcpListener, ServerError> {
    let address = Address::Tcp(socket);
    if !insecure && !address.is_local() {
        return Err(ServerError::NotLoopback { address });
    }
    let listener = match TcpListener::bind(socket).await {
        Err(error) if or_free_port && error.kind() == io::ErrorKind::AddrInUse => {
            TcpListener::bind((socket.ip(), 0)).await
        }
        listener => listener,
    };
    listener.map_err(|source| ServerError::Bind { address, source })
}

enum Listener {
    Tcp(Address, TcpListener),
    Unix(Address, UnixListener),
}

impl Listener {
    async fn bind(address: Address) -> Result<Self, ServerError> {
        let failed = |source| ServerError::Bind { address: address.clone(), source };
        match &address {
            Address::Tcp(socket) => {
                let listener = TcpListener::bind(socket).await.map_err(failed)?;
                let bound = listener.local_addr().map_err(failed)?;
                Ok(Self::Tcp(Address::Tcp(bound), listener))
            }
            Address::Unix(path) => {
                remove_stale(path).await.map_err(failed)?;
                let listener = UnixListener::bind(path).map_err(failed)?;
                Ok(Self::Unix(address, listener))
            }
        }
    }

    fn address(&self) -> &Address {
        match self {
            Self::Tcp(address, _) | Self::Unix(address, _) => address,
        }
    }
}

/// The file of a Unix socket that this server listens on.
struct SocketFile {
    path: PathBuf,
    device_and_inode: (u64, u64),
}

impl SocketFile {
    fn at(path: &Path) -> Option<Self> {
        let metadata = std::fs::symlink_metadata(path).ok()?;
        Some(Self { path: path.to_owned(), device_and_inode: (metadata.dev(), metadata.ino()) })
    }

    /// Removes it, unless another server's stands there by now.
    fn remove(&self) {
        let here = Self::at(&self.path);
        if here.is_some_and(|here| here.device_and_inode == self.device_and_inode) {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// A socket that refuses connections is what a killed server left behind. Any other is somebody's.
async fn remove_stale(path: &Path) -> io::Result<()> {
    let Ok(metadata) = std::fs::symlink_metadata(path) else { return Ok(()) };
    if !metadata.file_type().is_socket() {
        return Ok(());
    }
    let answer = tokio::time::timeout(Duration::from_secs(1), UnixStream::connect(path)).await;
    match answer {
        Ok(Err(error)) if error.kind() == io::ErrorKind::ConnectionRefused => std::fs::remove_file(path),
        _ => Ok(()),
    }
}
