//! Who comes in: the connections of all listeners are counted, and nobody holds a place for nothing.
//!
//! A connection takes a place, as long as there are any. It must ask for something soon: whoever has not is closed after a
//! while, or at once if all places are taken and another connection comes. If all who have a place have asked for
//! something, the next connection is let in only to be told that there is no room.
//!
//! [`Gate`] counts, [`Guest`] is a connection as it is read and written, [`Entry`] a listener.

mod entry;
mod guest;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use futures_util::task::AtomicWaker;
use tonic::{Request, Status};

pub(crate) use entry::{Entry, Visitor, guests};
pub(crate) use guest::Guest;

use crate::seldom::Seldom;

/// Counts the connections of a server. Clones share the count.
#[derive(Clone)]
pub(crate) struct Gate(Arc<Shared>);

struct Shared {
    /// Most connections at a time.
    places: usize,
    /// How long a connection has to ask for something.
    patience: Duration,
    crowd: Mutex<Crowd>,
    refused: Seldom,
    trouble: Seldom,
}

/// Who is there, by number: the oldest come first.
#[derive(Default)]
struct Crowd {
    taken: usize,
    last_number: u64,
    /// Those with a place that have not asked for anything.
    silent: BTreeMap<u64, Arc<Visit>>,
    /// Those without a place.
    turned_away: BTreeMap<u64, Arc<Visit>>,
}

/// A connection, as those know it who do not read or write it.
pub(crate) struct Visit {
    gate: Gate,
    number: u64,
    /// Changes only while the crowd is locked.
    has_place: AtomicBool,
    /// It has asked for something, and stays.
    is_known: AtomicBool,
    /// Another connection needs its place.
    is_over: AtomicBool,
    /// Of the task that reads the connection.
    reader: AtomicWaker,
}

impl Gate {
    /// A gate with so many places; connections have so long to ask for something.
    pub(crate) fn new(places: usize, patience: Duration) -> Self {
        let (refused, trouble) = (Seldom::default(), Seldom::default());
        Self(Arc::new(Shared { places, patience, crowd: Mutex::default(), refused, trouble }))
    }

    /// How long a connection has to ask for something.
    pub(crate) fn patience(&self) -> Duration {
        self.0.patience
    }

    /// A connection has come.
    fn admit(&self) -> Arc<Visit> {
        let mut crowd = self.crowd();
        let has_place = crowd.find_place(self.0.places);
        crowd.last_number += 1;
        let number = crowd.last_number;
        let visit = Arc::new(Visit {
            gate: self.clone(),
            number,
            has_place: has_place.into(),
            is_known: false.into(),
            is_over: false.into(),
            reader: AtomicWaker::new(),
        });
        let queue = if has_place { &mut crowd.silent } else { &mut crowd.turned_away };
        queue.insert(number, Arc::clone(&visit));
        if crowd.turned_away.len() > most_turned_away(self.0.places)
            && let Some((_, oldest)) = crowd.turned_away.pop_first()
        {
            oldest.end();
        }
        drop(crowd);
        if !has_place && let Some(times) = self.0.refused.note(Instant::now()) {
            tracing::warn!(times, places = self.0.places, "connections refused, as all places are taken");
        }
        visit
    }

    /// A connection is gone.
    fn leave(&self, visit: &Visit) {
        let mut crowd = self.crowd();
        crowd.silent.remove(&visit.number);
        crowd.turned_away.remove(&visit.number);
        crowd.taken -= usize::from(visit.has_place.load(Ordering::Relaxed));
    }

