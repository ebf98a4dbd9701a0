//! The limits of a running server, and what is used of them.

mod worlds;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;

use super::Limits;
use super::accounts::{Account, Accounts, Taken, Tally, count_up};
use super::limit::{Counted, Exceeded, LIMITS, Limit, LimitInfo};
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
    /// The throttle of the messages of all worlds that lag.
    lags: Throttle,
    unread: Unread,
    making: Making,
    /// Places of the server that are taken, by limit.
    counts: [AtomicUsize; LIMITS.len()],
    refused: [AtomicU64; LIMITS.len()],
    logged: [Throttle; LIMITS.len()],
}

/// A limit as it stands.
pub(crate) struct Usage {
    pub(crate) info: &'static LimitInfo,
    /// `None` if it does not hold.
    pub(crate) value: Option<u64>,
    /// `None` if that is not counted for the server; of a limit for each caller, what the one has that has most.
    pub(crate) used: Option<u64>,
    /// The number of refusals.
    pub(crate) refused: u64,
}

/// Places that are taken until this is dropped.
pub(crate) struct Place {
    limits: InForce,
    limit: Limit,
    count: usize,
}

impl Drop for Place {
    fn drop(&mut self) {
        self.limits.0.counts[self.limit as usize].fetch_sub(self.count, Ordering::Relaxed);
    }
}

impl InForce {
    pub(crate) fn new(limits: Limits) -> Self {
        Self(Arc::new(Shared {
            accounts: Accounts::default(),
            memory: Arc::default(),
            parsing: Parsing::new(limits.count(Limit::Parsing)),
            overload: Overload::default(),
            lags: Throttle::each(EACH_MINUTE),
            unread: Unread::default(),
            making: Making::new(limits.count(Limit::Parsing)),
            counts: Default::default(),
            refused: Default::default(),
            logged: Default::default(),
            limits,
        }))
    }

    /// The value of a limit.
    pub(crate) fn value(&self, limit: Limit) -> u64 {
        self.0.limits.value(limit)
    }

    /// The value of a limit that counts what is in this process.
    pub(crate) fn count(&self, limit: Limit) -> usize {
        self.0.limits.count(limit)
    }

    /// The value of a limit for one caller, if it holds for this one.
    pub(super) fn value_for(&self, limit: Limit, tally: &Tally) -> Option<u64> {
        self.0.limits.value_for(limit, tally.account())
    }

    /// The counts of an account.
    pub(crate) fn tally(&self, account: &Account) -> Arc<Tally> {
        self.0.accounts.of(account)
    }

    /// All limits with their values, their use, and the number of refusals.
    pub(crate) fn usage(&self) -> impl Iterator<Item = Usage> {
        LIMITS.iter().map(|info| Usage {
            info,
            value: Some(self.value(info.limit)).filter(|&value| value != u64::MAX),
            used: self.used(info),
            refused: self.0.refused[info.limit as usize].load(Ordering::Relaxed),
        })
    }

    /// A limit as it stands for one caller.
    pub(crate) fn of_caller(&self, usage: Usage, tally: &Tally) -> Usage {
        let limit = usage.info.limit;
        if !usage.info.usual.is_for_others() {
            return usage;
        }
        // A connection is counted for its address, whose token comes later.
        let is_of_address = limit == Limit::ConnectionsPerAddress && tally.account().is_token();
        let used = match usage.info.counted {
            Counted::ByCaller => (!is_of_address).then(|| tally.taken(limit)),
            Counted::UnreadByCaller => Some(tally.unread()),
            Counted::InServer
            | Counted::Elsewhere
            | Counted::Memory
            | Counted::Parsing
            | Counted::Waiting
            | Counted::Lag
            | Counted::Unread => usage.used,
        };
        Usage { value: self.value_for(limit, tally), used, ..usage }
    }

