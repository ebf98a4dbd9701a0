//! A mailbox: a queue of messages and the runner that handles them, on the runner's own thread or inline, on the thread of
//! whoever posts a message.
//!
//! # Why callers run the world inline
//!
//! A world has a thread of its own. Waking it takes tens of microseconds, while a tick of a small world takes less than ten.
//! In lockstep, where every tick waits for a Step from the network, a wake-up for each Step would cost more than the
//! simulation. So the caller that posts a message also handles it, there and then, if no other thread is running the world
//! and the work is short; the world's thread sleeps on.
//!
//! # Why nothing is left lying
//!
//! A caller never waits for the runner: it takes the lock if it is free, and otherwise leaves its message in the queue. The
//! message is then handled by whoever holds the lock, because every holder looks at the queue once more *after* it has let
//! go of the lock. Either that look finds the message, or the message was posted after it, and then the lock was free for
//! the one that posted it. For this to hold, a message must be in the queue before its caller tries the lock.
//!
//! # Panics
//!
//! A runner that panics poisons its lock. The world's thread finds that when it next wakes, and closes the mailbox, which
//! drops all messages: clients that wait for an answer learn that there will be none.

use std::collections::VecDeque;
use std::mem;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::{self, Thread};
use std::time::Instant;

/// What handles the messages of a mailbox. Only one of its methods runs at a time, on whichever thread.
pub(crate) trait Runner<M>: Send {
    /// Does one thing, of whatever length, on the runner's own thread. `take` gives the next message.
    fn run(&mut self, take: &mut dyn FnMut() -> Option<M>) -> Then;

    /// Does what does not take long, on a caller's thread. `take` gives the next message.
    fn run_inline(&mut self, take: &mut dyn FnMut() -> Option<M>) -> Then;

    /// The mailbox is closed: the runner is over, or one of its methods has panicked.
    fn close(&mut self);
}

/// What is to be done about a runner after one of its methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Then {
    /// There is more to do, and the runner's own thread should do it.
    RunOnThread,
    /// Nothing before the next message, or before this instant.
    Wait(Option<Instant>),
    /// The runner is over.
    Over,
}

/// A queue of messages with their runner.
pub(crate) struct Mailbox<M> {
    queue: Mutex<Queue<M>>,
    /// `None` once the mailbox is closed.
    runner: Mutex<Option<Box<dyn Runner<M>>>>,
    thread: OnceLock<Thread>,
}

/// Messages that have not been handled, oldest first.
struct Queue<M> {
    messages: VecDeque<M>,
    is_closed: bool,
}

impl<M> Mailbox<M> {
    pub(crate) fn new(runner: impl Runner<M> + 'static) -> Self {
        let queue = Queue { messages: VecDeque::new(), is_closed: false };
        let runner: Box<dyn Runner<M>> = Box::new(runner);
        Self { queue: Mutex::new(queue), runner: Mutex::new(Some(runner)), thread: OnceLock::new() }
    }

    /// Posts a message, and handles it here if that does not take long; `false` if the mailbox is closed.
    pub(crate) fn post(&self, message: M) -> bool {
        {
            let mut queue = self.queue();
            if queue.is_closed {
                return false;
            }
            queue.messages.push_back(message);
        }
        self.run_inline();
        true
    }

    fn run_inline(&self) {
        loop {
            let Ok(mut guard) = self.runner.try_lock() else { return };
            let Some(runner) = guard.as_mut() else { return };
            let wake_on_panic = WakeOnPanic(self);
            let then = runner.run_inline(&mut || self.take());
            drop((wake_on_panic, guard));
            if then == Then::RunOnThread {
                return self.wake();
            }
            // A message may have come between the last `take` and the end of the lock.
            if self.queue().messages.is_empty() {
                return;
            }
        }
    }