    fn crowd(&self) -> MutexGuard<'_, Crowd> {
        // The crowd is sound between any two of its calls.
        self.0.crowd.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Crowd {
    /// Takes a place that is free, or that of whoever has been silent for longest.
    fn find_place(&mut self, places: usize) -> bool {
        if self.taken < places {
            self.taken += 1;
            return true;
        }
        let Some((_, oldest)) = self.silent.pop_first() else { return false };
        oldest.has_place.store(false, Ordering::Relaxed);
        oldest.end();
        true
    }
}

impl Visit {
    /// It asks for something: then it stays, or is told why it cannot.
    pub(crate) fn ask(&self) -> Result<(), String> {
        if self.is_known.load(Ordering::Relaxed) {
            return Ok(());
        }
        let mut crowd = self.gate.crowd();
        if crowd.silent.remove(&self.number).is_some() {
            self.is_known.store(true, Ordering::Relaxed);
            return Ok(());
        }
        let places = self.gate.0.places;
        Err(format!(
            "the server has {places} connections, which is its limit; close one, or start it with a larger --max-connections"
        ))
    }

    /// How long it has to ask for something, or to be told that it cannot.
    fn patience(&self) -> Duration {
        let has_place = self.has_place.load(Ordering::Relaxed);
        if has_place { self.gate.0.patience } else { self.gate.0.patience.min(FAREWELL) }
    }

    fn end(&self) {
        self.is_over.store(true, Ordering::Relaxed);
        self.reader.wake();
    }
}

/// Lets a call pass, or says that there is no room. Calls through pipes in memory need no place.
pub(crate) fn check_call(request: Request<()>) -> Result<Request<()>, Status> {
    match request.extensions().get::<Arc<Visit>>() {
        Some(visit) => visit.ask().map(|()| request).map_err(Status::unavailable),
        None => Ok(request),
    }
}

/// How long a connection without a place has to ask, and to take the answer.
const FAREWELL: Duration = Duration::from_secs(2);

/// Connections without a place at a time: each is there only until it has been told so. Few where there are few descriptors,
/// for these are what was left for files.
fn most_turned_away(places: usize) -> usize {
    (places / 8).clamp(8, 64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_over(visit: &Visit) -> bool {
        visit.is_over.load(Ordering::Relaxed)
    }

    #[test]
    fn who_has_been_silent_for_longest_gives_its_place_to_a_newcomer() {
        let gate = Gate::new(2, Duration::from_secs(10));
        let [first, second, third] = [(); 3].map(|()| gate.admit());
        assert_eq!([&first, &second, &third].map(|visit| is_over(visit)), [true, false, false]);
        assert!(first.ask().is_err(), "its place is gone");
        // It leaves late, and takes no place along.
        gate.leave(&first);
        assert_eq!(gate.crowd().taken, 2);
        second.ask().unwrap();
        let fourth = gate.admit();
        assert!(is_over(&third) && !is_over(&second), "who has asked for something stays");
        fourth.ask().unwrap();
    }

    #[test]
    fn where_all_have_asked_the_next_is_told_that_there_is_no_room_until_one_leaves() {
        let gate = Gate::new(2, Duration::from_secs(10));
        let both = [gate.admit(), gate.admit()];
        both.iter().for_each(|visit| visit.ask().unwrap());
        let late = gate.admit();
        let refused = late.ask().unwrap_err();
        assert!(refused.starts_with("the server has 2 connections, which is its limit; "), "{refused}");
        gate.leave(&both[0]);
        assert!(late.ask().is_err(), "that stays so for who was refused");
        gate.leave(&late);
        gate.admit().ask().unwrap();
        assert_eq!(gate.crowd().taken, 2);
    }

    #[test]
    fn those_without_a_place_are_few() {
        let gate = Gate::new(1, Duration::from_secs(10));
        gate.admit().ask().unwrap();
        let away: Vec<_> = (0..=most_turned_away(1)).map(|_| gate.admit()).collect();
        assert!(is_over(&away[0]) && !away[1..].iter().any(|visit| is_over(visit)));
        away.iter().for_each(|visit| gate.leave(visit));
        let crowd = gate.crowd();
        assert_eq!((crowd.taken, crowd.turned_away.len()), (1, 0));
    }
}
