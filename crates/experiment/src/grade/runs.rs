//! All runs of an exercise, on threads.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

use baudbot_run::assignment::Assigned;

use crate::error::Error;
use crate::grade::exercise::Exercise;
use crate::grade::grading::Grading;
use crate::grade::run::Run;

/// The options of a grading.
pub struct Options<'a> {
    /// The number of simultaneous runs; at least 1.
    pub jobs: usize,
    /// Once it is set the runs end, and there is no grading.
    pub stop: &'a AtomicBool,
    /// A function that gets the number of runs that are done.
    pub progress: &'a (dyn Fn(u64) + Sync),
}

/// Grades the brains of an exercise's robots. `None` if it was stopped.
///
/// # Errors
/// If no server can be started, or it fails: then nothing is known about the brain.
pub fn grade(
    exercise: &Exercise,
    assigned: &Assigned,
    options: &Options<'_>,
) -> Result<Option<Grading>, Error> {
    let (next, done) = (AtomicU64::new(0), AtomicU64::new(0));
    let runs = Mutex::new(Vec::new());
    let work = || -> Result<(), Error> {
        loop {
            let place = next.fetch_add(1, Ordering::Relaxed);
            if place >= exercise.seeds.count() || options.stop.load(Ordering::Relaxed) {
                return Ok(());
            }
            let Some(run) = Run::new(exercise, assigned, exercise.seeds.get(place), options.stop)? else {
                return Ok(());
            };
            runs.lock().unwrap_or_else(PoisonError::into_inner).push((place, run));
            (options.progress)(done.fetch_add(1, Ordering::Relaxed) + 1);
        }
    };
    thread::scope(|scope| {
        let workers: Vec<_> = (0..options.jobs.max(1)).map(|_| scope.spawn(work)).collect();
        let failed = || Err(Error::Server("a run panicked, which is a bug in baudbot".to_owned()));
        workers.into_iter().try_for_each(|worker| worker.join().unwrap_or_else(|_| failed()))
    })?;
    let mut runs = runs.into_inner().unwrap_or_else(PoisonError::into_inner);
    runs.sort_by_key(|(place, _)| *place);
    let is_whole = runs.len() as u64 == exercise.seeds.count();
    Ok(is_whole.then(|| Grading::new(exercise, runs.into_iter().map(|(_, run)| run).collect())))
}
