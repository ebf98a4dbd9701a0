//! A world's room: its letters, and the world itself, to which whoever is in the room attends.
//!
//! Each world has a thread, which is at home in the room. But to wake a thread takes longer than a tick of a small
//! world: so whoever brings a letter and finds the room empty opens it there and then, and does the tick that became
//! due by it, if ticks are short. Nobody ever waits for the room: a letter that finds somebody in it is left with the
//! others, and who leaves the room looks for letters once more. So none is left lying.

use std::collections::VecDeque;
use std::mem;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::{self, Thread};
use std::time::Instant;

use crate::host::{Host, Then};
use crate::letter::Letter;

/// A world's room.
pub(crate) struct Room {
    letters: Mutex<Letters>,
    /// `None` once the world is over.
    host: Mutex<Option<Host>>,
    thread: OnceLock<Thread>,
}

/// Letters that nobody has opened, oldest first.
pub(crate) struct Letters {
    queue: VecDeque<Letter>,
    /// Nobody will open any more.
    closed: bool,
}

impl Room {
    pub(crate) fn new(host: Host) -> Self {
        let letters = Letters { queue: VecDeque::new(), closed: false };
        Self { letters: Mutex::new(letters), host: Mutex::new(Some(host)), thread: OnceLock::new() }
    }

    /// Brings a letter; `false` if the world is over.
    pub(crate) fn send(&self, letter: Letter) -> bool {
        {
            let mut letters = self.letters();
            if letters.closed {
                return false;
            }
            letters.queue.push_back(letter);
        }
        self.attend();
        true
    }

    /// Does what is to be done, if nobody else is at it and it does not take long.
    fn attend(&self) {
        loop {
            let Ok(mut guard) = self.host.try_lock() else { return };
            let Some(host) = guard.as_mut() else { return };
            let alarm = Alarm(self);
            let then = host.visit(|| self.take_letter());
            drop((alarm, guard));
            if then == Then::Thread {
                return self.wake();
            }
            if self.letters().queue.is_empty() {
                return;
            }
        }
    }

    /// The life of the world's own thread, until the world is over.
    pub(crate) fn live(&self) {
        let _ = self.thread.set(thread::current());
        let closing = Closing(self);
        while let Ok(mut guard) = self.host.lock() {
            let Some(host) = guard.as_mut() else { break };
            match host.work(|| self.take_letter()) {
                Then::Thread => {}
                Then::Over => break,
                Then::Wait(until) => {
                    drop(guard);
                    if self.letters().queue.is_empty() {
                        sleep(until);
                    }
                }
            }
        }
        drop(closing);
    }

    fn take_letter(&self) -> Option<Letter> {
        self.letters().queue.pop_front()
    }

    fn wake(&self) {
        // A thread that has not begun looks for work when it does.
        if let Some(thread) = self.thread.get() {
            thread.unpark();
        }
    }

    fn letters(&self) -> MutexGuard<'_, Letters> {
        // The queue is sound between any two of its calls, so a panic elsewhere does not spoil it.
        self.letters.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn sleep(until: Option<Instant>) {
    match until {
        Some(until) => thread::park_timeout(until.saturating_duration_since(Instant::now())),
        None => thread::park(),
    }
}

/// Wakes the world's thread if a visitor panics: it finds the world spoilt, and closes the room.
struct Alarm<'a>(&'a Room);

impl Drop for Alarm<'_> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.0.wake();
        }
    }
}

/// Closes the room when the world's thread is over, however that came.
struct Closing<'a>(&'a Room);

impl Drop for Closing<'_> {
    fn drop(&mut self) {
        let left = {
            let mut letters = self.0.letters();
            letters.closed = true;
            mem::take(&mut letters.queue)
        };
        // Who waits for an answer learns that there will be none. Letters hold leases, which write letters.
        drop(left);
        let host = self.0.host.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(mut host) = host {
            host.abandon();
        }
    }
}
