//! When a runtime with one thread has nothing to do.
//!
//! Its thread parks when no task is ready. The runtime tells [`Parked`] of that before, which wakes the future that asks, so that the
//! thread does not sleep. Timers that are due are looked at after that; so it is idle once it has parked twice with no task between.

use std::future::poll_fn;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Poll, Waker};
use std::time::Duration;

use tokio::time::timeout;

/// Counts how often the thread was about to park. Clones share the count.
#[derive(Clone, Default)]
pub(crate) struct Parked(Arc<Mutex<State>>);

#[derive(Default)]
struct State {
    times: u32,
    asks: Option<Waker>,
}

impl Parked {
    /// The thread is about to park.
    pub(crate) fn note(&self) {
        let mut state = self.lock();
        state.times += 1;
        if let Some(asks) = &state.asks {
            asks.wake_by_ref();
        }
    }

    /// Lets the runtime work until it is idle, or for so long. Gives whether it is idle.
    pub(crate) async fn work(&self, at_most: Duration) -> bool {
        self.lock().times = 0;
        let idle = poll_fn(|context| {
            let mut state = self.lock();
            if state.times >= 2 {
                return Poll::Ready(());
            }
            state.asks = Some(context.waker().clone());
            Poll::Pending
        });
        timeout(at_most, idle).await.is_ok()
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use tokio::runtime::{Builder, Runtime};
    use tokio::time::sleep;

    use super::*;

    fn runtime() -> (Runtime, Parked) {
        let parked = Parked::default();
        let noted = parked.clone();
        let runtime =
            Builder::new_current_thread().enable_time().on_thread_park(move || noted.note()).build();
        (runtime.unwrap(), parked)
    }

    #[test]
    fn a_runtime_without_tasks_or_with_timers_only_is_idle_at_once() {
        let (runtime, parked) = runtime();
        runtime.spawn(async { sleep(Duration::from_secs(3600)).await });
        let begun = Instant::now();
        assert!((0..10).all(|_| runtime.block_on(parked.work(Duration::from_secs(60)))));
        assert!(begun.elapsed() < Duration::from_secs(10), "{:?}", begun.elapsed());
    }

    #[test]
    fn a_task_that_always_has_more_to_do_ends_the_turn_by_time() {
        let (runtime, parked) = runtime();
        runtime.spawn(async {
            loop {
                tokio::task::yield_now().await;
            }
        });
        assert!(!runtime.block_on(parked.work(Duration::from_millis(20))));
    }

    #[test]
    fn a_timer_that_is_due_is_no_rest() {
        let (runtime, parked) = runtime();
        let timed = runtime.spawn(async { sleep(Duration::from_millis(5)).await });
        runtime.block_on(parked.work(Duration::from_secs(60)));
        std::thread::sleep(Duration::from_millis(20));
        assert!(runtime.block_on(parked.work(Duration::from_secs(60))));
        assert!(timed.is_finished(), "its task has run before the runtime was idle");
    }
}
