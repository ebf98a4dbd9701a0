//! The makers of answers that take a while, such as the status of a large world. Few are made at a time, so that worlds
//! have processors, too, and the process has few threads.

use std::sync::Arc;

use tokio::sync::Semaphore;
use tonic::Status;

use crate::system::blocking;

/// The makers of answers.
pub(crate) struct Making(Arc<Semaphore>);

impl Making {
    /// On a machine with so many processors for what is read.
    pub(super) fn new(processors: usize) -> Self {
        Self(Arc::new(Semaphore::new((processors / 2).clamp(1, MOST))))
    }

    /// Makes an answer, when it is its turn.
    ///
    /// # Errors
    /// If the work panics.
    pub(crate) async fn make<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Status> {
        let turn = Arc::clone(&self.0).acquire_owned().await;
        let work = move || {
            // The turn is kept until the work is done, even if the client has gone.
            let _turn = turn;
            work()
        };
        blocking(work).await
    }
}

/// Answers that are made at a time on a large machine.
const MOST: usize = 8;

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::Duration;

    use super::*;

    #[tokio::test]
    async fn few_answers_are_made_at_a_time_whoever_goes() {
        let making = Arc::new(Making::new(4));
        let (now, most) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicUsize::new(0)));
        let callers: Vec<_> = (0..50)
            .map(|n| {
                let (making, now, most) = (Arc::clone(&making), Arc::clone(&now), Arc::clone(&most));
                let work = move || {
                    most.fetch_max(now.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                    std::thread::sleep(Duration::from_millis(2));
                    now.fetch_sub(1, Ordering::SeqCst);
                };
                let caller = tokio::spawn(async move { making.make(work).await });
                // Some do not wait.
                if n % 3 == 0 {
                    caller.abort();
                }
                caller
            })
            .collect();
        for caller in callers {
            let _ = caller.await;
        }
        assert!(most.load(Ordering::SeqCst) <= 2, "{most:?}");
    }
}
