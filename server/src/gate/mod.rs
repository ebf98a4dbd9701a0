//! The gate: how many connections a server has, over all of its listeners, and which of them it keeps.
//!
//! # Need
//!
//! A process may have so many open files and not more, and a connection is one of them. Without a limit, clients that
//! connect and do nothing take all of them, and then neither an operator gets in nor a recording gets its file. So there are
//! *places*, fewer than the process may have files (`descriptors`), and a connection is useful only with a place.
//!
//! # Assumptions
//!
//! A client connects because it wants something, and calls at once. One that has made a call that it may make is in use
//! from then on and may be silent for as long as it likes: a brain in a world that stands says nothing for hours. One
//! that has made no call is broken, lost, or hostile, and another client can use its place. So it is with a stranger,
//! which has only made calls that were refused, or calls that need no right.
//!
//! # Mechanism
//!
//! - A connection takes a place, as long as one is free. It then has to make its first call within some seconds
//!   (`patience`), or it is closed.
//! - When no place is free, a new connection gets that of the connection which has been silent for longest, or else that of the oldest stranger,
//!   which is closed for it. A flood of connections without calls, or without a token, so displaces itself, and never those that are in use.
//! - A connection that sends too many frames which carry nothing (`frames`) is closed.
//! - A connection that abandons a thousand calls more than it lets be answered is closed: it wants work and no answers.
//! - So that no address takes all places, each may have so many, as may the holder of a token; a connection belongs to the first token
//!   that is shown on it.
//! - When all places are in use, or all that an address may have, a new connection is let in without a place, only so that its first call can be answered
//!   by a status that says why; a connection that was merely closed would tell a client nothing. Of these there are few, as
//!   each takes one of the files that were left over, and none stays for longer than two seconds.
//!
//! [`Gate`] counts, [`Connection`] is a connection as it is read and written, [`GatedListener`] accepts them.

mod calls;
mod connection;
mod frames;
mod incoming;
mod listener;
mod metered;
mod printed;
mod tls;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

use futures_util::task::AtomicWaker;

pub(crate) use calls::CheckCalls;
pub(crate) use connection::Connection;
pub(crate) use incoming::Incoming;
pub(crate) use listener::{GatedListener, PageConnection, TcpEntry, connections};
pub use tls::{Tls, TlsError};

use crate::access::Caller;
use crate::limits::{Account, Exceeded, InForce, Limit, Taken, Tally};
use crate::log::Throttle;

/// The time for which a connection without a place has to call, and to take the answer.
const FAREWELL: Duration = Duration::from_secs(2);

/// Counts the connections of a server. Clones share the count.
#[derive(Clone)]
pub(crate) struct Gate(Arc<Shared>);

struct Shared {
    limits: InForce,
    /// The time that a connection has to make its first call.
    patience: Duration,
    occupancy: Mutex<Occupancy>,
    accept_errors: Throttle,
    /// Connections that are closed for what they send.
    floods: Throttle,
}

/// The connections of a server, by number: the oldest come first.
#[derive(Default)]
struct Occupancy {
    /// Places that are taken.
    taken: usize,
    last_number: u64,
    /// Connections with a place that have not made a call.
    silent: BTreeMap<u64, Arc<Admission>>,
    /// Connections with a place that have made calls, but none that only a known caller may make.
    strangers: BTreeMap<u64, Arc<Admission>>,
    /// Connections without a place.
    refused: BTreeMap<u64, Arc<Admission>>,
}

/// The state of a connection at the gate, shared between the gate, the connection and its calls.
pub(crate) struct Admission {
    gate: Gate,
    number: u64,
    /// The caller at the other end, if the system knows it.
    caller: Option<Caller>,
    /// The tally of the caller's address, or of its user.
    tally: Arc<Tally>,
    /// The count at that tally, or the reason why the connection has no place.
    counted: Result<Taken, Exceeded>,
    /// The count for the first token that was shown on the connection.
    token: OnceLock<Taken>,
    /// Calls that are open.
    calls: AtomicUsize,
    /// Changes only while the occupancy is locked.
    has_place: AtomicBool,
    /// Whether it has made a call.
    has_called: AtomicBool,
    /// Whether it has made a call that only a known caller may make, and stays.
    is_known: AtomicBool,
    /// Whether another connection needs its place, or it makes calls only to abandon them.
    is_evicted: AtomicBool,
    /// Calls that ended before they were answered, less those that were answered.
    abandoned: AtomicU32,
    /// The task that reads the connection.
    reader: AtomicWaker,
}

