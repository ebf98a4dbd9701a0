//! The server: its listeners, its services, and its end.

mod access_config;
mod builder;
mod listeners;
mod reach;
mod router;

use std::io;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, PoisonError};

use baudbot_access::Token;
use baudbot_access::local::LocalFiles;
use baudbot_proto::v1;
use tokio::sync::{mpsc, watch};
use tokio::task::JoinSet;
use tokio_stream::Stream;
use tonic::Status;
use tonic::transport::Channel;
use tonic::transport::server::Connected;

use crate::access::Access;
use crate::address::Address;
use crate::audit::AuditLog;
use crate::control::{Control, status_of, stop_recording};
use crate::gate::{CheckCalls, Gate, GatedListener, TcpEntry, connections};
use crate::limits::Peer;
use crate::message::{Message, WorldHandle};
use crate::metrics::Metrics;
use crate::page::{self, Film, Guard};
use crate::pipe::Pipes;
use crate::registry::Registry;
pub use builder::{Builder, WorldConfig};
use listeners::{Listener, Listeners, SocketFile};
use router::Router;

/// A reason why a server did not start.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// An address could not be listened on.
    #[error("cannot listen on {address}")]
    Bind {
        /// The address.
        address: Address,
        /// The system's error.
        source: io::Error,
    },
    /// An address that other machines can reach, without tokens and TLS.
    #[error(
        "{address} can be reached from other machines: that needs --tokens FILE (see `baudbot token`) and --tls CERTIFICATE,KEY (see \
         `baudbot cert`), or a proxy that does TLS (--behind-proxy); or listen on 127.0.0.1"
    )]
    NotLoopback {
        /// The address.
        address: Address,
    },
    /// An address for trainers that other machines can reach.
    #[error(
        "{address}: a trainer's address must be on this machine, as it gives access to the truth about robots; use 127.0.0.1:PORT or unix:/PATH"
    )]
    TrainerNotLocal {
        /// The address.
        address: Address,
    },
    /// The server takes no trainers.
    #[error("this server takes no trainers; give its builder an address for them")]
    NoTrainers,
    /// The tokens could not be read.
    #[error(transparent)]
    Tokens(#[from] baudbot_access::FileError),
    /// The token for this user's own programs could not be written.
    #[error("the token for your own programs: {0}")]
    LocalToken(#[from] baudbot_access::PrivateError),
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
    trainers: Vec<Address>,
    viewers: Vec<SocketAddr>,
    sockets: Vec<SocketFile>,
    /// The token of this user's own programs, and the files in which they find it.
    local: Option<(Token, LocalFiles)>,
    audit: Option<AuditLog>,
    is_encrypted: bool,
    behind_proxy: bool,
    /// A name under which pages reach it.
    host: Option<String>,
    pipes: Pipes,
    /// The pipes to the services of trainers.
    trainers_pipes: Option<Pipes>,
    stop: watch::Sender<bool>,
    tasks: JoinSet<()>,
    /// Worlds that were stopped.
    ending: Mutex<Vec<WorldHandle>>,
}

/// The guards between the clients of a server and its services.
struct Guards {
    access: Access,
    audit: Option<AuditLog>,
    gate: Gate,
    /// The token that this user's own programs find.
    local: Option<Token>,
    /// Names under which pages reach it.
    hosts: Vec<String>,
    behind_proxy: bool,
    is_encrypted: bool,
}

impl Guards {
    fn check_of_calls(&self) -> CheckCalls {
        CheckCalls {
            access: self.access.clone(),
            limits: self.gate.limits().clone(),
            audit: self.audit.clone(),
        }
    }
}

impl Server {
    /// A builder of a server.
    pub fn builder() -> Builder {
        Builder::default()
    }

    async fn start(
        control: Control,
        mut guards: Guards,
        listeners: Listeners,
        films: Option<mpsc::Sender<Film>>,
    ) -> Result<Self, ServerError> {
        // Clients that come as soon as they can find the token of this server, and not of the one before.
        let local = guards.local.take().map(|token| listeners.publish(token)).transpose()?;
        let control = Arc::new(control);
        let router = router::ordinary(&control, &guards.check_of_calls(), &guards.gate).await?;
        let (stop, stopped) = watch::channel(false);
        let (pipes, incoming) = Pipes::new();
        let mut server = Self {
            registry: control.registry.clone(),
            addresses: listeners.ordinary.iter().filter_map(Listener::address).cloned().collect(),
            trainers: Vec::new(),
            viewers: Vec::new(),
            sockets: Vec::new(),
            local,
            audit: guards.audit.clone(),
            is_encrypted: guards.is_encrypted,
            behind_proxy: guards.behind_proxy,
            host: guards.hosts.first().cloned(),
            pipes,
            trainers_pipes: None,
            stop,
            tasks: JoinSet::new(),
            ending: Mutex::default(),
        };
        let brains = router::brains(&control, &guards.check_of_calls(), &guards.gate);
        for (listeners, router) in [(listeners.ordinary, &router), (listeners.brains, &brains)] {
            for listener in listeners {
                server.listen(listener, router, &guards.gate, &stopped);
            }
        }
        server.tasks.spawn(run(router, incoming, stopped.clone()));
        if let Some(trainers) = listeners.trainers {
            server.take_trainers(trainers, &control, &guards, &stopped).await?;
        }
        server.show_pages(listeners.pages, &guards, films.as_ref(), &stopped);
        server.renew(guards.access, stopped);
        Ok(server)
    }

    /// Keeps the tokens up to date until it stops.
    fn renew(&mut self, access: Access, mut stopped: watch::Receiver<bool>) {
        self.tasks.spawn(async move {
            tokio::select! {
                () = access.renew() => {}
                _ = stopped.wait_for(|stopped| *stopped) => {}
            }
        });
    }

    /// Serves trainers on these listeners, and through pipes.
    async fn take_trainers(
        &mut self,
        listeners: Vec<Listener>,
        control: &Arc<Control>,
        guards: &Guards,
        stopped: &watch::Receiver<bool>,
    ) -> Result<(), ServerError> {
        let gate = &guards.gate;
        let router = router::trainers(control, &guards.check_of_calls(), gate, stopped.clone()).await?;
        for listener in listeners {
            self.trainers.extend(listener.address().cloned());
            self.listen(listener, &router, gate, stopped);
        }
        let (pipes, incoming) = Pipes::new();
        self.trainers_pipes = Some(pipes);
        self.tasks.spawn(run(router, incoming, stopped.clone()));
        Ok(())
    }

    /// Serves the viewer on these listeners.
    fn show_pages(
        &mut self,
        listeners: Vec<TcpEntry>,
        guards: &Guards,
        films: Option<&mpsc::Sender<Film>>,
        stopped: &watch::Receiver<bool>,
    ) {
        let metrics = Metrics::new(self.registry.clone());
        for entry in listeners {
            self.viewers.extend(entry.listener.local_addr());
            let guard = Guard::new(&entry, &guards.hosts, guards.behind_proxy);
            let listener = GatedListener::for_pages(entry, guards.gate.clone());
            let services = page::Services {
                pipes: self.pipes.clone(),
                access: guards.access.clone(),
                audit: guards.audit.clone(),
                metrics: metrics.clone(),
            };
            self.tasks.spawn(page::serve(listener, guard, services, films.cloned(), stopped.clone()));
        }
    }

    /// Serves these services on this listener.
    fn listen(&mut self, listener: Listener, router: &Router, gate: &Gate, stopped: &watch::Receiver<bool>) {
        if let Some(Address::Unix(path)) = listener.address() {
            self.sockets.extend(SocketFile::at(path));
        }
        let (router, gate, stopped) = (router.clone(), gate.clone(), stopped.clone());
        match listener {
            Listener::Tcp(_, tcp) => {
                self.tasks.spawn(run(router, connections(GatedListener::new(tcp, gate)), stopped))
            }
            Listener::Unix(_, unix) => {
                self.tasks.spawn(run(router, connections(GatedListener::new(unix, gate)), stopped))
            }
            Listener::Other(incoming) => {
                self.tasks.spawn(run(router, connections(GatedListener::new(incoming, gate)), stopped))
            }
        };
    }

    /// The addresses on which it listens, with the ports that it got.
    pub fn addresses(&self) -> &[Address] {
        &self.addresses
    }

    /// The addresses on which it listens for trainers, with the ports that it got.
    pub fn trainers(&self) -> &[Address] {
        &self.trainers
    }

    /// The addresses of the viewer, with the ports that it got.
    pub fn viewers(&self) -> &[SocketAddr] {
        &self.viewers
    }

    /// Whether connections over TCP are by TLS.
    pub fn is_encrypted(&self) -> bool {
        self.is_encrypted
    }

    /// A new connection to it, through a pipe in memory.
    ///
    /// # Errors
    /// If the server is stopping.
    pub async fn channel(&self) -> Result<Channel, ServerError> {
        Ok(self.pipes.channel(Peer::process()).await?)
    }

    /// A new connection to what trainers reach, the trainers' and the operator's service, through a pipe in memory.
    ///
    /// # Errors
    /// If the builder was given no address for trainers, or the server is stopping.
    pub async fn trainers_channel(&self) -> Result<Channel, ServerError> {
        let pipes = self.trainers_pipes.as_ref().ok_or(ServerError::NoTrainers)?;
        Ok(pipes.channel(Peer::process()).await?)
    }

    /// Makes another world, as the builder makes those that are there from the beginning. A client deletes it, or the server's end.
    ///
    /// # Errors
    /// If the name is taken or unfit, or there is no room for another world.
    pub fn create_world(&self, world: WorldConfig) -> Result<(), Status> {
        self.registry.create(world.into_new(), None).map(|_| ())
    }

    /// Ends a world's recording, and gives the status of the world in the very state that the file ends with. Two calls, one
    /// for each, may find a tick between them.
    ///
    /// # Errors
    /// If there is no such world, or it is not being recorded.
    pub async fn stop_recording(&self, world: &str) -> Result<v1::WorldStatus, Status> {
        let report = stop_recording(&self.registry, world).await?;
        Ok(status_of(report, self.registry.limits()).await?.1)
    }

    /// Makes no world any more: the server is about to stop.
    pub fn refuse_worlds(&self) {
        self.registry.close();
    }

    /// Ends all worlds and streams, and waits until they are over.
    pub async fn shutdown(mut self) {
        let _ = self.end_worlds().await;
        self.end_streams().await;
    }

    /// Ends all worlds and their streams, and waits until the worlds are over: their recordings are closed, and their state is
    /// kept.
    pub async fn end_worlds(&self) {
        self.end();
        let registry = self.registry.clone();
        let _ = tokio::task::spawn_blocking(move || registry.join()).await;
    }

    /// Waits until all connections are closed. Their streams end with the worlds.
    pub async fn end_streams(&mut self) {
        self.end();
        while self.tasks.join_next().await.is_some() {}
    }

    /// The names of the worlds that were stopped and are not over yet.
    pub fn unended(&self) -> Vec<String> {
        let worlds = self.ending.lock().unwrap_or_else(PoisonError::into_inner);
        worlds.iter().filter(|world| !world.is_over()).map(|world| world.name().to_owned()).collect()
    }

    /// Stops everything, once: another server may have taken the addresses since.
    fn end(&self) {
        if *self.stop.borrow() {
            return;
        }
        if let Some(audit) = &self.audit {
            audit.note("stop", "the server stops");
        }
        self.registry.close();
        let worlds = self.registry.all();
        for world in &worlds {
            let _ = world.send(Message::Stop);
        }
        *self.ending.lock().unwrap_or_else(PoisonError::into_inner) = worlds;
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
