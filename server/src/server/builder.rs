//! The settings that a server starts with.

use std::mem;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use baudbot_access::{Token, TokenFile};
use baudbot_recording::{PROGRAM_VERSION, Replay};
use baudbot_sim::{Scenario, World};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::sync::mpsc;
use tokio_stream::Stream;

use super::access_config::AccessConfig;
use super::listeners::{Listener, Listeners, listen_for_pages};
use super::{Guards, Server, ServerError};
use crate::actor::{DirectWorld, NewWorld, OnBelief, OnTick, Progress};
use crate::address::Address;
use crate::audit::AuditLog;
use crate::control::{Control, Told};
use crate::gate::{Gate, Incoming, Tls};
use crate::limits::{InForce, Limit, Limits};
use crate::message::RecordConfig;
use crate::pace::Pace;
use crate::page::Film;
use crate::recording::Folder;
use crate::registry::Registry;
use crate::state::{KeptWorld, StateFolder};
use crate::system::usual_connections;
use crate::thinking::ProcessorTime;

/// The default of the time that a connection has to make its first call.
const FIRST_CALL_WITHIN: Duration = Duration::from_secs(10);

/// A world with which a server starts.
pub struct WorldConfig {
    new: NewWorld,
}

impl WorldConfig {
    /// A live world of this name, in real time.
    pub fn new(name: impl Into<String>, scenario: impl Into<Arc<Scenario>>) -> Self {
        Self::from_state(name, World::new(scenario.into()))
    }

    /// A live world of this name that goes on from a state, in real time. No brains are attached.
    pub fn from_state(name: impl Into<String>, world: World) -> Self {
        Self { new: NewWorld::new(name.into(), world, Pace::REAL_TIME) }
    }

    /// A world of a [state folder](StateFolder::worlds), which goes on as its server left it.
    pub fn kept(world: KeptWorld) -> Self {
        let KeptWorld { name, world, pace, paused, resumed, .. } = world;
        Self { new: NewWorld { paused, resumed: Some(resumed), ..NewWorld::new(name, world, pace) } }
    }

    /// A world of this name that replays a recording, from where the replay stands in this world. It is paused until it is
    /// started, and no brain can attach to it.
    pub fn replay(name: impl Into<String>, (replay, world): (Replay, World)) -> Self {
        let new = NewWorld::new(name.into(), world, Pace::REAL_TIME);
        Self { new: NewWorld { replay: Some(replay), paused: true, ..new } }
    }

    pub(super) fn into_new(self) -> NewWorld {
        self.new
    }

    /// Records the world into this file, which must not be there yet, with so many frames a simulated second; 0 for none.
    #[must_use]
    pub fn record(mut self, path: PathBuf, look_hz: f64) -> Self {
        let name = path.display().to_string();
        self.new.record = Some(RecordConfig { name, path, look_hz });
        self
    }

    /// Sets the pace.
    #[must_use]
    pub fn pace(mut self, pace: Pace) -> Self {
        self.new.pace = pace;
        self
    }

    /// Whether the world is paused until it is started.
    #[must_use]
    pub fn paused(mut self, paused: bool) -> Self {
        self.new.paused = paused;
        self
    }

    /// Calls this at the start of every tick, and at the end of the run, on the world's own thread. The world waits until it
    /// returns.
    #[must_use]
    pub fn on_tick(mut self, on_tick: OnTick) -> Self {
        self.new.on_tick = Some(on_tick);
        self
    }

    /// Calls this with each belief that a brain has published since the tick before, before what [`on_tick`](Self::on_tick) calls.
    #[must_use]
    pub fn on_belief(mut self, on_belief: OnBelief) -> Self {
        self.new.on_belief = Some(on_belief);
        self
    }

    /// Reports the progress of the world here, and the end of its run.
    #[must_use]
    pub fn progress(mut self, progress: Arc<Progress>) -> Self {
        self.new.progress = Some(progress);
        self
    }

    /// Gives the processor time that the brain of a robot has used, for the thinking times of worlds that do not follow
    /// the wall clock. It is asked at each Turn and each answer, on the threads of the world.
    #[must_use]
    pub fn processor_time(mut self, of: ProcessorTime) -> Self {
        self.new.processor = Some(of);
        self
    }

    /// Makes a world in lockstep without a server, whose brains step on the caller's thread. It is not paused.
    ///
    /// # Errors
    /// If its recording cannot begin.
    pub fn direct(self) -> Result<DirectWorld, ServerError> {
        DirectWorld::start(self.new).map_err(|status| ServerError::World(Box::new(status)))
    }
}