impl Gate {
    /// A gate with these limits; connections have so long to make their first call.
    pub(crate) fn new(limits: InForce, patience: Duration) -> Self {
        let (accept_errors, floods) = (Throttle::default(), Throttle::default());
        Self(Arc::new(Shared { limits, patience, occupancy: Mutex::default(), accept_errors, floods }))
    }

    /// The limits of the server.
    pub(crate) fn limits(&self) -> &InForce {
        &self.0.limits
    }

    /// Most connections at a time.
    fn places(&self) -> usize {
        self.0.limits.count(Limit::Connections)
    }

    /// The time that a connection has to make its first call.
    pub(crate) fn patience(&self) -> Duration {
        self.0.patience
    }

    /// Admits a new connection from there, with or without a place.
    fn admit(&self, caller: Option<Caller>, account: &Account) -> Arc<Admission> {
        let limits = &self.0.limits;
        let tally = limits.tally(account);
        let counted = limits.take(Limit::ConnectionsPerAddress, &tally, "connections");
        let mut occupancy = self.occupancy();
        let has_place = counted.is_ok() && occupancy.find_place(self.places());
        // The count is under the lock, as a connection that leaves changes it, too.
        limits.note_connections(occupancy.taken);
        let counted = if has_place { counted } else { counted.and_then(|_| Err(limits.no_connection())) };
        occupancy.last_number += 1;
        let number = occupancy.last_number;
        let admission = Arc::new(Admission {
            gate: self.clone(),
            number,
            caller,
            tally,
            counted,
            token: OnceLock::new(),
            calls: AtomicUsize::new(0),
            has_place: has_place.into(),
            has_called: false.into(),
            is_known: false.into(),
            is_evicted: false.into(),
            abandoned: 0.into(),
            reader: AtomicWaker::new(),
        });
        let queue = if has_place { &mut occupancy.silent } else { &mut occupancy.refused };
        queue.insert(number, Arc::clone(&admission));
        if occupancy.refused.len() > max_refused(self.places())
            && let Some((_, oldest)) = occupancy.refused.pop_first()
        {
            oldest.evict();
        }
        admission
    }

    /// Removes a connection that is gone.
    fn leave(&self, admission: &Admission) {
        let mut occupancy = self.occupancy();
        occupancy.silent.remove(&admission.number);
        occupancy.strangers.remove(&admission.number);
        occupancy.refused.remove(&admission.number);
        occupancy.taken -= usize::from(admission.has_place.load(Ordering::Relaxed));
        self.0.limits.note_connections(occupancy.taken);
    }

    fn occupancy(&self) -> MutexGuard<'_, Occupancy> {
        // The occupancy is consistent between any two of its changes.
        self.0.occupancy.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Occupancy {
    /// Takes a place that is free, or that of the connection that has been silent for longest, or that of the oldest stranger.
    fn find_place(&mut self, places: usize) -> bool {
        if self.taken < places {
            self.taken += 1;
            return true;
        }
        let oldest = self.silent.pop_first().or_else(|| self.strangers.pop_first());
        let Some((_, oldest)) = oldest else { return false };
        oldest.has_place.store(false, Ordering::Relaxed);
        oldest.evict();
        true
    }
}

impl Admission {
    /// The caller at the other end, if the system knows it.
    pub(crate) fn caller(&self) -> Option<&Caller> {
        self.caller.as_ref()
    }

    /// The tally of the caller's address, or of its user.
    pub(crate) fn tally(&self) -> &Arc<Tally> {
        &self.tally
    }

    /// The connection makes a request that is no call of gRPC.
    ///
    /// # Errors
    /// If it has no place, or there have been too many from there in the last second.
    pub(crate) fn note_request(&self) -> Result<(), Exceeded> {
        self.note_call()?;
        self.gate.0.limits.request(&self.tally)
    }

