//! A pool of threads that run the worlds of a server.
//!
//! # Which task comes first
//!
//! There is a thread for each processor, and no more than there are tasks. A thread takes the task whose deadline is the
//! earliest among those that follow the clock and are due; after those what a message has woken; after those what has had a
//! slice already and has more to do, as a world in free pace always has ([`queue`](super::queue)). No task is interrupted, so it
//! returns after a slice, or after one step if that takes longer.
//!
//! # What takes long, and what blocks
//!
//! A task whose step takes long ([`Then::RunLong`]) goes to other threads, as many again, with which these threads share the
//! processors by the means of the operating system: meanwhile other tasks keep their deadlines. A task that waits for a disk
//! ([`Then::RunApart`]) gets a thread of its own until it has done so, as that may take for ever. Threads
//! [for one task](Threads::of_one) are one on which anything may be done; worlds with an `OnTick` have such a one.
//!
//! # Time
//!
//! Of the threads that have nothing to do, one sleeps until the next task is due, and a second [a little longer](GRACE): it
//! takes over if the first has found other work. Any others sleep until they are woken. So a tick in real time wakes one
//! thread.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::queue::{Number, Picked, Queue};
use super::{Place, Task, Then, Waker};

/// The lateness of a task at which a second thread looks for it.
const GRACE: Duration = Duration::from_micros(500);

/// The threads. Dropping them lets them end when all tasks are over.
pub(crate) struct Threads {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
    name: String,
    limit: usize,
}

/// The alarm of a task that threads run.
#[derive(Clone)]
pub(crate) struct ThreadWaker {
    shared: Arc<Shared>,
    number: Number,
}

struct Shared {
    state: Mutex<State>,
    work: Condvar,
    /// The thread on which tasks run.
    place: Place,
    /// Threads for steps that take long, at most.
    long_threads: usize,
}

struct State {
    queue: Queue,
    /// The instant at which each sleeping thread wakes by itself.
    sleepers: Vec<Option<Instant>>,
    long_threads: usize,
    /// No task will be added.
    is_closed: bool,
}

impl Threads {
    /// A thread for each processor, named so with a number.
    pub(super) fn new(name: &str) -> Self {
        let processors = thread::available_parallelism().map_or(1, usize::from);
        Self::with(name, processors, Place::Shared)
    }

    /// A thread of this name for one task, which may block.
    pub(super) fn of_one(name: &str) -> Self {
        Self::with(name, 1, Place::Own)
    }

    fn with(name: &str, limit: usize, place: Place) -> Self {
        let state = State { queue: Queue::new(), sleepers: Vec::new(), long_threads: 0, is_closed: false };
        let shared = Shared { state: Mutex::new(state), work: Condvar::new(), place, long_threads: limit };
        Self { shared: Arc::new(shared), threads: Vec::new(), name: name.to_owned(), limit }
    }

    /// Adds a task, which is made with what wakes it.
    ///
    /// # Errors
    /// If the pool needs a thread and there is none.
    pub(super) fn add<T: Task + 'static>(
        &mut self,
        make: impl FnOnce(Waker) -> Arc<T>,
    ) -> std::io::Result<Arc<T>> {
        if self.threads.len() < self.limit.min(self.shared.lock().queue.len() + 1) {
            self.start_thread()?;
        }
        let shared = Arc::clone(&self.shared);
        let mut made = None;
        let mut state = self.shared.lock();
        state.queue.add(Instant::now(), |number| {
            let task = make(Waker::Thread(ThreadWaker { shared, number }));
            made = Some(Arc::clone(&task));
            task
        });
        drop(state);
        self.shared.work.notify_one();
        Ok(made.expect("the queue makes the task"))
    }

    fn start_thread(&mut self) -> std::io::Result<()> {
        let name = match self.shared.place {
            Place::Own => self.name.clone(),
            Place::Shared | Place::Long => format!("{} {}", self.name, self.threads.len()),
        };
        let shared = Arc::clone(&self.shared);
        self.threads.push(thread::Builder::new().name(name).spawn(move || shared.work())?);
        Ok(())
    }

    /// Waits until all tasks are over.
    pub(super) fn join(mut self) {
        let threads = std::mem::take(&mut self.threads);
        drop(self);
        for thread in threads {
            // Tasks do not panic.
            let _ = thread.join();
        }
    }
}

impl Drop for Threads {
    fn drop(&mut self) {
        self.shared.lock().is_closed = true;
        self.shared.work.notify_all();
    }
}