    /// The runner's own thread: returns when the runner is over.
    pub(crate) fn run(&self) {
        let _ = self.thread.set(thread::current());
        let closing = CloseOnDrop(self);
        while let Ok(mut guard) = self.runner.lock() {
            let Some(runner) = guard.as_mut() else { break };
            match runner.run(&mut || self.take()) {
                Then::RunOnThread => {}
                Then::Over => break,
                Then::Wait(until) => {
                    drop(guard);
                    if self.queue().messages.is_empty() {
                        sleep(until);
                    }
                }
            }
        }
        drop(closing);
    }

    fn take(&self) -> Option<M> {
        self.queue().messages.pop_front()
    }

    fn wake(&self) {
        // A thread that has not begun looks for work when it does.
        if let Some(thread) = self.thread.get() {
            thread.unpark();
        }
    }

    fn queue(&self) -> MutexGuard<'_, Queue<M>> {
        // The queue is consistent between any two of its changes, so a panic elsewhere does not spoil it.
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn sleep(until: Option<Instant>) {
    match until {
        Some(until) => thread::park_timeout(until.saturating_duration_since(Instant::now())),
        None => thread::park(),
    }
}

/// Wakes the runner's thread if a caller panics: the thread finds the poisoned lock, and closes the mailbox.
struct WakeOnPanic<'a, M>(&'a Mailbox<M>);

impl<M> Drop for WakeOnPanic<'_, M> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.0.wake();
        }
    }
}

/// Closes the mailbox when the runner's thread ends, whether it returns or panics.
struct CloseOnDrop<'a, M>(&'a Mailbox<M>);

impl<M> Drop for CloseOnDrop<'_, M> {
    fn drop(&mut self) {
        let left = {
            let mut queue = self.0.queue();
            queue.is_closed = true;
            mem::take(&mut queue.messages)
        };
        // Not under the lock: messages may hold leases, which post a message when they are dropped.
        drop(left);
        let runner = self.0.runner.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(mut runner) = runner {
            runner.close();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// Adds up numbers; -1 is its end, and numbers above 100 are long work.
    struct Adder {
        sum: Arc<AtomicUsize>,
        on_thread: Option<i64>,
        is_over: bool,
    }

    impl Adder {
        fn add(&mut self, number: i64) {
            match usize::try_from(number) {
                Ok(number) => drop(self.sum.fetch_add(number, Ordering::SeqCst)),
                Err(_) => self.is_over = true,
            }
        }
    }

    impl Runner<i64> for Adder {
        fn run(&mut self, take: &mut dyn FnMut() -> Option<i64>) -> Then {
            if let Some(number) = self.on_thread.take() {
                assert_eq!(thread::current().name(), Some("adder"), "long work is for the thread");
                self.add(number);
            }
            while let Some(number) = take() {
                self.add(number);
            }
            if self.is_over { Then::Over } else { Then::Wait(None) }
        }

        fn run_inline(&mut self, take: &mut dyn FnMut() -> Option<i64>) -> Then {
            while self.on_thread.is_none()
                && let Some(number) = take()
            {
                if number > 100 {
                    self.on_thread = Some(number);
                } else {
                    self.add(number);
                }
            }
            if self.is_over || self.on_thread.is_some() { Then::RunOnThread } else { Then::Wait(None) }
        }

        fn close(&mut self) {}
    }

    #[test]
    fn no_message_is_lost_whoever_handles_it() {
        let sum = Arc::new(AtomicUsize::new(0));
        let adder = Adder { sum: Arc::clone(&sum), on_thread: None, is_over: false };
        let mailbox = Arc::new(Mailbox::new(adder));
        let own = Arc::clone(&mailbox);
        let thread = thread::Builder::new().name("adder".into()).spawn(move || own.run()).unwrap();
        let post_all = || {
            for i in 0..1000 {
                assert!(mailbox.post(if i % 100 == 0 { 101 } else { 1 }));
            }
        };
        thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(post_all);
            }
        });
        assert!(mailbox.post(-1));
        thread.join().unwrap();
        assert_eq!(sum.load(Ordering::SeqCst), 4 * (990 + 10 * 101));
        assert!(!mailbox.post(1), "it is closed");
    }
}