/// Collects the worlds, addresses and limits of a server before it starts.
#[derive(Default)]
pub struct Builder {
    worlds: Vec<WorldConfig>,
    addresses: Vec<Address>,
    brains: Vec<Address>,
    trainers: Vec<Address>,
    /// Each with whether another port will do if this one is taken.
    viewers: Vec<(SocketAddr, bool)>,
    recordings: Option<Folder>,
    state: Option<StateFolder>,
    films: Option<mpsc::Sender<Film>>,
    access: AccessConfig,
    audit: Option<AuditLog>,
    limits: Limits,
    first_call_within: Option<Duration>,
    incoming: Vec<Listener>,
    without_threads: bool,
}

impl Builder {
    /// Adds a world.
    #[must_use]
    pub fn world(mut self, world: WorldConfig) -> Self {
        self.worlds.push(world);
        self
    }

    /// Adds an address to listen on.
    #[must_use]
    pub fn listen(mut self, address: Address) -> Self {
        self.addresses.push(address);
        self
    }

    /// Adds an address on which brains reach their service and nothing else: also a program of the user who may do
    /// everything, such as one that a run has started, drives robots there and gets no truth.
    #[must_use]
    pub fn brains(mut self, address: Address) -> Self {
        self.brains.push(address);
        self
    }

    /// Adds an address on which trainers reach their service, which gives the truth about robots, and the operator's.
    /// It must be one that only this machine can reach. A server without such an address takes no trainers.
    #[must_use]
    pub fn trainer(mut self, address: Address) -> Self {
        self.trainers.push(address);
        self
    }

    /// Adds an address for the viewer, a page for browsers, and for `/metrics`.
    #[must_use]
    pub fn viewer(mut self, address: SocketAddr) -> Self {
        self.viewers.push((address, false));
        self
    }

    /// The same as [`viewer`](Self::viewer); if this port is taken, on another one that is free.
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

    /// Keeps worlds and their snapshots in this folder, so that they are there again after the program has ended, however it
    /// did. [Worlds that are there](StateFolder::worlds) are to be added with [`world`](Self::world).
    #[must_use]
    pub fn state(mut self, folder: StateFolder) -> Self {
        self.state = Some(folder);
        self
    }

    /// Takes films that the viewer's page posts, and sends them here.
    #[must_use]
    pub fn films(mut self, films: mpsc::Sender<Film>) -> Self {
        self.films = Some(films);
        self
    }

    /// A caller over TCP, or at a Unix socket as another user, shows one of the tokens in this file, and has the rights
    /// that it gives. A file that changes is read again. Without this and [`local_token`](Self::local_token) each
    /// caller that reaches the server may do everything.
    #[must_use]
    pub fn tokens(mut self, file: TokenFile) -> Self {
        self.access.tokens = Some(file);
        self
    }

    /// A token that is good for everything. Programs of this user find it by the server's address on this machine
    /// ([`baudbot_access::local`]).
    #[must_use]
    pub fn local_token(mut self, token: Token) -> Self {
        self.access.local = Some(token);
        self
    }

    /// Encrypts all connections over TCP, those of pages, too.
    #[must_use]
    pub fn tls(mut self, tls: Tls) -> Self {
        self.access.tls = Some(tls);
        self
    }

    /// The server is behind a proxy that does TLS for it: other machines may reach its addresses without.
    #[must_use]
    pub fn behind_proxy(mut self, behind_proxy: bool) -> Self {
        self.access.behind_proxy = behind_proxy;
        self
    }

    /// Notes here who did what: each call that changes something, drives or trains, and each that was refused.
    #[must_use]
    pub fn audit(mut self, log: AuditLog) -> Self {
        self.audit = Some(log);
        self
    }

    /// A name under which browsers reach the viewer, such as `lab.example`; localhost always is one, and its own address. Requests
    /// under other names are refused, as a page of a stranger may have made one that leads here.
    #[must_use]
    pub fn host(mut self, name: impl Into<String>) -> Self {
        self.access.hosts.push(name.into());
        self
    }

    /// Limits the connections at a time, over all addresses and viewers. Without it the limit is three quarters of the files
    /// that the process may have open ([`raise_descriptor_limit`](crate::raise_descriptor_limit)). When all places are taken,
    /// a new connection displaces the oldest one that has not made a call; if there is none, its calls are refused with
    /// `UNAVAILABLE`, and may succeed later.
    #[must_use]
    pub fn connections(mut self, connections: usize) -> Self {
        self.limits = self.limits.with(Limit::Connections, connections as u64);
        self
    }

    /// Limits what clients may have, one of them and all together. In place of all limits that were set before.
    #[must_use]
    pub fn limits(mut self, limits: Limits) -> Self {
        self.limits = limits;
        self
    }

