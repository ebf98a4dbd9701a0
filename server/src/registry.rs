//! The worlds of a server, by name.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tonic::Status;

use crate::actor::{self, NewWorld};
use crate::message::{Message, WorldHandle};
use crate::pool::Pool;
use crate::quote::{brief, list};
use crate::state::StateFolder;

/// Most worlds of one server. So many in real time are more than two processors can run.
pub const MAX_WORLDS: usize = 4096;

/// All worlds of a server. Clones share them.
#[derive(Clone, Default)]
pub(crate) struct Registry(Arc<Mutex<Worlds>>);

/// The worlds. Dropping the registry stops them.
#[derive(Default)]
struct Worlds {
    by_name: BTreeMap<Arc<str>, Entry>,
    /// What runs them; `None` before the first.
    pool: Option<Pool>,
    /// How many there are; each world knows it.
    count: Arc<AtomicU32>,
    /// Where the state of worlds is kept; `None` if it is not.
    state: Option<StateFolder>,
    /// The server stops: no world is made any more.
    is_closed: bool,
}

/// A world, and its own pool if it has one.
struct Entry(WorldHandle, Option<Pool>);

impl Worlds {
    fn update_count(&self) {
        self.count.store(u32::try_from(self.by_name.len()).unwrap_or(u32::MAX), Ordering::Relaxed);
    }
}

impl Drop for Worlds {
    fn drop(&mut self) {
        for Entry(world, _) in self.by_name.values() {
            let _ = world.send(Message::Stop);
        }
    }
}

impl Registry {
    /// A registry of worlds whose state is kept in this folder, if there is one.
    pub(crate) fn keeping(state: Option<StateFolder>) -> Self {
        let registry = Self::default();
        registry.lock().state = state;
        registry
    }

    /// Makes no world any more: the server stops.
    pub(crate) fn close(&self) {
        self.lock().is_closed = true;
    }

    /// Makes a world, which a pool then runs. One with an `OnTick`, which may block, has a pool of its own.
    ///
    /// # Errors
    /// If the name is taken or unfit, or there is no room for another world, or no thread.
    pub(crate) fn create(&self, mut new: NewWorld) -> Result<WorldHandle, Status> {
        check_name(&new.name)?;
        let mut worlds = self.lock();
        if worlds.is_closed {
            return Err(Status::unavailable("the server stops, and makes no world any more"));
        }
        if worlds.by_name.contains_key(new.name.as_str()) {
            return Err(Status::already_exists(format!("world: there is a world `{}` already", new.name)));
        }
        if worlds.by_name.len() >= MAX_WORLDS {
            return Err(Status::resource_exhausted(format!("a server has at most {MAX_WORLDS} worlds")));
        }
        let name: Arc<str> = new.name.as_str().into();
        let (count, state) = (Arc::clone(&worlds.count), worlds.state.clone());
        let mut own = new.on_tick.as_ref().map(|_| Pool::of_one(&format!("world {name}")));
        let pool = match &mut own {
            Some(own) => own,
            None => worlds.pool.get_or_insert_with(|| Pool::new("worlds")),
        };
        new.state = state;
        let handle = actor::start(new, count, pool)?;
        worlds.by_name.insert(name, Entry(handle.clone(), own));
        worlds.update_count();
        Ok(handle)
    }

    /// The world of this name. An error names the request's `field`.
    pub(crate) fn find(&self, field: &str, name: &str) -> Result<WorldHandle, Status> {
        let worlds = self.lock();
        worlds.by_name.get(name).map(|Entry(world, _)| world.clone()).ok_or_else(|| {
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
        self.lock().by_name.values().map(|Entry(world, _)| world.clone()).collect()
    }

    /// Forgets a world.
    pub(crate) fn remove(&self, name: &str) {
        let mut worlds = self.lock();
        worlds.by_name.remove(name);
        worlds.update_count();
    }

    /// Forgets all worlds, which must have been told to stop, and waits until they are over.
    pub(crate) fn join(&self) {
        let (worlds, shared) = {
            let mut worlds = self.lock();
            (std::mem::take(&mut worlds.by_name), worlds.pool.take())
        };
        let own = worlds.into_values().filter_map(|Entry(_, own)| own);
        own.chain(shared).for_each(Pool::join);
    }

    fn lock(&self) -> MutexGuard<'_, Worlds> {
        // The map is consistent between any two of its changes, so a panic elsewhere does not spoil it.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
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