impl ThreadWaker {
    /// The task has something to do; if it follows the clock, by this instant.
    pub(super) fn wake(&self, by: Option<Instant>) {
        let now = Instant::now();
        let mut state = self.shared.lock();
        state.queue.wake(self.number, by, now);
        let wakes = match by {
            Some(by) if by > now => !state.is_watched(by),
            Some(_) | None => true,
        };
        let wakes = wakes && !state.sleepers.is_empty();
        drop(state);
        if wakes {
            self.shared.work.notify_one();
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        // No task runs under this lock, and nothing panics.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A thread of the pool.
    fn work(self: &Arc<Self>) {
        let mut state = self.lock();
        loop {
            let now = Instant::now();
            if let Some((number, task)) = state.queue.pick(now) {
                if state.needs_another(now) {
                    self.work.notify_one();
                }
                drop(state);
                let then = task.run(self.place);
                drop(task);
                self.settle(number, then);
                state = self.lock();
            } else if state.is_over() {
                return;
            } else {
                state = self.sleep(state);
            }
        }
    }

    /// Sleeps until something may be due.
    fn sleep<'a>(&self, mut state: MutexGuard<'a, State>) -> MutexGuard<'a, State> {
        let until = state.time_of_sleep();
        state.sleepers.push(until);
        let mut state = match until {
            None => self.work.wait(state).unwrap_or_else(PoisonError::into_inner),
            Some(until) => {
                let time = until.saturating_duration_since(Instant::now());
                self.work.wait_timeout(state, time).unwrap_or_else(PoisonError::into_inner).0
            }
        };
        // Any of the sleepers with the same instant may be removed.
        if let Some(place) = state.sleepers.iter().position(|&other| other == until) {
            state.sleepers.swap_remove(place);
        }
        state
    }

    /// Notes what a task that has run is to do.
    fn settle(self: &Arc<Self>, number: Number, then: Then) {
        let mut state = self.lock();
        let apart = state.queue.settle(number, then, Instant::now());
        let needs_thread = state.queue.is_any_long() && state.long_threads < self.long_threads;
        state.long_threads += usize::from(needs_thread);
        let is_over = state.is_over();
        drop(state);
        if is_over {
            self.work.notify_all();
        }
        if let Some(picked) = apart {
            self.start("world apart", move |shared| shared.run_apart(&picked));
        }
        if needs_thread {
            self.start("long ticks", |shared| shared.run_long());
        }
    }

    /// Does some work on another thread; here, if there is none.
    fn start(self: &Arc<Self>, name: &str, work: impl FnOnce(&Arc<Self>) + Clone + Send + 'static) {
        let (shared, same) = (Arc::clone(self), work.clone());
        if thread::Builder::new().name(name.to_owned()).spawn(move || same(&shared)).is_err() {
            work(self);
        }
    }

    /// Runs a task that may block.
    fn run_apart(self: &Arc<Self>, (number, task): &Picked) {
        let mut then = Then::RunApart;
        while then == Then::RunApart {
            then = task.run(Place::Own);
        }
        self.settle(*number, then);
        // A thread that sleeps does not know of it.
        self.work.notify_one();
    }

    /// Runs tasks whose steps take long, as long as there are any.
    fn run_long(self: &Arc<Self>) {
        loop {
            let mut state = self.lock();
            let Some((number, task)) = state.queue.pick_long() else {
                state.long_threads -= 1;
                return;
            };
            drop(state);
            let then = task.run(Place::Long);
            drop(task);
            self.settle(number, then);
            self.work.notify_one();
        }
    }
}

impl State {
    fn is_over(&self) -> bool {
        self.is_closed && self.queue.len() == 0
    }

    /// Whether a thread that sleeps should be woken, as the one that asks is going to run a task: another task waits,
    /// or no thread would look for the next one in time.
    fn needs_another(&self, now: Instant) -> bool {
        if self.sleepers.is_empty() {
            return false;
        }
        let is_unwatched = |next: Instant| !self.is_watched(next.max(now));
        self.queue.is_any_ready() || self.queue.next_alarm().is_some_and(is_unwatched)
    }

    /// Whether a thread that sleeps wakes soon after this instant.
    fn is_watched(&self, at: Instant) -> bool {
        self.sleepers.iter().flatten().any(|&until| until <= at + GRACE)
    }

    /// The instant at which a thread that has nothing to do wakes by itself.
    fn time_of_sleep(&self) -> Option<Instant> {
        let next = self.queue.next_alarm()?;
        let by = |limit| self.sleepers.iter().flatten().filter(|&&until| until <= limit).count();
        match (by(next), by(next + GRACE)) {
            (0, _) => Some(next),
            (_, 1) => Some(next + GRACE),
            (_, _) => None,
        }
    }
}