    /// Closes a connection that has not made a call within so long, and the stream of a brain that has sent no Hello by then.
    /// Without it the limit is 10 s. Connections that have made a call may be silent for as long as they like.
    #[must_use]
    pub fn first_call_within(mut self, patience: Duration) -> Self {
        self.first_call_within = Some(patience);
        self
    }

    /// Takes connections that are accepted outside of the server, such as those of a simulated network. As over TCP,
    /// who calls shows a token if the server has any; they are not encrypted by the server.
    #[must_use]
    pub fn incoming<IO>(mut self, connections: impl Stream<Item = IO> + Send + 'static) -> Self
    where
        IO: AsyncRead + AsyncWrite + Unpin + Send + 'static,
    {
        self.incoming.push(Listener::Other(Incoming::new(connections)));
        self
    }

    /// Runs the worlds as tasks of the runtime that starts the server, and not on threads of their own. With one thread and a
    /// paused clock of tokio (`start_paused`) simulated hours then pass at once, in the same order each time: worlds in real time,
    /// watchdogs and time-outs all go by that clock. It is for tests: a long tick, a disk and an `on_tick` keep everything else
    /// waiting, and a world in free pace lets no paused time pass.
    #[must_use]
    pub fn without_threads(mut self) -> Self {
        self.without_threads = true;
        self
    }

    /// Starts the server without a port: it is reached through [`Server::channel`] only, and by trainers, if there is an address
    /// for them, through [`Server::trainers_channel`].
    ///
    /// # Errors
    /// If a world cannot be made.
    pub async fn in_process(self) -> Result<Server, ServerError> {
        self.start(false).await
    }

    /// Starts the server on its addresses.
    ///
    /// # Errors
    /// If an address cannot be listened on, or a world cannot be made.
    pub async fn serve(self) -> Result<Server, ServerError> {
        self.start(true).await
    }

    async fn start(mut self, listens: bool) -> Result<Server, ServerError> {
        let listeners = self.listeners(listens).await?;
        let most = usual_connections();
        let wanted = self.limits.count(Limit::Connections);
        if wanted > most {
            tracing::warn!(wanted, most, "the limit of open files (ulimit -n) allows fewer connections");
            self.limits = self.limits.with(Limit::Connections, most as u64);
        }
        let limits = InForce::new(self.limits);
        let registry = Registry::new(limits.clone()).keeping(self.state);
        let registry = if self.without_threads { registry.without_threads() } else { registry };
        for world in self.worlds {
            registry.create(world.new, None).map_err(|status| ServerError::World(Box::new(status)))?;
        }
        let control = Control { registry, recordings: self.recordings, told: Told::default() };
        let gate = Gate::new(limits, self.first_call_within.unwrap_or(FIRST_CALL_WITHIN));
        if let Some(audit) = &self.audit {
            audit.note("start", &format!("baudbot {PROGRAM_VERSION}"));
        }
        let guards = Guards {
            access: self.access.start()?,
            audit: self.audit,
            gate,
            local: self.access.local.filter(|_| listens),
            hosts: self.access.hosts,
            behind_proxy: self.access.behind_proxy,
            is_encrypted: self.access.tls.is_some(),
        };
        Server::start(control, guards, listeners, self.films).await
    }

    /// The listeners on all addresses; on none if it does not listen.
    async fn listeners(&mut self, listens: bool) -> Result<Listeners, ServerError> {
        let trains = !self.trainers.is_empty();
        let mut listeners = Listeners {
            ordinary: mem::take(&mut self.incoming),
            brains: Vec::new(),
            trainers: trains.then(Vec::new),
            pages: Vec::new(),
        };
        if !listens {
            return Ok(listeners);
        }
        let tls = self.access.tls.as_ref().map(|tls| tls.speaking(&["h2"]));
        for address in mem::take(&mut self.addresses) {
            self.access.allows(&address)?;
            listeners.ordinary.push(Listener::bind(address, tls.as_ref()).await?);
        }
        for address in mem::take(&mut self.brains) {
            self.access.allows(&address)?;
            listeners.brains.push(Listener::bind(address, tls.as_ref()).await?);
        }
        for address in mem::take(&mut self.trainers) {
            if !address.is_local() {
                return Err(ServerError::TrainerNotLocal { address });
            }
            listeners.trainers.get_or_insert_default().push(Listener::bind(address, tls.as_ref()).await?);
        }
        let tls = self.access.tls.as_ref().map(|tls| tls.speaking(&["http/1.1"]));
        for (socket, or_free_port) in mem::take(&mut self.viewers) {
            self.access.allows(&Address::Tcp(socket))?;
            listeners.pages.push(listen_for_pages(socket, or_free_port, tls.clone()).await?);
        }
        Ok(listeners)
    }
}
