//! The queue of those who want a scenario, a state or a recording to be read. That takes a processor, and much memory, for as long as
//! it takes: so few are read at a time, some wait, and others are sent away.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::accounts::count_up;

/// The queue.
pub(super) struct Parsing {
    permits: Arc<Semaphore>,
    at_a_time: usize,
    waiting: Arc<AtomicUsize>,
}

/// A flag that the client no longer waits for the result.
#[derive(Clone, Default)]
pub(crate) struct Cancelled(Arc<AtomicBool>);

impl Cancelled {
    /// Whether the client no longer waits.
    pub(crate) fn is_so(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// The flag of a client that has gone.
    #[cfg(test)]
    pub(crate) fn gone() -> Self {
        Self(Arc::new(true.into()))
    }
}

/// Cancels what it is for when it is dropped.
pub(super) struct Waiter(pub(super) Cancelled);

impl Drop for Waiter {
    fn drop(&mut self) {
        self.0.0.store(true, Ordering::Relaxed);
    }
}

/// A place in the queue.
struct Waiting(Arc<AtomicUsize>);

impl Drop for Waiting {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Parsing {
    pub(super) fn new(at_a_time: usize) -> Self {
        let at_a_time = at_a_time.clamp(1, Semaphore::MAX_PERMITS);
        Self { permits: Arc::new(Semaphore::new(at_a_time)), at_a_time, waiting: Arc::default() }
    }

    /// The numbers of those that wait, and of those that are being read.
    pub(super) fn counts(&self) -> (usize, usize) {
        (self.waiting.load(Ordering::Relaxed), self.at_a_time - self.permits.available_permits())
    }

    /// Waits for one's turn; `None` if so many wait already. A caller that stops waiting leaves the queue.
    pub(super) async fn turn(&self, most_waiting: usize) -> Option<OwnedSemaphorePermit> {
        if let Ok(permit) = Arc::clone(&self.permits).try_acquire_owned() {
            return Some(permit);
        }
        if !count_up(&self.waiting, most_waiting) {
            return None;
        }
        let _waiting = Waiting(Arc::clone(&self.waiting));
        Arc::clone(&self.permits).acquire_owned().await.ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn some_wait_others_are_sent_away_and_who_goes_leaves_the_queue() {
        let parsing = Arc::new(Parsing::new(1));
        let first = parsing.turn(1).await.unwrap();
        let second = tokio::spawn({
            let parsing = Arc::clone(&parsing);
            async move { parsing.turn(1).await.is_some() }
        });
        while parsing.counts() != (1, 1) {
            tokio::task::yield_now().await;
        }
        assert!(parsing.turn(1).await.is_none());
        second.abort();
        assert!(second.await.is_err());
        assert_eq!(parsing.counts(), (0, 1), "its client has gone");
        drop(first);
        assert!(parsing.turn(1).await.is_some());
        assert_eq!(parsing.counts(), (0, 0));
    }
}
