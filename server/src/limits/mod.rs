//! Limits: how much of the server one client, one address, one holder of a token, and all of them together may have.
//!
//! # Need
//!
//! A server that many people use has to refuse what it cannot bear, and say so, before it harms those who are there already. What is
//! not counted is not bounded.
//!
//! # Assumptions
//!
//! The user who runs the server may do anything to it anyway. So the limits for one caller do not hold for this
//! process, for the server's own token, for its user's Unix sockets and for addresses of this machine, unless they were
//! set on purpose.
//!
//! # Mechanism
//!
//! - [`LIMITS`] is the table of all limits: names, options, defaults and words. [`Limits`] has the values of a server. Another limit is a line
//!   of the table, and what asks [`InForce`] for it.
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
pub(crate) use in_force::{InForce, Place, Usage};
pub(crate) use limit::Exceeded;
pub use limit::{LIMITS, Limit, LimitInfo, Unit, Usual};
pub(crate) use memory::{Held, ScenarioHeld};
pub(crate) use parsing::Cancelled;
pub(crate) use unread::{Inbox, Outbox, Parts};

use crate::system::usual_connections;

/// The limits of a server: values of [`LIMITS`]. `docs/reference/limits.md` has what each of them is for.
///
/// A *caller* is the holder of a token; where none was shown, an address, or the user at the other end of a Unix socket. The usual value of
/// a limit for one caller or one address holds for others than the user who runs the server; one that is given, for all.
///
/// ```
/// use baudbot_server::{Limit, Limits, Server};
/// let builder = Server::builder().limits(Limits::default().with(Limit::Worlds, 8));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limits {
    values: [u64; LIMITS.len()],
    is_given: [bool; LIMITS.len()],
}

impl Limits {
    /// The limits with this value of one of them.
    #[must_use]
    pub fn with(mut self, limit: Limit, value: u64) -> Self {
        (self.values[limit as usize], self.is_given[limit as usize]) = (value, true);
        self
    }

    /// The value of a limit, for those for whom it holds.
    pub fn value(&self, limit: Limit) -> u64 {
        if !self.is_given[limit as usize] && limit.info().usual == Usual::HalfOfConnections {
            return (self.value(Limit::Connections) / 2).max(1);
        }
        self.values[limit as usize]
    }

    /// The value of a limit that counts what is in this process.
    pub(crate) fn count(&self, limit: Limit) -> usize {
        usize::try_from(self.value(limit)).unwrap_or(usize::MAX)
    }

    /// The value of a limit for one caller, if it holds for this one.
    fn value_for(&self, limit: Limit, account: &Account) -> Option<u64> {
        let holds = self.is_given[limit as usize] || !account.is_own();
        (*account != Account::Process && holds).then(|| self.value(limit))
    }

    /// The bytes of a percentage of the memory of the machine, or of the group of processes (cgroup) that this one is
    /// in; no limit where the system does not report it.
    #[must_use]
    pub fn share_of_memory(percent: u64) -> u64 {
        machine::memory_bytes().map_or(u64::MAX, |bytes| bytes / 100 * percent)
    }

    /// The limits of worlds without a server.
    pub(crate) fn none() -> Self {
        Self::usual(usize::MAX, 1, u64::MAX)
    }

    fn usual(connections: usize, processors: usize, memory_bytes: u64) -> Self {
        let values = LIMITS.map(|info| match info.usual {
            Usual::Number(number) | Usual::ForOthers(number) => number,
            Usual::Files => connections as u64,
            // The value follows from another limit.
            Usual::HalfOfConnections => 0,
            Usual::HalfOfMemory => memory_bytes,
            Usual::Processors => processors as u64,
        });
        Self { values, is_given: [false; LIMITS.len()] }
    }
}

impl Default for Limits {
    fn default() -> Self {
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        Self::usual(usual_connections(), processors, Self::share_of_memory(50))
    }
}

/// The time that a client is to wait which was refused because of others.
pub(crate) const SOON: Duration = Duration::from_secs(1);

#[cfg(test)]
mod tests {
    use super::*;

    fn address(text: &str) -> Account {
        Account::of_address(text.parse().unwrap())
    }

    #[test]
    fn limits_for_one_caller_are_for_others_unless_they_are_set() {
        const LIMIT: Limit = Limit::WorldsPerCaller;
        let (usual, set) = (Limits::none(), Limits::none().with(LIMIT, 2));
        for own in [address("127.0.0.1"), address("::1"), Account::User(rustix::process::geteuid().as_raw())]
        {
            assert_eq!((usual.value_for(LIMIT, &own), set.value_for(LIMIT, &own)), (None, Some(2)), "{own}");
        }
        assert_eq!(set.value_for(LIMIT, &Account::Process), None);
        assert_eq!(usual.value_for(LIMIT, &address("10.0.0.7")), Some(512));
    }

    #[test]
    fn an_address_has_half_of_the_connections_that_are_there() {
        let limits = Limits::default().with(Limit::Connections, 9);
        assert_eq!(limits.value(Limit::ConnectionsPerAddress), 4);
        assert_eq!(limits.with(Limit::ConnectionsPerAddress, 7).value(Limit::ConnectionsPerAddress), 7);
    }
}