    /// Notes a call: from its first one on a connection stays as long as no other one needs its place.
    ///
    /// # Errors
    /// If it has no place.
    pub(crate) fn note_call(&self) -> Result<(), Exceeded> {
        if self.has_called.load(Ordering::Relaxed) {
            return Ok(());
        }
        let mut occupancy = self.gate.occupancy();
        if let Some(this) = occupancy.silent.remove(&self.number) {
            occupancy.strangers.insert(self.number, this);
            self.has_called.store(true, Ordering::Relaxed);
            return Ok(());
        }
        // One that was let in, and has had to make room since.
        Err(self.counted.as_ref().err().cloned().unwrap_or_else(|| self.gate.0.limits.no_connection()))
    }

    /// Notes a call for which the caller needs a right: the connection stays.
    pub(crate) fn note_known(&self) {
        if !self.is_known.load(Ordering::Relaxed)
            && self.gate.occupancy().strangers.remove(&self.number).is_some()
        {
            self.is_known.store(true, Ordering::Relaxed);
        }
    }

    /// The connection makes a call of this caller. Gives what counts the call while it is open.
    ///
    /// # Errors
    /// If the caller has too many connections, or the connection too many calls.
    pub(crate) fn open_call(self: &Arc<Self>, caller: &Arc<Tally>) -> Result<OpenOnConnection, Exceeded> {
        let limits = &self.gate.0.limits;
        if let Account::Token(..) = caller.account()
            && self.token.get().is_none()
        {
            // Two first calls at a time are counted as one.
            let _ = self.token.set(limits.take(Limit::ConnectionsPerToken, caller, "connections")?);
        }
        limits.call_on_connection(&self.calls)?;
        Ok(OpenOnConnection(Arc::clone(self)))
    }

    /// A call was answered.
    fn note_answered(&self) {
        let less = |abandoned: u32| abandoned.checked_sub(1);
        let _ = self.abandoned.fetch_update(Ordering::Relaxed, Ordering::Relaxed, less);
    }

    /// A call has ended before it was answered, as its client has reset it or has made the server do so.
    fn note_abandoned(&self) {
        if self.abandoned.fetch_add(1, Ordering::Relaxed) >= MOST_ABANDONED {
            self.evict();
        }
    }

    /// The time that it has to make its first call, or to get the refusal that it has no place.
    fn patience(&self) -> Duration {
        let has_place = self.has_place.load(Ordering::Relaxed);
        if has_place { self.gate.0.patience } else { self.gate.0.patience.min(FAREWELL) }
    }

