//! Accounts: what is counted for each caller.

use std::collections::HashMap;
use std::fmt;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use baudbot_access::{GrantName, TokenHash};

use super::bucket::Bucket;
use super::limit::{LIMITS, Limit};
use crate::access::Caller;
use crate::system::is_this_user;

/// Whom something is counted for.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Account {
    /// This process.
    Process,
    /// A user of this machine, at the other end of a Unix socket.
    User(u32),
    /// An address; of IPv6 a network, as a machine has as many addresses of it as it likes.
    Address(IpAddr),
    /// The holder of a token.
    Token(TokenHash, GrantName),
}

impl Account {
    /// The account of an address.
    pub(crate) fn of_address(address: IpAddr) -> Self {
        Self::Address(match address.to_canonical() {
            IpAddr::V6(ip) if !ip.is_loopback() => Ipv6Addr::from_bits(ip.to_bits() & NETWORK).into(),
            ip @ (IpAddr::V4(_) | IpAddr::V6(_)) => ip,
        })
    }

    /// The account of a caller, which is that of its address unless it has a token.
    pub(crate) fn of(caller: &Caller, peer: &Self) -> Self {
        match caller {
            Caller::Holder(grant) => Self::Token(grant.hash, grant.name.clone()),
            Caller::Trusted | Caller::Nobody => peer.clone(),
        }
    }

    /// Whether it is that of a token.
    pub(super) fn is_token(&self) -> bool {
        matches!(self, Self::Token(..))
    }

    /// Whether it is the user's who runs the server, or of this machine.
    pub(super) fn is_own(&self) -> bool {
        match self {
            Self::Process => true,
            Self::User(uid) => is_this_user(*uid),
            Self::Address(ip) => ip.is_loopback(),
            Self::Token(_, name) => name.as_str() == LOCAL,
        }
    }
}

/// The name of the server's own token.
const LOCAL: &str = "local";

/// The network of an IPv6 address that belongs to one customer.
const NETWORK: u128 = !((1 << 64) - 1);

impl fmt::Display for Account {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Process => f.write_str("this process"),
            Self::User(uid) => write!(f, "the user {uid}"),
            Self::Address(ip) => write!(f, "the address {ip}"),
            Self::Token(_, name) => write!(f, "the token `{}`", name.as_str()),
        }
    }
}

/// The other end of a pipe in memory.
#[derive(Clone, Debug)]
pub(crate) struct Peer {
    pub(crate) caller: Caller,
    pub(crate) account: Account,
}

impl Peer {
    /// This process.
    pub(crate) fn process() -> Self {
        Self { caller: Caller::Trusted, account: Account::Process }
    }
}

/// The tally for which a call is counted.
#[derive(Clone)]
pub(crate) struct Payer(pub(crate) Arc<Tally>);

/// The counts of an account.
#[derive(Debug)]
pub(crate) struct Tally {
    account: Account,
    /// The counts, by limit.
    counts: [AtomicUsize; LIMITS.len()],
    /// Bytes that wait until it reads them.
    unread: AtomicU64,
    requests: Mutex<Bucket>,
}

impl Tally {
    fn new(account: Account) -> Self {
        Self { account, counts: Default::default(), unread: AtomicU64::new(0), requests: Mutex::default() }
    }

    pub(crate) fn account(&self) -> &Account {
        &self.account
    }

    /// Counts another one, unless there are so many.
    pub(super) fn take(self: &Arc<Self>, limit: Limit, most: usize) -> Option<Taken> {
        let counted = count_up(&self.counts[limit as usize], most);
        counted.then(|| Taken { tally: Arc::clone(self), limit })
    }

    /// The number of things that it has of what this limits.
    pub(super) fn taken(&self, limit: Limit) -> u64 {
        self.counts[limit as usize].load(Ordering::Relaxed) as u64
    }

    /// Counts a request.
    ///
    /// # Errors
    /// When there may be another one.
    pub(super) fn request(&self, now: Instant, per_s: u32, burst: u32) -> Result<(), Duration> {
        self.requests().take(now, per_s, burst)
    }

    /// Counts responses as so many requests, whether the caller may have made as many or not.
    pub(super) fn charge(&self, now: Instant, per_s: u32, requests: u32) {
        self.requests().charge(now, per_s, requests);
    }

