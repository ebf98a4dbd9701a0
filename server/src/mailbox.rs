//! A mailbox: a queue of messages and the runner that handles them, on a thread of a [pool](crate::pool) or inline, on
//! the thread of the sender of a message.
//!
//! # Why callers run the world inline
//!
//! Waking a thread takes tens of microseconds, while a tick of a small world takes less than ten. In lockstep, where every
//! tick waits for a Step from the network, a wake-up for each Step would cost more than the simulation. So the caller that
//! posts a message also handles it, there and then, if no other thread is running the world and the work is short; the pool
//! sleeps on. For the same reason an operator who asks how a world stands waits for no other world, however many there are.
//!
//! # Why nothing is left lying
//!
//! No sender waits for the runner: a caller takes the lock if it is free, and otherwise leaves its message in the
//! queue; a thread of the pool leaves a note that it was there. Message and note are seen by the holder of the lock,
//! because every holder looks for them once more *after* it has released the lock. Either that look finds them, or they
//! were left after it, and then the lock was free for the one that left them. For this to hold, they must be there
//! before the lock is tried.
//!
//! # Panics
//!
//! A runner that panics poisons its lock. A thread of the pool finds that at once, if it is the one, or when the caller wakes
//! it, and closes the mailbox, which drops all messages: clients that wait for an answer learn that there will be none.

use std::collections::VecDeque;
use std::mem;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread;

use crate::clock;
use crate::pool::{Place, SLICE, Task, Then, Waker};

/// The handler of a mailbox's messages. Only one of its methods runs at a time, on whichever thread.
pub(crate) trait Runner<M>: Send {
    /// Does one thing, if this is the place for it. `take` gives the next message.
    fn run(&mut self, place: Place, take: &mut dyn FnMut() -> Option<M>) -> Then;

    /// Does what does not take long, on a caller's thread. `take` gives the next message. An instant that is waited for is new
    /// to the pool.
    fn run_inline(&mut self, take: &mut dyn FnMut() -> Option<M>) -> Then;

    /// The mailbox is closed: the runner is over, or one of its methods has panicked.
    fn close(&mut self);
}

/// Steps of a slice, at most: more than fit into it, unless the clock stands.
const MOST_STEPS: usize = 1000;

/// A queue of messages with their runner.
pub(crate) struct Mailbox<M> {
    queue: Mutex<Queue<M>>,
    /// `None` once the mailbox is closed.
    runner: Mutex<Kept<M>>,
    waker: Waker,
}

/// The runner, as long as there is one.
type Kept<M> = Option<Box<dyn Runner<M>>>;

/// Messages that have not been handled, oldest first.
struct Queue<M> {
    messages: VecDeque<M>,
    /// A thread of the pool came while another one ran the runner.
    is_due: bool,
    is_closed: bool,
}

impl<M> Mailbox<M> {
    pub(crate) fn new(runner: impl Runner<M> + 'static, waker: Waker) -> Self {
        let queue = Queue { messages: VecDeque::new(), is_due: false, is_closed: false };
        let runner: Box<dyn Runner<M>> = Box::new(runner);
        Self { queue: Mutex::new(queue), runner: Mutex::new(Some(runner)), waker }
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

    /// Whether it takes no messages any more.
    pub(crate) fn is_closed(&self) -> bool {
        self.queue().is_closed
    }

    fn run_inline(&self) {
        loop {
            // Dropped after the lock, so that the pool finds it poisoned.
            let _wake_on_panic = WakeOnPanic(&self.waker);
            let Ok(mut guard) = self.runner.try_lock() else { return };
            let Some(runner) = guard.as_mut() else { return };
            let then = runner.run_inline(&mut || self.take());
            drop(guard);
            match then {
                Then::Run(by) => return self.waker.wake(by),
                Then::RunLong | Then::RunApart | Then::Over => return self.waker.wake(None),
                Then::Wait(Some(until)) => self.waker.wake(Some(until)),
                Then::Wait(None) => {}
            }
            // Something may have come between the last `take` and the end of the lock.
            let mut queue = self.queue();
            let is_due = mem::take(&mut queue.is_due);
            let is_empty = queue.messages.is_empty();
            drop(queue);
            if is_due {
                return self.waker.wake(Some(clock::now()));
            }
            if is_empty {
                return;
            }
        }
    }

    /// Runs the runner for a slice, on a thread of the pool.
    fn run_slice(&self, place: Place) -> Then {
        let end = clock::now() + SLICE;
        let mut guard = match self.lock_or_leave_note() {
            Ok(guard) => guard,
            Err(then) => return then,
        };
        let Some(runner) = guard.as_mut() else { return Then::Over };
        let mut steps = 0;
        let then = loop {
            let then = runner.run(place, &mut || self.take());
            steps += 1;
            if !matches!(then, Then::Run(_)) || steps == MOST_STEPS || clock::now() >= end {
                break then;
            }
        };
        drop(guard);
        let mut queue = self.queue();
        if mem::take(&mut queue.is_due) || !queue.messages.is_empty() {
            drop(queue);
            self.waker.wake(None);
        }
        then
    }

    /// The runner. Otherwise another thread runs it, which then sees that this one was here, or it has panicked.
    fn lock_or_leave_note(&self) -> Result<MutexGuard<'_, Kept<M>>, Then> {
        for _ in 0..2 {
            match self.runner.try_lock() {
                Ok(guard) => return Ok(guard),
                Err(TryLockError::Poisoned(_)) => return Err(Then::Over),
                Err(TryLockError::WouldBlock) => self.queue().is_due = true,
            }
        }
        Err(Then::Wait(None))
    }

