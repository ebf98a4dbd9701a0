//! The worlds of a server, by name.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tonic::Status;

use crate::actor::{self, NewWorld};
use crate::audit::call::note_world;
use crate::limits::{InForce, Limit, Payer, Place, Taken};
use crate::message::{Message, WorldHandle};
use crate::pool::Pool;
use crate::quote::{brief, list};
use crate::state::StateFolder;

/// Most worlds of one server, by default. So many in real time are more than two processors can run.
pub const MAX_WORLDS: usize = 4096;

/// All worlds of a server. Clones share them.
#[derive(Clone)]
pub(crate) struct Registry {
    worlds: Arc<Mutex<Worlds>>,
    limits: InForce,
}

/// The worlds. Dropping the registry stops them.
#[derive(Default)]
struct Worlds {
    by_name: BTreeMap<Arc<str>, Entry>,
    /// The pool of the worlds; `None` before the first.
    pool: Option<Pool>,
    without_threads: bool,
    /// The number of worlds; each world knows it.
    count: Arc<AtomicU32>,
    /// The folder of worlds' state; `None` if that is not kept.
    state: Option<StateFolder>,
    /// The server stops: no world is made any more.
    is_closed: bool,
}

/// A world, its own pool if it has one, and the places that it takes.
struct Entry {
    world: WorldHandle,
    own: Option<Pool>,
    _places: Places,
}

/// The count of a world: its own place, those of its robots, and that of the client that created it, if it was one.
type Places = (Place, Place, Option<Taken>);

impl Worlds {
    fn update_count(&self) {
        self.count.store(u32::try_from(self.by_name.len()).unwrap_or(u32::MAX), Ordering::Relaxed);
    }
}

impl Drop for Worlds {
    fn drop(&mut self) {
        for Entry { world, .. } in self.by_name.values() {
            let _ = world.send(Message::Stop);
        }
    }
}

impl Registry {
    /// A registry without worlds.
    pub(crate) fn new(limits: InForce) -> Self {
        Self { worlds: Arc::default(), limits }
    }

    /// The same; its worlds are tasks of the runtime in which they are made.
    pub(crate) fn without_threads(self) -> Self {
        self.lock().without_threads = true;
        self
    }

    /// The same; the state of its worlds is kept in this folder, if there is one.
    pub(crate) fn keeping(self, state: Option<StateFolder>) -> Self {
        self.lock().state = state;
        self
    }

    /// Makes no world any more: the server stops.
    pub(crate) fn close(&self) {
        self.lock().is_closed = true;
    }

    /// The limits of the server.
    pub(crate) fn limits(&self) -> &InForce {
        &self.limits
    }

    /// Makes a world for a client, if it is for one, which a pool then runs. One with an `OnTick`, which may block, has a pool of its
    /// own. To count its memory takes a while, if it is large.
    ///
    /// # Errors
    /// If the name is taken or unfit, or there is no room for another world, or no thread.
    pub(crate) fn create(&self, mut new: NewWorld, payer: Option<&Payer>) -> Result<WorldHandle, Status> {
        check_name(&new.name)?;
        note_world(&new.name);
        let take = |Payer(tally): &Payer| self.limits.take(Limit::WorldsPerCaller, tally, "worlds");
        let owner = payer.map(take).transpose()?;
        let (world, robots) = self.limits.world(new.world.robots().len())?;
        let charges = new.charges(&self.limits)?;
        let mut worlds = self.lock();
        if worlds.is_closed {
            return Err(Status::unavailable("the server is stopping, and makes no more worlds"));
        }
        if worlds.by_name.contains_key(new.name.as_str()) {
            return Err(Status::already_exists(format!("world: there is a world `{}` already", new.name)));
        }
        let name: Arc<str> = new.name.as_str().into();
        let (count, state) = (Arc::clone(&worlds.count), worlds.state.clone());
        let without_threads = worlds.without_threads;
        let may_block = new.on_tick.is_some() && !without_threads;
        let mut own = may_block.then(|| Pool::of_one(&format!("world {name}")));
        let pool = match &mut own {
            Some(own) => own,
            None if without_threads => worlds.pool.get_or_insert_with(Pool::without_threads),
            None => worlds.pool.get_or_insert_with(|| Pool::new("worlds")),
        };
        new.state = state;
        let handle = actor::start(new, charges, count, pool)?;
        let entry = Entry { world: handle.clone(), own, _places: (world, robots, owner) };
        worlds.by_name.insert(name, entry);
        worlds.update_count();
        Ok(handle)
    }

    /// The world of this name. An error names the request's `field`.
    pub(crate) fn find(&self, field: &str, name: &str) -> Result<WorldHandle, Status> {
        note_world(name);
        let worlds = self.lock();
        worlds.by_name.get(name).map(|Entry { world, .. }| world.clone()).ok_or_else(|| {
            let there = list(worlds.by_name.keys().map(AsRef::as_ref));
            Status::not_found(format!("{field}: there is no world `{}`; there are: {there}", brief(name)))
        })
    }

    /// A name that no world has: this one and a number.
    pub(crate) fn free_name(&self, name: &str) -> String {
        let worlds = self.lock();
        let mut names = (2..).map(|number: u64| format!("{name}-{number}"));
        names.find(|name| !worlds.by_name.contains_key(name.as_str())).expect("worlds are few, numbers many")
    }

    /// All worlds in the order of their names.
    pub(crate) fn all(&self) -> Vec<WorldHandle> {
        self.lock().by_name.values().map(|Entry { world, .. }| world.clone()).collect()
    }

    /// Forgets a world.
    pub(crate) fn remove(&self, name: &str) {
        let mut worlds = self.lock();
        worlds.by_name.remove(name);
        worlds.update_count();
    }

    /// Forgets all worlds, which must have been stopped, and waits until they are over.
    pub(crate) fn join(&self) {
        let (worlds, shared) = {
            let mut worlds = self.lock();
            (std::mem::take(&mut worlds.by_name), worlds.pool.take())
        };
        let own = worlds.into_values().filter_map(|Entry { own, .. }| own);
        own.chain(shared).for_each(Pool::join);
    }

    fn lock(&self) -> MutexGuard<'_, Worlds> {
        // The map is consistent between any two of its changes, so a panic elsewhere does not spoil it.
        self.worlds.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn check_name(name: &str) -> Result<(), Status> {
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if name.is_empty() || name.len() > 64 || !name.chars().all(fits) {
        let shown = brief(&name.chars().take(80).collect::<String>());
        let text = format!("world: must be 1 to 64 letters, digits, `_` or `-`, is `{shown}`");
        return Err(Status::invalid_argument(text));
    }
    Ok(())
}
