//! The runner of a server's worlds: a pool of [`Threads`], or [`Tasks`] of the caller's runtime.

mod queue;
mod tasks;
mod threads;

use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

use tasks::{TaskWaker, Tasks};
use threads::{ThreadWaker, Threads};

/// The time for which a task runs before others have their turn.
pub(crate) const SLICE: Duration = Duration::from_micros(500);

/// A task of a pool. It runs on one thread at a time.
pub(crate) trait Task: Send + Sync {
    /// Runs for a slice.
    fn run(&self, place: Place) -> Then;
}

/// The thread on which a task runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// One that other tasks wait for.
    Shared,
    /// One for steps that take long.
    Long,
    /// The task's own: it may block.
    Own,
}

/// The decision about a task that has run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Then {
    /// The task has more to do; if it follows the clock, by this instant.
    Run(Option<Instant>),
    /// The task has more to do, which takes long.
    RunLong,
    /// The task has more to do, which may block.
    RunApart,
    /// The task waits until it is woken, or for this instant.
    Wait(Option<Instant>),
    /// The task is over.
    Over,
}

/// The runner of tasks. Dropping it lets them go on until they are over.
pub(crate) enum Pool {
    Threads(Threads),
    Tasks(Tasks),
}

/// The alarm of a pool's task.
#[derive(Clone)]
pub(crate) enum Waker {
    Thread(ThreadWaker),
    Task(TaskWaker),
}

impl Pool {
    /// A thread for each processor, named so with a number.
    pub(crate) fn new(name: &str) -> Self {
        Self::Threads(Threads::new(name))
    }

    /// A thread of this name for one task, which may block.
    pub(crate) fn of_one(name: &str) -> Self {
        Self::Threads(Threads::of_one(name))
    }

    /// No threads: tasks of the runtime that is there when they are added.
    pub(crate) fn without_threads() -> Self {
        Self::Tasks(Tasks::default())
    }

    /// Adds a task, which is made with what wakes it.
    ///
    /// # Errors
    /// If the pool needs a thread, or a runtime, and there is none.
    pub(crate) fn add<T: Task + 'static>(
        &mut self,
        make: impl FnOnce(Waker) -> Arc<T>,
    ) -> std::io::Result<Arc<T>> {
        match self {
            Self::Threads(threads) => threads.add(make),
            Self::Tasks(tasks) => tasks.add(make),
        }
    }

    /// Waits until all tasks are over. It blocks, so it is not for a thread that runs some of them.
    pub(crate) fn join(self) {
        match self {
            Self::Threads(threads) => threads.join(),
            Self::Tasks(tasks) => tasks.join(),
        }
    }
}

impl fmt::Debug for Waker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Waker")
    }
}

impl Waker {
    /// The task has something to do; if it follows the clock, by this instant.
    pub(crate) fn wake(&self, by: Option<Instant>) {
        match self {
            Self::Thread(thread) => thread.wake(by),
            Self::Task(task) => task.wake(by),
        }
    }
}
