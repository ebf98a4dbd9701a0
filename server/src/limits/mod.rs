//! Limits: how much of the server one client, one address, one holder of a token, and all of them together may have.
//!
//! # Need
//!
//! A server that many people use has to refuse what it cannot bear, and say so, before it harms those who are there already. What is
//! not counted is not bounded.
//!
//! # Assumptions
//!
//! Whoever runs the server may do anything to it anyway. So the limits for one caller do not hold for this process, for the server's
//! own token, for its user's Unix sockets and for addresses of this machine, unless they were set on purpose.
//!
//! # Mechanism
//!
//! - [`Limits`] has the values, and is the only place with their defaults. [`Limit`] has their names, and the words of refusals.
//! - [`InForce`] has the limits of a running server and what is used of them. What takes something gets a guard, and gives it back by
//!   dropping that.
//! - [`Accounts`](accounts::Accounts) count by caller, [`Memory`](memory::Memory) counts bytes, [`Parsing`](parsing::Parsing) is the
//!   queue for scenarios, [`Overload`](overload::Overload) knows whether worlds keep their pace, [`Unread`](unread::Unread) counts what
//!   waits for clients.

mod accounts;
mod bucket;
mod charges;
mod in_force;
mod limit;
mod machine;
mod making;
mod memory;
mod overload;
mod parsing;
mod unread;

use std::time::Duration;

pub(crate) use accounts::{Account, Payer, Peer, Taken, Tally};
pub(crate) use charges::{Charges, SnapshotCharge};
pub(crate) use in_force::{InForce, Place};
pub(crate) use limit::{Exceeded, Limit};
pub(crate) use memory::{Held, ScenarioHeld};
pub(crate) use parsing::Cancelled;
pub(crate) use unread::{Inbox, Outbox, Parts};

use crate::system::usual_connections;

/// The limits of a server. `docs/reference/limits.md` has what each of them is for.
///
/// A *caller* is the holder of a token; where none was shown, an address, or the user at the other end of a Unix socket. Where a limit
/// for one caller or one address is `None`, its default holds for others than the user who runs the server.
///
/// ```
/// use baudbot_server::{Limits, Server};
/// let builder = Server::builder().limits(Limits { worlds: 8, ..Limits::default() });
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// Connections at a time, over all addresses and viewers.
    pub connections: usize,
    /// Connections of one address, or of one user by Unix sockets; without it half of all.
    pub connections_per_address: Option<usize>,
    /// Connections whose first token is the same; without it [`Self::CONNECTIONS_PER_TOKEN`].
    pub connections_per_token: Option<usize>,
    /// Calls of one connection that are open at a time.
    pub streams_per_connection: usize,
    /// Calls of one caller that are open at a time; without it [`Self::STREAMS_PER_CALLER`].
    pub streams_per_caller: Option<usize>,
    /// Calls that one caller may begin in a second, and twice as many after a pause; without it [`Self::REQUESTS_PER_S`]. What is
    /// sent in a stream that is open is no call.
    pub requests_per_s: Option<u32>,
    /// Worlds.
    pub worlds: usize,
    /// Worlds that one caller has created; without it [`Self::WORLDS_PER_CALLER`].
    pub worlds_per_caller: Option<usize>,
    /// Robots of all worlds.
    pub robots: usize,
    /// Robots of one world.
    pub robots_per_world: usize,
    /// Snapshots of all worlds.
    pub snapshots: usize,
    /// Snapshots of one world. The oldest goes when there would be more.
    pub snapshots_per_world: usize,
    /// Bytes of scenarios, states and snapshots, and of what it takes to read them.
    pub memory_bytes: u64,
    /// Scenarios, states and recordings that are read at a time: each takes a processor.
    pub parsing: usize,
    /// Requests that wait until theirs is read.
    pub waiting: usize,
    /// No more worlds are started in a pace other than lockstep, once worlds in real time have let time go in each of so many
    /// seconds; 0 for always.
    pub overload_after_s: u64,
    /// Bytes that wait until clients read them, of all streams.
    pub unread: u64,
    /// Those of one caller; without it [`Self::UNREAD_PER_CALLER`].
    pub unread_per_caller: Option<u64>,
    /// Those of one stream of frames: further frames are missed.
    pub unread_per_stream: u64,
}

impl Limits {
    /// Connections of the holder of a token.
    pub const CONNECTIONS_PER_TOKEN: usize = 256;
    /// Calls of a caller that are open at a time.
    pub const STREAMS_PER_CALLER: usize = 1024;
    /// Calls that a caller may begin in a second.
    pub const REQUESTS_PER_S: u32 = 2000;
    /// Worlds of a caller.
    pub const WORLDS_PER_CALLER: usize = 512;
    /// Bytes that wait until a caller reads them.
    pub const UNREAD_PER_CALLER: u64 = 64 << 20;

    /// The default of one address's, or one user's, part of all connections.
    pub(crate) fn half_of_connections(&self) -> usize {
        (self.connections / 2).max(1)
    }

    /// So many percent of the memory of the machine, or of the group of processes (cgroup) that this one is in; no limit where the
    /// system does not say how much that is.
    #[must_use]
    pub fn share_of_memory(percent: u64) -> u64 {
        machine::memory_bytes().map_or(u64::MAX, |bytes| bytes / 100 * percent)
    }

    /// Those of worlds without a server.
    pub(crate) fn none() -> Self {
        Self { memory_bytes: u64::MAX, ..Self::usual(usize::MAX, 1) }
    }

    fn usual(connections: usize, processors: usize) -> Self {
        Self {
            connections,
            connections_per_address: None,
            connections_per_token: None,
            streams_per_connection: 4096,
            streams_per_caller: None,
            requests_per_s: None,
            worlds: crate::MAX_WORLDS,
            worlds_per_caller: None,
            robots: 1_000_000,
            robots_per_world: 10_000,
            snapshots: 65_536,
            snapshots_per_world: 64,
            memory_bytes: 0,
            parsing: processors,
            waiting: 256,
            overload_after_s: 3,
            unread: 128 << 20,
            unread_per_caller: None,
            unread_per_stream: 16 << 20,
        }
    }

    /// Calls that a caller may begin at once that has made none for a while.
    pub(crate) fn burst(per_s: u32) -> u32 {
        per_s.saturating_mul(2)
    }
}

impl Default for Limits {
    fn default() -> Self {
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        Self {
            memory_bytes: Self::share_of_memory(USUAL_SHARE),
            ..Self::usual(usual_connections(), processors)
        }
    }
}

/// The share of memory, in percent, of a server that is not told another. The rest is for connections, for what ticks need meanwhile,
/// and for lists of worlds that run, which have room for more than is in them.
const USUAL_SHARE: u64 = 50;

/// The time that a client is to wait which was refused because of others.
pub(crate) const SOON: Duration = Duration::from_secs(1);