    fn evict(&self) {
        self.is_evicted.store(true, Ordering::Relaxed);
        self.reader.wake();
    }
}

/// Calls that a connection may abandon beyond those that are answered. A client gives up a call now and then; each costs as much as
/// one that is answered, and no limit of streams at a time counts it.
const MOST_ABANDONED: u32 = 1000;
/// A call that is open on a connection.
pub(crate) struct OpenOnConnection(Arc<Admission>);

impl Drop for OpenOnConnection {
    fn drop(&mut self) {
        self.0.calls.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Connections without a place at a time. Few where there are few descriptors, for these are what was left for files.
fn max_refused(places: usize) -> usize {
    (places / 8).clamp(8, 64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;

    /// A gate with so many places.
    fn gate(connections: usize) -> Gate {
        Gate::new(
            InForce::new(Limits::none().with(Limit::Connections, connections as u64)),
            Duration::from_secs(10),
        )
    }

    /// A connection from this machine.
    fn admit(gate: &Gate) -> Arc<Admission> {
        gate.admit(None, &Account::of_address([127, 0, 0, 1].into()))
    }

    /// A call that it may make.
    fn call(admission: &Admission) {
        admission.note_call().unwrap();
        admission.note_known();
    }

    fn is_evicted(admission: &Admission) -> bool {
        admission.is_evicted.load(Ordering::Relaxed)
    }

    #[test]
    fn the_connection_that_has_been_silent_for_longest_gives_its_place_to_a_new_one() {
        let gate = gate(2);
        let [first, second, third] = [(); 3].map(|()| admit(&gate));
        assert_eq!([&first, &second, &third].map(|one| is_evicted(one)), [true, false, false]);
        assert!(first.note_call().is_err(), "its place is gone");
        // The connection leaves late, and takes no place along.
        gate.leave(&first);
        assert_eq!(gate.occupancy().taken, 2);
        call(&second);
        let fourth = admit(&gate);
        assert!(is_evicted(&third) && !is_evicted(&second), "a connection that has made a call stays");
        call(&fourth);
    }

    #[test]
    fn strangers_give_their_places_to_others_once_nobody_is_silent() {
        let gate = gate(3);
        let [first, second, third] = [(); 3].map(|()| admit(&gate));
        call(&first);
        second.note_call().unwrap();
        let fourth = admit(&gate);
        assert!(is_evicted(&third), "it has not even called");
        call(&fourth);
        let fifth = admit(&gate);
        assert!(is_evicted(&second), "none of its calls was more than anybody may");
        call(&fifth);
        assert!([&first, &fourth, &fifth].iter().all(|known| !is_evicted(known)));
        assert!(admit(&gate).note_call().is_err(), "all are known");
        for one in [&first, &second, &third, &fourth, &fifth] {
            gate.leave(one);
        }
        let occupancy = gate.occupancy();
        assert_eq!((occupancy.taken, occupancy.strangers.len()), (0, 0));
    }

    #[test]
    fn where_all_places_are_in_use_a_new_connection_is_refused_until_one_leaves() {
        let gate = gate(2);
        let both = [admit(&gate), admit(&gate)];
        both.iter().for_each(|one| call(one));
        let late = admit(&gate);
        let refused = late.note_call().unwrap_err().to_string();
        assert!(refused.starts_with("the server has 2 connections, which is its limit; "), "{refused}");
        gate.leave(&both[0]);
        assert!(late.note_call().is_err(), "a refused connection stays refused");
        gate.leave(&late);
        call(&admit(&gate));
        assert_eq!(gate.occupancy().taken, 2);
    }

    #[test]
    fn a_connection_that_abandons_its_calls_is_closed_and_one_that_is_answered_now_and_then_stays() {
        let gate = gate(2);
        let [hostile, hasty] = [(); 2].map(|()| gate.admit(None, &Account::Process));
        for _ in 0..MOST_ABANDONED {
            hostile.note_abandoned();
            hasty.note_abandoned();
        }
        assert!(!is_evicted(&hostile));
        hasty.note_answered();
        for one in [&hostile, &hasty] {
            one.note_abandoned();
        }
        assert!(is_evicted(&hostile) && !is_evicted(&hasty));
    }

    #[test]
    fn an_address_that_has_its_places_gets_no_more_and_others_do() {
        let gate = gate(8);
        let from = |last: u8| gate.admit(None, &Account::of_address([10, 0, 0, last].into()));
        let four = [(); 4].map(|()| from(1));
        let fifth = from(1);
        let refused = fifth.note_call().unwrap_err().to_string();
        assert_eq!(
            refused,
            "the address 10.0.0.1 has 4 connections, which is its limit; close one, or start the server with a larger \
             --max-connections-per-address"
        );
        assert!(!is_evicted(&four[0]), "nobody has to make room for it");
        from(2).note_call().unwrap();
        gate.leave(&four[0]);
        let [first, ..] = four;
        drop(first);
        gate.leave(&fifth);
        from(1).note_call().unwrap();
    }

    #[test]
    fn connections_without_a_place_are_few() {
        let gate = gate(1);
        call(&admit(&gate));
        let away: Vec<_> = (0..=max_refused(1)).map(|_| admit(&gate)).collect();
        assert!(is_evicted(&away[0]) && !away[1..].iter().any(|one| is_evicted(one)));
        away.iter().for_each(|one| gate.leave(one));
        let occupancy = gate.occupancy();
        assert_eq!((occupancy.taken, occupancy.refused.len()), (1, 0));
    }
}