    fn take(&self) -> Option<M> {
        self.queue().messages.pop_front()
    }

    fn queue(&self) -> MutexGuard<'_, Queue<M>> {
        // The queue is consistent between any two of its changes, so a panic elsewhere does not spoil it.
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn close(&self) {
        let left = {
            let mut queue = self.queue();
            queue.is_closed = true;
            mem::take(&mut queue.messages)
        };
        // Not under the lock: messages may hold leases, which post a message when they are dropped.
        drop(left);
        let runner = self.runner.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(mut runner) = runner {
            runner.close();
        }
    }
}

impl<M: Send + 'static> Task for Mailbox<M> {
    fn run(&self, place: Place) -> Then {
        // A panic ends this world only. Its text is on stderr already.
        match catch_unwind(AssertUnwindSafe(|| self.run_slice(place))) {
            Ok(Then::Over) | Err(_) => {
                self.close();
                Then::Over
            }
            Ok(then) => then,
        }
    }
}

/// Wakes the pool if a caller panics: it finds the poisoned lock, and closes the mailbox.
struct WakeOnPanic<'a>(&'a Waker);

impl Drop for WakeOnPanic<'_> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.0.wake(None);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::pool::Pool;

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
        fn run(&mut self, place: Place, take: &mut dyn FnMut() -> Option<i64>) -> Then {
            if let Some(number) = self.on_thread.take() {
                assert_eq!((place, thread::current().name()), (Place::Shared, Some("adder 0")));
                assert!(number < 1_000_000, "such a number makes it panic");
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
                assert!(number < 2_000_000, "such a number makes it panic at once");
                if number > 100 {
                    self.on_thread = Some(number);
                } else {
                    self.add(number);
                }
            }
            if self.is_over || self.on_thread.is_some() { Then::Run(None) } else { Then::Wait(None) }
        }

        fn close(&mut self) {
            self.sum.fetch_add(1_000_000, Ordering::SeqCst);
        }
    }

    /// A mailbox that adds up, with its pool and the sum.
    fn adder() -> (Pool, Arc<Mailbox<i64>>, Arc<AtomicUsize>) {
        let sum = Arc::new(AtomicUsize::new(0));
        let adder = Adder { sum: Arc::clone(&sum), on_thread: None, is_over: false };
        let mut pool = Pool::new("adder");
        let mailbox = pool.add(|waker| Arc::new(Mailbox::new(adder, waker))).unwrap();
        (pool, mailbox, sum)
    }

    #[test]
    fn no_message_is_lost_whoever_handles_it() {
        let (pool, mailbox, sum) = adder();
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
        pool.join();
        assert_eq!(sum.load(Ordering::SeqCst), 1_000_000 + 4 * (990 + 10 * 101));
        assert!(!mailbox.post(1), "it is closed");
    }

    #[test]
    fn a_runner_that_panics_is_closed_by_the_pool_on_whichever_thread_it_was() {
        for number in [1_000_000, 2_000_000] {
            let (pool, mailbox, sum) = adder();
            let caller = Arc::clone(&mailbox);
            // A caller that panics with the runner, or finds its mailbox closed.
            let _ = thread::spawn(move || while caller.post(number) {}).join();
            pool.join();
            assert_eq!(sum.load(Ordering::SeqCst), 1_000_000, "it was closed once");
            assert!(!mailbox.post(1));
        }
    }
}
