//! The watch over wall time: a thread that stops a task which computes, or is in a call, for longer than the session has patience. It
//! changes nothing in a program that goes on: it only ends one that does not.

use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::os::{memory, proc, trace};
use crate::program::Patience;
use crate::task::Task;

/// The time between two looks.
const PERIOD: Duration = Duration::from_millis(100);

/// The thread.
#[derive(Debug)]
pub(crate) struct Watch {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// The reason why a task was stopped.
#[derive(Debug, Clone)]
pub(crate) enum Trip {
    /// It has computed so long.
    Computing(Duration),
    /// It has been in this call so long.
    Call(String, Duration),
}

#[derive(Debug, Default)]
struct Shared {
    process: AtomicI32,
    /// The task that is waited for; 0: none.
    tid: AtomicI32,
    /// The address at which it counts its looks at clocks; 0: nowhere.
    page: AtomicU64,
    /// A number for each wait.
    round: AtomicU64,
    is_over: AtomicBool,
    trip: Mutex<Option<Trip>>,
}

impl Watch {
    pub(crate) fn new(patience: Patience) -> Self {
        let shared = Arc::new(Shared::default());
        let theirs = Arc::clone(&shared);
        Self { shared, thread: Some(thread::spawn(move || watch(&theirs, patience))) }
    }

    /// From now on, this task is waited for.
    pub(crate) fn begin(&self, task: &Task) {
        self.shared.process.store(task.process, Ordering::Relaxed);
        self.shared.page.store(task.page.unwrap_or(0), Ordering::Relaxed);
        self.shared.round.fetch_add(1, Ordering::Relaxed);
        self.shared.tid.store(task.tid, Ordering::Release);
    }

    /// It has stopped.
    pub(crate) fn end(&self) {
        self.shared.tid.store(0, Ordering::Release);
    }

    /// The reason why it was stopped, if it was the watch.
    pub(crate) fn trip(&self) -> Option<Trip> {
        self.shared.trip.lock().ok()?.clone()
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.shared.is_over.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            let _ = thread.join();
        }
    }
}

fn watch(shared: &Shared, patience: Patience) {
    let mut seen = ((0, [0; 8]), Instant::now(), 0);
    while !shared.is_over.load(Ordering::Acquire) {
        thread::park_timeout(PERIOD);
        let tid = shared.tid.load(Ordering::Acquire);
        // A look at a clock is a call, too.
        let mut looks = [0; 8];
        let _ = memory::read(tid, shared.page.load(Ordering::Relaxed), &mut looks);
        let round = (shared.round.load(Ordering::Relaxed), looks);
        let Some((state, computed_ns)) = (tid != 0).then(|| proc::activity(tid)).flatten() else { continue };
        if seen.0 != round {
            seen = (round, Instant::now(), computed_ns);
            continue;
        }
        let computing = Duration::from_nanos(computed_ns - seen.2);
        let wall = seen.1.elapsed();
        let trip = if computing >= patience.computing {
            Trip::Computing(computing)
        } else if wall >= patience.call && (state == 'S' || state == 'D') {
            let call = proc::call(tid).map_or("a system call", crate::names::call);
            Trip::Call(call.to_owned(), wall)
        } else {
            continue;
        };
        if let Ok(mut told) = shared.trip.lock() {
            *told = Some(trip);
        }
        trace::signal(shared.process.load(Ordering::Relaxed), tid, libc::SIGSTOP);
        // One stop is enough: the session ends by it.
        return;
    }
}