    fn used(&self, info: &LimitInfo) -> Option<u64> {
        let Shared { accounts, memory, parsing, overload, unread, counts, .. } = &*self.0;
        Some(match info.counted {
            Counted::InServer => counts[info.limit as usize].load(Ordering::Relaxed) as u64,
            Counted::ByCaller => accounts.most(info.limit),
            Counted::Elsewhere => return None,
            Counted::Memory => memory.held(),
            Counted::Parsing => parsing.counts().1 as u64,
            Counted::Waiting => parsing.counts().0 as u64,
            Counted::Lag => overload.seconds(clock::now()),
            Counted::Unread => unread.held(),
            Counted::UnreadByCaller => accounts.most_unread(),
        })
    }

    /// Counts something that was refused, or that had to go.
    pub(crate) fn note(&self, limit: Limit, what: &str) {
        self.0.refused[limit as usize].fetch_add(1, Ordering::Relaxed);
        if let Some(times) = self.0.logged[limit as usize].note(clock::now()) {
            let LimitInfo { name, option, .. } = limit.info();
            tracing::warn!(times, limit = name, option, what, "a limit is reached");
        }
    }

    /// Another one of what this limits for the caller, in these words.
    ///
    /// # Errors
    /// If it has too many.
    pub(crate) fn take(&self, limit: Limit, tally: &Arc<Tally>, things: &str) -> Result<Taken, Exceeded> {
        let most = self.value_for(limit, tally).map_or(usize::MAX, |most| most as usize);
        tally
            .take(limit, most)
            .ok_or_else(|| self.refuse(limit, format!("{} has {most} {things}", tally.account()), None))
    }

    /// The place of another one of what this limits for the server, in these words.
    ///
    /// # Errors
    /// If the server has too many.
    pub(crate) fn one(&self, limit: Limit, things: &str) -> Result<Place, Exceeded> {
        self.place(limit, 1)
            .ok_or_else(|| self.refuse(limit, format!("the server has {} {things}", self.value(limit)), None))
    }

    /// Places of the server for so many more of what this limits; `None` if there are not so many.
    fn place(&self, limit: Limit, count: usize) -> Option<Place> {
        let most = self.count(limit);
        let more = |n: usize| n.checked_add(count).filter(|&sum| sum <= most);
        self.0.counts[limit as usize].fetch_update(Ordering::Relaxed, Ordering::Relaxed, more).ok()?;
        Some(Place { limits: self.clone(), limit, count })
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
        let what = format!("the server has {} connections", self.value(Limit::Connections));
        self.refuse(Limit::Connections, what, None)
    }

    /// Notes the number of connections that have a place.
    pub(crate) fn note_connections(&self, taken: usize) {
        self.0.counts[Limit::Connections as usize].store(taken, Ordering::Relaxed);
    }

    /// Another call on a connection that has so many.
    ///
    /// # Errors
    /// If that is too many.
    pub(crate) fn call_on_connection(&self, open: &AtomicUsize) -> Result<(), Exceeded> {
        let most = self.count(Limit::StreamsPerConnection);
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
        let Some(per_s) = self.requests_per_s(tally) else { return Ok(()) };
        tally.request(clock::now(), per_s, burst(per_s)).map_err(|wait| {
            let what = format!("{} has made {per_s} requests in a second", tally.account());
            self.refuse(Limit::RequestsPerS, what, Some(wait))
        })
    }

    /// Whether this caller has had no more bytes than it may.
    pub(super) fn has_budget(&self, tally: &Tally) -> bool {
        let per_s = self.requests_per_s(tally);
        per_s.is_none_or(|per_s| tally.has_budget(clock::now(), per_s, burst(per_s)))
    }

    /// Requests that this caller may make in a second, if there is an end to them.
    pub(super) fn requests_per_s(&self, tally: &Tally) -> Option<u32> {
        let per_s = self.value_for(Limit::RequestsPerS, tally)?;
        Some(u32::try_from(per_s).unwrap_or(u32::MAX))
    }

    /// The makers of answers.
    pub(crate) fn making(&self) -> &Making {
        &self.0.making
    }

    /// The bytes that wait for clients.
    pub(super) fn unread(&self) -> &Unread {
        &self.0.unread
    }
}

/// Calls that a caller may begin at once that has made none for a while.
fn burst(per_s: u32) -> u32 {
    per_s.saturating_mul(2)
}

/// The interval of the reports that worlds lag.
const EACH_MINUTE: Duration = Duration::from_secs(60);
