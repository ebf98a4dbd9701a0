//! Worlds as tasks of the caller's runtime, without threads.
//!
//! # Need
//!
//! A test of what a server does over hours, or with thousands of faults of a network, wants a clock that it moves itself, and the
//! same order of events each time. Both exist on one thread only: a runtime of tokio with one thread, whose time is paused.
//!
//! # Mechanism
//!
//! Each world is a task. It runs for a slice, and then lets the others run, until nothing is to be done before it is woken or
//! before an instant. What takes long or blocks is done there and then, and the whole runtime waits for it. All instants are
//! those of the runtime ([`clock`](crate::clock)), so a world that follows the clock follows a paused one, too.

use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use tokio::runtime::Handle;
use tokio::sync::Notify;
use tokio::task::JoinHandle;
use tokio::time::timeout_at;

use super::{Place, Task, Then, Waker};
use crate::clock;

/// Tasks of a runtime. Dropping this lets them go on until they are over.
#[derive(Default)]
pub(crate) struct Tasks(Vec<JoinHandle<()>>);

/// The alarm of a runtime's task.
#[derive(Clone, Default)]
pub(crate) struct TaskWaker(Arc<Alarm>);

/// The instant at which a task is to run.
#[derive(Default)]
struct Alarm {
    state: Mutex<State>,
    changed: Notify,
}

#[derive(Default)]
struct State {
    is_ready: bool,
    /// The earliest instant that it waits for.
    at: Option<Instant>,
}

impl Tasks {
    pub(super) fn add<T: Task + 'static>(
        &mut self,
        make: impl FnOnce(Waker) -> Arc<T>,
    ) -> io::Result<Arc<T>> {
        let runtime = Handle::try_current().map_err(io::Error::other)?;
        let waker = TaskWaker::default();
        let task = make(Waker::Task(waker.clone()));
        self.0.retain(|other| !other.is_finished());
        self.0.push(runtime.spawn(work(Arc::clone(&task), waker.0)));
        Ok(task)
    }

    pub(super) fn join(self) {
        let runtime = Handle::current();
        for task in self.0 {
            // Tasks do not panic.
            let _ = runtime.block_on(task);
        }
    }
}

impl TaskWaker {
    pub(super) fn wake(&self, by: Option<Instant>) {
        self.0.set(by);
        self.0.changed.notify_one();
    }
}

/// Runs a task until it is over.
async fn work<T: Task>(task: Arc<T>, alarm: Arc<Alarm>) {
    let mut place = Place::Shared;
    loop {
        let then = task.run(place);
        place = Place::Shared;
        match then {
            Then::Run(by) => alarm.set(by),
            Then::RunLong => place = Place::Long,
            Then::RunApart => place = Place::Own,
            Then::Wait(None) => {}
            Then::Wait(Some(until)) => alarm.set(Some(until)),
            Then::Over => return,
        }
        if place == Place::Shared {
            alarm.wait().await;
        }
    }
}

impl Alarm {
    fn set(&self, by: Option<Instant>) {
        let mut state = self.state();
        match by {
            None => state.is_ready = true,
            Some(by) => state.at = Some(state.at.map_or(by, |at| at.min(by))),
        }
    }

    /// Waits until the task is to run. Others run at least once before that.
    async fn wait(&self) {
        tokio::task::yield_now().await;
        loop {
            let at = {
                let mut state = self.state();
                if state.is_ready || state.at.is_some_and(|at| at <= clock::now()) {
                    *state = State::default();
                    return;
                }
                state.at
            };
            match at {
                None => self.changed.notified().await,
                Some(at) => drop(timeout_at(at.into(), self.changed.notified()).await),
            }
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // The state is consistent between any two of its changes.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
