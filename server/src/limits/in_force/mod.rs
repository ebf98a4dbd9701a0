//! The limits of a running server, and what is used of them.

mod worlds;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;

use super::Limits;
use super::accounts::{Account, Accounts, Counted, Taken, Tally, count_up};
use super::limit::{Exceeded, Limit};
use super::making::Making;
use super::memory::Memory;
use super::overload::Overload;
use super::parsing::Parsing;
use super::unread::Unread;
use crate::clock;
use crate::log::Throttle;

/// The limits of a running server. Clones share what is used of them.
#[derive(Clone)]
pub(crate) struct InForce(Arc<Shared>);

struct Shared {
    limits: Limits,
    accounts: Accounts,
    memory: Arc<Memory>,
    parsing: Parsing,
    overload: Overload,
    /// Of all worlds that lag.
    lags: Throttle,
    unread: Unread,
    making: Making,
    /// Of what a whole server has: connections, worlds, robots, snapshots.
    counts: [AtomicUsize; 4],
    refused: [AtomicU64; Limit::ALL.len()],
    logged: [Throttle; Limit::ALL.len()],
}

/// A total of a whole server.
#[derive(Clone, Copy, Debug)]
enum Whole {
    Connections,
    Worlds,
    Robots,
    Snapshots,
}

/// Places that are taken until this is dropped.
pub(crate) struct Place {
    limits: InForce,
    of: Whole,
    count: usize,
}

impl Drop for Place {
    fn drop(&mut self) {
        self.limits.0.counts[self.of as usize].fetch_sub(self.count, Ordering::Relaxed);
    }
}

impl InForce {
    pub(crate) fn new(limits: Limits) -> Self {
        Self(Arc::new(Shared {
            accounts: Accounts::default(),
            memory: Arc::default(),
            parsing: Parsing::new(limits.parsing),
            overload: Overload::default(),
            lags: Throttle::each(EACH_MINUTE),
            unread: Unread::default(),
            making: Making::new(limits.parsing),
            counts: Default::default(),
            refused: Default::default(),
            logged: Default::default(),
            limits,
        }))
    }

    pub(crate) fn limits(&self) -> &Limits {
        &self.0.limits
    }

    /// The counts of an account.
    pub(crate) fn tally(&self, account: &Account) -> Arc<Tally> {
        self.0.accounts.of(account)
    }

    /// The figures for metrics: of each limit its value, its use, if that is counted, and the number of refusals.
    pub(crate) fn usage(&self) -> impl Iterator<Item = (Limit, f64, Option<f64>, u64)> {
        Limit::ALL.into_iter().map(|limit| {
            let refused = self.0.refused[limit as usize].load(Ordering::Relaxed);
            let (value, used) = self.value_and_used(limit);
            (limit, value, used, refused)
        })
    }

    fn value_and_used(&self, limit: Limit) -> (f64, Option<f64>) {
        let Shared { limits, accounts, memory, parsing, overload, counts, .. } = &*self.0;
        let whole = |what: Whole| Some(counts[what as usize].load(Ordering::Relaxed) as f64);
        let most = |what| Some(accounts.most(what) as f64);
        let or = |set: Option<usize>, usual: usize| set.unwrap_or(usual) as f64;
        match limit {
            Limit::Connections => (limits.connections as f64, whole(Whole::Connections)),
            Limit::ConnectionsPerAddress => {
                (or(limits.connections_per_address, limits.half_of_connections()), most(Counted::Connections))
            }
            Limit::ConnectionsPerToken => {
                (or(limits.connections_per_token, Limits::CONNECTIONS_PER_TOKEN), None)
            }
            Limit::StreamsPerConnection => (limits.streams_per_connection as f64, None),
            Limit::StreamsPerCaller => {
                (or(limits.streams_per_caller, Limits::STREAMS_PER_CALLER), most(Counted::Calls))
            }
            Limit::Requests => (f64::from(limits.requests_per_s.unwrap_or(Limits::REQUESTS_PER_S)), None),
            Limit::Worlds => (limits.worlds as f64, whole(Whole::Worlds)),
            Limit::WorldsPerCaller => {
                (or(limits.worlds_per_caller, Limits::WORLDS_PER_CALLER), most(Counted::Worlds))
            }
            Limit::Robots => (limits.robots as f64, whole(Whole::Robots)),
            Limit::RobotsPerWorld => (limits.robots_per_world as f64, None),
            Limit::Snapshots => (limits.snapshots as f64, whole(Whole::Snapshots)),
            Limit::SnapshotsPerWorld => (limits.snapshots_per_world as f64, None),
            Limit::Memory => (limits.memory_bytes as f64, Some(memory.held() as f64)),
            Limit::Waiting => (limits.waiting as f64, Some(parsing.counts().0 as f64)),
            Limit::Overload => (limits.overload_after_s as f64, Some(overload.seconds(clock::now()) as f64)),
            Limit::UnreadPerStream => (limits.unread_per_stream as f64, None),
            Limit::UnreadPerCaller => {
                let most = limits.unread_per_caller.unwrap_or(Limits::UNREAD_PER_CALLER);
                (most as f64, Some(accounts.most_unread() as f64))
            }
            Limit::Unread => (limits.unread as f64, Some(self.unread().held() as f64)),
        }
    }