    /// Whether it has not had more than so many requests are worth.
    pub(super) fn has_budget(&self, now: Instant, per_s: u32, burst: u32) -> bool {
        self.requests().has_one(now, per_s, burst)
    }

    /// Bytes that wait until it reads them.
    pub(super) fn unread(&self) -> u64 {
        self.unread.load(Ordering::Relaxed)
    }

    pub(super) fn add_unread(&self, bytes: u64) {
        self.unread.fetch_add(bytes, Ordering::Relaxed);
    }

    pub(super) fn sub_unread(&self, bytes: u64) {
        self.unread.fetch_sub(bytes, Ordering::Relaxed);
    }

    fn requests(&self) -> MutexGuard<'_, Bucket> {
        self.requests.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Adds one to a count, unless it is at its limit.
pub(super) fn count_up(count: &AtomicUsize, most: usize) -> bool {
    count.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| (n < most).then(|| n + 1)).is_ok()
}

/// Something that is counted until this is dropped.
#[derive(Debug)]
pub(crate) struct Taken {
    tally: Arc<Tally>,
    limit: Limit,
}

impl Drop for Taken {
    fn drop(&mut self) {
        self.tally.counts[self.limit as usize].fetch_sub(1, Ordering::Relaxed);
    }
}

/// All accounts of a server.
#[derive(Default)]
pub(super) struct Accounts(Mutex<HashMap<Account, Arc<Tally>>>);

impl Accounts {
    pub(super) fn of(&self, account: &Account) -> Arc<Tally> {
        let mut tallies = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(tally) = tallies.get(account) {
            return Arc::clone(tally);
        }
        if tallies.len() >= MANY && tallies.len().is_power_of_two() {
            let now = Instant::now();
            tallies.retain(|_, tally| Arc::strong_count(tally) > 1 || !tally.requests().is_full(now));
        }
        let tally = Arc::new(Tally::new(account.clone()));
        tallies.insert(account.clone(), Arc::clone(&tally));
        tally
    }

    /// The count of the account that has most of what this limits.
    pub(super) fn most(&self, limit: Limit) -> u64 {
        self.most_of(|tally| tally.taken(limit))
    }

    /// Bytes that wait for the account that leaves most unread.
    pub(super) fn most_unread(&self) -> u64 {
        self.most_of(Tally::unread)
    }

    fn most_of(&self, count: impl Fn(&Tally) -> u64) -> u64 {
        let tallies = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        tallies.values().map(|tally| count(tally)).max().unwrap_or(0)
    }
}

/// The number of accounts from which on, and at each doubling, unused ones are removed.
const MANY: usize = 256;

#[cfg(test)]
mod tests {
    use super::*;

    fn address(text: &str) -> Account {
        Account::of_address(text.parse().unwrap())
    }

    #[test]
    fn what_is_taken_is_given_back() {
        let accounts = Accounts::default();
        let tally = accounts.of(&address("10.0.0.7"));
        let first = tally.take(Limit::WorldsPerCaller, 1).unwrap();
        assert!(accounts.of(&address("10.0.0.7")).take(Limit::WorldsPerCaller, 1).is_none());
        assert!(accounts.of(&address("10.0.0.8")).take(Limit::WorldsPerCaller, 1).is_some());
        assert!(tally.take(Limit::StreamsPerCaller, 1).is_some(), "another thing");
        assert_eq!(accounts.most(Limit::WorldsPerCaller), 1);
        drop(first);
        assert!(tally.take(Limit::WorldsPerCaller, 1).is_some());
    }

    #[test]
    fn a_network_of_ipv6_is_one_account_and_ipv4_is_the_same_within_it() {
        assert_eq!(address("2001:db8::1"), address("2001:db8::ffff:1"));
        assert_ne!(address("2001:db8::1"), address("2001:db8:0:1::1"));
        assert_eq!(address("::ffff:10.0.0.7"), address("10.0.0.7"));
    }

    #[test]
    fn accounts_that_nobody_needs_are_forgotten() {
        let accounts = Accounts::default();
        let kept = accounts.of(&address("10.1.0.1"));
        for i in 0..100_000_u32 {
            accounts.of(&Account::of_address(IpAddr::from(i.to_be_bytes())));
        }
        assert!(accounts.0.lock().unwrap().len() <= 2 * MANY);
        assert!(Arc::ptr_eq(&kept, &accounts.of(&address("10.1.0.1"))));
    }
}
