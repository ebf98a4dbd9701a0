//! Threads that share the work of a step.

use std::collections::VecDeque;
use std::hint;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::learn::error::LearnError;

/// The thread that calls, and others if there are to be more.
pub(crate) struct Threads {
    count: usize,
    pool: Option<ThreadPool>,
    process: u32,
    /// Pieces of work that have begun.
    begun: Arc<AtomicU64>,
}

impl Threads {
    /// Starts the threads, the one that calls among them.
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
            // The old pool is not dropped, as that would wait for threads that do not exist in this process.
            std::mem::forget(std::mem::replace(self, Self::start(self.count)?));
        }
        Ok(())
    }

    /// Does all of this work. The first of several errors is returned.
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
        let parts = parts(work.collect(), self.count);
        let failed: Mutex<Option<(usize, LearnError)>> = Mutex::new(None);
        let run = || {
            // The threads of the pool have numbers from 0 on, the one that calls has none.
            let own = rayon::current_thread_index().map_or(0, |index| index + 1);
            while let Some((place, one)) = next(&parts, own) {
                if let Err(error) = each(one) {
                    let mut failed = lock(&failed);
                    if failed.as_ref().is_none_or(|(other, _)| place < *other) {
                        *failed = Some((place, error));
                    }
                }
            }
        };
        let (others, done) = (pool.current_num_threads(), AtomicUsize::new(0));
        pool.in_place_scope(|scope| {
            for _ in 0..others {
                scope.spawn(|_| {
                    run();
                    let counter = Arc::clone(&self.begun);
                    pool.spawn(move || linger(|| counter.load(Ordering::Acquire) != begun));
                    done.fetch_add(1, Ordering::Release);
                });
            }
            run();
            linger(|| done.load(Ordering::Acquire) == others);
            // Work behind the last one that takes less than a sleep.
            (0..SPINS).for_each(|_| hint::spin_loop());
        });
        failed.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), |(_, error)| Err(error))
    }
}

/// The work with its places, a part for each thread. What a thread has worked on is in its processor's cache, so that it is to have the same
/// part each time.
fn parts<T>(work: Vec<T>, count: usize) -> Vec<Mutex<VecDeque<(usize, T)>>> {
    let size = work.len().div_ceil(count);
    let mut work = work.into_iter().enumerate();
    (0..count).map(|_| Mutex::new(work.by_ref().take(size).collect())).collect()
}

/// The next piece of a thread's own part; once that is done, the last one of another's.
fn next<T>(parts: &[Mutex<VecDeque<T>>], own: usize) -> Option<T> {
    let others = || (1..parts.len()).find_map(|i| lock(&parts[(own + i) % parts.len()]).pop_back());
    let next = lock(&parts[own]).pop_front();
    next.or_else(others)
}

/// Stays awake until something has happened, or for a moment. To wake a thread takes about as long as a step of some ten worlds, and
/// between two steps there is often no more than a small policy.
fn linger(has_happened: impl Fn() -> bool) {
    let until = Instant::now() + LINGER;
    while !has_happened() && Instant::now() < until {
        (0..SPINS).for_each(|_| hint::spin_loop());
    }
}

/// The scope reports the panic of another thread.
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

/// The spins between two looks.
const SPINS: usize = 16;
