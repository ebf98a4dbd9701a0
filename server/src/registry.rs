//! The worlds of a server, by name.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};

use baudbot_recording::Replay;
use baudbot_sim::World;
use tokio::sync::oneshot;
use tonic::Status;

use crate::host::{Host, OnTick};
use crate::letter::{Letter, Order, Report};
use crate::pace::Pace;
use crate::recording::RecordConfig;
use crate::room::Room;
use crate::words::{brief, list};

/// Most worlds of one server; each has a thread.
const MAX_WORLDS: usize = 1024;

/// All worlds of a server. Clones share them.
#[derive(Clone, Default)]
pub(crate) struct Registry(Arc<Mutex<Worlds>>);

/// Each with its thread. When nobody can reach them any more, they end.
#[derive(Default)]
struct Worlds {
    by_name: BTreeMap<Arc<str>, (WorldHandle, JoinHandle<()>)>,
    /// How many they are, for each of them to know.
    count: Arc<AtomicU32>,
}

impl Worlds {
    fn update_count(&self) {
        self.count.store(u32::try_from(self.by_name.len()).unwrap_or(u32::MAX), Ordering::Relaxed);
    }
}

impl Drop for Worlds {
    fn drop(&mut self) {
        for (world, _) in self.by_name.values() {
            let _ = world.send(Letter::End);
        }
    }
}

/// The way to one world.
#[derive(Clone)]
pub(crate) struct WorldHandle {
    name: Arc<str>,
    room: Arc<Room>,
}

/// A world to be.
pub(crate) struct NewWorld {
    pub(crate) name: String,
    pub(crate) world: World,
    /// What it does again, if it is not live.
    pub(crate) replay: Option<Replay>,
    pub(crate) pace: Pace,
    pub(crate) paused: bool,
    pub(crate) on_tick: Option<OnTick>,
    /// Where it is recorded from its beginning on.
    pub(crate) record: Option<RecordConfig>,
}

impl NewWorld {
    /// A live world that nobody records.
    pub(crate) fn new(name: String, world: World, pace: Pace) -> Self {
        Self { name, world, replay: None, pace, paused: false, on_tick: None, record: None }
    }
}

impl Registry {
    /// Makes a world and starts its thread.
    pub(crate) fn create(&self, new: NewWorld) -> Result<WorldHandle, Status> {
        check_name(&new.name)?;
        let mut worlds = self.lock();
        if worlds.by_name.contains_key(new.name.as_str()) {
            return Err(Status::already_exists(format!("world: there is a world `{}` already", new.name)));
        }
        if worlds.by_name.len() >= MAX_WORLDS {
            return Err(Status::resource_exhausted(format!("a server has at most {MAX_WORLDS} worlds")));
        }
        let (name, record): (Arc<str>, _) = (new.name.as_str().into(), new.record.clone());
        let (robots, paused) = (new.world.robots().len(), new.paused);
        let mut host = Host::new(Arc::clone(&name), new, Arc::clone(&worlds.count));
        if let Some(record) = record {
            host.record(record)?;
        }
        let room = Arc::new(Room::new(host));
        let home = Arc::clone(&room);
        let thread = thread::Builder::new().name(format!("world {name}"));
        let thread = thread
            .spawn(move || home.live())
            .map_err(|error| Status::resource_exhausted(format!("no thread for another world: {error}")))?;
        tracing::info!(world = &*name, tick = 0, time_s = 0.0, robots, paused, "world made");
        let handle = WorldHandle { name: Arc::clone(&name), room };
        worlds.by_name.insert(name, (handle.clone(), thread));
        worlds.update_count();
        Ok(handle)
    }

    /// The world of this name.
    pub(crate) fn find(&self, field: &str, name: &str) -> Result<WorldHandle, Status> {
        let worlds = self.lock();
        worlds.by_name.get(name).map(|(world, _)| world.clone()).ok_or_else(|| {
            let there = list(worlds.by_name.keys().map(AsRef::as_ref));
            Status::not_found(format!("{field}: there is no world `{}`; there are: {there}", brief(name)))
        })
    }

    /// All worlds in the order of their names.
    pub(crate) fn all(&self) -> Vec<WorldHandle> {
        self.lock().by_name.values().map(|(world, _)| world.clone()).collect()
    }

    /// Forgets a world.
    pub(crate) fn remove(&self, name: &str) {
        let mut worlds = self.lock();
        worlds.by_name.remove(name);
        worlds.update_count();
    }

    /// Forgets all worlds, which must have been told to end, and waits until their threads are over.
    pub(crate) fn join(&self) {
        for (_, thread) in std::mem::take(&mut self.lock().by_name).into_values() {
            // A panic of a world is on stderr already.
            let _ = thread.join();
        }
    }

    fn lock(&self) -> MutexGuard<'_, Worlds> {
        // The map is sound between any two of its calls, so a panic elsewhere does not spoil it.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl WorldHandle {
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Writes to the world.
    pub(crate) fn send(&self, letter: Letter) -> Result<(), Status> {
        if self.room.send(letter) { Ok(()) } else { Err(self.gone()) }
    }

    /// Writes to the world and waits for its answer.
    pub(crate) async fn ask<T>(
        &self,
        letter: impl FnOnce(oneshot::Sender<T>) -> Letter,
    ) -> Result<T, Status> {
        let (reply, answer) = oneshot::channel();
        self.send(letter(reply))?;
        answer.await.map_err(|_| self.gone())
    }

    /// Gives an order.
    pub(crate) async fn order(&self, order: Order) -> Result<Report, Status> {
        self.ask(|reply| Letter::Order(order, reply)).await?
    }

    fn gone(&self) -> Status {
        Status::aborted(format!("world `{}` was deleted", self.name))
    }
}

fn check_name(name: &str) -> Result<(), Status> {
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if name.is_empty() || name.len() > 64 || !name.chars().all(fits) {
        let shown: String = name.chars().take(80).collect();
        let text = format!("world: must be 1 to 64 letters, digits, `_` or `-`, is `{shown}`");
        return Err(Status::invalid_argument(text));
    }
    Ok(())
}