    /// Counts something that was refused, or that had to go.
    pub(crate) fn note(&self, limit: Limit, what: &str) {
        self.0.refused[limit as usize].fetch_add(1, Ordering::Relaxed);
        if let Some(times) = self.0.logged[limit as usize].note(clock::now()) {
            tracing::warn!(times, limit = limit.name(), option = limit.option(), what, "a limit is reached");
        }
    }

    /// Counts a refusal, with its words.
    pub(super) fn refuse(&self, limit: Limit, what: String, retry_after: Option<Duration>) -> Exceeded {
        self.note(limit, &what);
        Exceeded { limit, what, retry_after }
    }
}

// Connections, calls and requests.
impl InForce {
    /// All places for connections are taken.
    pub(crate) fn no_connection(&self) -> Exceeded {
        let what = format!("the server has {} connections", self.limits().connections);
        self.refuse(Limit::Connections, what, None)
    }

    /// So many connections have a place.
    pub(crate) fn note_connections(&self, taken: usize) {
        self.0.counts[Whole::Connections as usize].store(taken, Ordering::Relaxed);
    }

    /// A connection from this address, or of this user.
    ///
    /// # Errors
    /// If there are too many.
    pub(crate) fn connection_of_address(&self, tally: &Arc<Tally>) -> Result<Taken, Exceeded> {
        let limits = self.limits();
        let most = tally.account().most(limits.connections_per_address, limits.half_of_connections());
        self.take(tally, Counted::Connections, most, Limit::ConnectionsPerAddress, "connections")
    }

    /// A connection of the holder of this token.
    ///
    /// # Errors
    /// If there are too many.
    pub(crate) fn connection_of_token(&self, tally: &Arc<Tally>) -> Result<Taken, Exceeded> {
        let set = self.limits().connections_per_token;
        let most = tally.account().most(set, Limits::CONNECTIONS_PER_TOKEN);
        self.take(tally, Counted::Connections, most, Limit::ConnectionsPerToken, "connections")
    }

    /// A call of this caller.
    ///
    /// # Errors
    /// If too many are open.
    pub(crate) fn call(&self, tally: &Arc<Tally>) -> Result<Taken, Exceeded> {
        let most = tally.account().most(self.limits().streams_per_caller, Limits::STREAMS_PER_CALLER);
        self.take(tally, Counted::Calls, most, Limit::StreamsPerCaller, "open calls")
    }

    /// Another call on a connection that has so many.
    ///
    /// # Errors
    /// If that is too many.
    pub(crate) fn call_on_connection(&self, open: &AtomicUsize) -> Result<(), Exceeded> {
        let most = self.limits().streams_per_connection;
        if count_up(open, most) {
            return Ok(());
        }
        let what = format!("this connection has {most} open calls");
        Err(self.refuse(Limit::StreamsPerConnection, what, None))
    }

    /// A request of this caller.
    ///
    /// # Errors
    /// If there are too many in a second.
    pub(crate) fn request(&self, tally: &Tally) -> Result<(), Exceeded> {
        let Some(per_s) = tally.account().most(self.limits().requests_per_s, Limits::REQUESTS_PER_S) else {
            return Ok(());
        };
        tally.request(clock::now(), per_s, Limits::burst(per_s)).map_err(|wait| {
            let what = format!("{} has made {per_s} requests in a second", tally.account());
            self.refuse(Limit::Requests, what, Some(wait))
        })
    }

    /// Those who make answers.
    pub(crate) fn making(&self) -> &Making {
        &self.0.making
    }

    /// The bytes that wait for clients.
    pub(super) fn unread(&self) -> &Unread {
        &self.0.unread
    }

    fn take(
        &self,
        tally: &Arc<Tally>,
        counted: Counted,
        most: Option<usize>,
        limit: Limit,
        things: &str,
    ) -> Result<Taken, Exceeded> {
        tally.take(counted, most).ok_or_else(|| {
            let what = format!("{} has {} {things}", tally.account(), most.unwrap_or_default());
            self.refuse(limit, what, None)
        })
    }
}

/// The interval of the reports that worlds lag.
const EACH_MINUTE: Duration = Duration::from_secs(60);
