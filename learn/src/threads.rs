//! Threads that share the work of a step.

use std::hint;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::LearnError;

/// The thread that calls, and others if there are to be more.
pub(crate) struct Threads {
    count: usize,
    pool: Option<ThreadPool>,
    process: u32,
    /// Pieces of work that have begun.
    begun: Arc<AtomicU64>,
}

impl Threads {
    /// So many, the one that calls among them.
    ///
    /// # Errors
    /// If the system has no more threads.
    pub(crate) fn start(count: usize) -> Result<Self, LearnError> {
        Ok(Self { count, pool: pool(count)?, process: std::process::id(), begun: Arc::default() })
    }

    /// A process that was forked has none of its parent's threads: it starts its own.
    ///
    /// # Errors
    /// If the system has no more threads.
    pub(crate) fn are_there(&mut self) -> Result<(), LearnError> {
        if self.process != std::process::id() {
            // To drop the old pool would wait for threads that there are not.
            std::mem::forget(std::mem::replace(self, Self::start(self.count)?));
        }
        Ok(())
    }

    /// Does all of this work. Of several errors the first one's is told.
    ///
    /// # Errors
    /// Those of the work.
    pub(crate) fn each<T: Send>(
        &self,
        mut work: impl Iterator<Item = T>,
        each: impl Fn(T) -> Result<(), LearnError> + Sync + Send,
    ) -> Result<(), LearnError> {
        let Some(pool) = &self.pool else { return work.try_for_each(each) };
        let begun = self.begun.fetch_add(1, Ordering::Release) + 1;
        let work: Vec<T> = work.collect();
        let batch = (work.len() / BATCHES).clamp(1, MOST_A_BATCH);
        let queue = Mutex::new(work.into_iter().enumerate());
        let failed: Mutex<Option<(usize, LearnError)>> = Mutex::new(None);
        // This thread begins at once; the others take what is left when they have woken up.
        let run = || {
            loop {
                let taken: Vec<_> = lock(&queue).by_ref().take(batch).collect();
                if taken.is_empty() {
                    return;
                }
                for (place, one) in taken {
                    if let Err(error) = each(one) {
                        let mut failed = lock(&failed);
                        if failed.as_ref().is_none_or(|(other, _)| place < *other) {
                            *failed = Some((place, error));
                        }
                    }
                }
            }
        };
        pool.in_place_scope(|scope| {
            for _ in 0..pool.current_num_threads() {
                scope.spawn(|_| {
                    run();
                    let counter = Arc::clone(&self.begun);
                    pool.spawn(move || linger(&counter, begun));
                });
            }
            run();
        });
        failed.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), |(_, error)| Err(error))
    }
}

/// Stays awake for a moment, until other work begins. To wake a thread takes about as long as a step of some ten worlds, and between
/// two steps there is often no more than a small policy.
fn linger(begun: &AtomicU64, done: u64) {
    let until = Instant::now() + LINGER;
    while begun.load(Ordering::Acquire) == done && Instant::now() < until {
        (0..SPINS).for_each(|_| hint::spin_loop());
        thread::yield_now();
    }
}

/// What another thread panicked with is told by the scope.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn pool(threads: usize) -> Result<Option<ThreadPool>, LearnError> {
    if threads == 1 {
        return Ok(None);
    }
    let builder = ThreadPoolBuilder::new().num_threads(threads - 1).thread_name(|i| format!("worlds {i}"));
    let failed = |error| LearnError::value("threads", format!("cannot start {threads}: {error}"));
    builder.build().map(Some).map_err(failed)
}

/// So long a thread waits for more work before it sleeps.
const LINGER: Duration = Duration::from_micros(200);

/// Between two looks at the clock.
const SPINS: usize = 16;

/// So many batches are taken by all threads, if there are enough environments.
const BATCHES: usize = 32;

/// Environments of a batch, so that no thread waits long for the last one.
const MOST_A_BATCH: usize = 16;
