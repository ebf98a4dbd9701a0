//! Tuning: the numbers of an experiment's fields that make its runs best.
//!
//! `plan` is what the file says of it, thought through; `optimizers` ask for candidates, generation by generation, and
//! `candidate` is one with what came of it. [`tune()`] runs them on all cores. `outcome` is what came of it all.
//!
//! Runs are numbered: each candidate has a block of numbers, for the seeds of the search and those of the check at the
//! end. So the journal of a sweep is that of a tuning, too; and as an optimizer does the same for the same costs, a
//! tuning that was killed goes on where it was. One that is over goes on if it is given more generations.

mod candidate;
pub(crate) mod course;
#[cfg(feature = "tune")]
mod genetic;
#[cfg(feature = "tune")]
mod ledger;
#[cfg_attr(not(feature = "tune"), path = "no_optimizers.rs")]
mod optimizers;
mod outcome;
mod plan;
#[cfg(test)]
mod tests;

use std::sync::atomic::Ordering;
use std::time::Duration;

pub use candidate::{Candidate, Outcome};
pub use outcome::Tuned;

use crate::batches::Batches;
use crate::check::check;
use crate::error::Error;
use crate::estimate::Estimate;
use crate::experiment::Experiment;
use crate::journal::Journal;
use crate::outputs::Folder;
use crate::resumed;
use crate::run_record::Task;
use crate::sweep::{self, Options};
pub(crate) use candidate::number_at;
pub(crate) use optimizers::check as check_optimizers;
use plan::Plan;

/// Looks for the numbers of an experiment's fields that make its goal largest, and writes the results. Each field has a
/// range; the experiment without any of them is the untuned one, against which the result is held.
///
/// # Errors
/// If the experiment is invalid, or has no `[tune]`; if it is to be a shard; if the folder is another's, the tuning is
/// long and not confirmed, no candidate can be run, a file cannot be written or the server fails. What was run is in
/// the journal.
pub fn tune(experiment: &Experiment, options: &Options<'_>) -> Result<Tuned, Error> {
    if options.shard.is_some() {
        return Err(Error::Refused(NO_SHARDS.to_owned()));
    }
    optimizers::check()?;
    let plan = Plan::new(experiment)?;
    check(experiment)?;
    if !options.confirmed {
        Estimate::new(plan.most_runs, 1, Duration::ZERO, 1).refuse_long("up to ")?;
    }
    let folder = Folder::take(options.out)?;
    let mut journal = resume(&plan, &folder, options)?;
    let batches = Batches::new(experiment, options, &folder, &mut journal)?;
    let mut tuner = Tuner { plan, options, batches };
    let untuned = match tuner.untuned() {
        Err(error) => {
            sweep::forget_journal(&folder, options.fresh)?;
            return Err(error);
        }
        Ok(untuned) => untuned,
    };
    if options.fresh {
        remove_outputs(&folder)?;
        sweep::keep_journal(&folder, tuner.batches.journal)?;
    }
    let mut tuned = Tuned::new(untuned);
    tuner.search(&mut tuned)?;
    if !tuned.interrupted {
        tuner.compare(&mut tuned)?;
    }
    tuner.batches.finish()?;
    if !tuned.interrupted {
        tuned.write(experiment, &folder)?;
    }
    Ok(tuned)
}

/// The journal of what was run before.
fn resume(plan: &Plan<'_>, folder: &Folder, options: &Options<'_>) -> Result<Journal, Error> {
    let mut journal = sweep::begin_journal(folder, &plan.header(), options)?;
    if plan.has_candidates(&journal.runs()) {
        // Later candidates came of these failures.
        journal.keep_failed();
    }
    resumed::tell(plan.experiment, &journal, None, options.tell);
    Ok(journal)
}

struct Tuner<'a> {
    plan: Plan<'a>,
    options: &'a Options<'a>,
    batches: Batches<'a>,
}

impl Tuner<'_> {
    /// The brain as it is: `None` if its runs were stopped. From them it is known how long the others may take.
    fn untuned(&mut self) -> Result<Option<Candidate>, Error> {
        let none = Candidate { number: 0, generation: 0, values: Vec::new(), outcome: Outcome::default() };
        let took = self.run(self.plan.tasks(&none, false))?;
        let pilots = took.1;
        if pilots > 0 && !self.options.confirmed && !self.is_stopped() {
            let missing = self.plan.most_runs.saturating_sub(self.batches.rows.len() as u64);
            Estimate::new(missing, pilots, took.0, self.options.jobs).refuse_long("up to ")?;
        }
        Ok(self.judged(none, false))
    }

    /// Generation by generation.
    fn search(&mut self, tuned: &mut Tuned) -> Result<(), Error> {
        let mut past: Vec<Vec<f64>> = Vec::new();
        while past.len() < self.plan.tuning.generations && !tuned.interrupted {
            let Some(points) = self.plan.course.generation(&past)? else {
                tuned.converged = true;
                return Ok(());
            };
            let generation = past.len() + 1;
            let mut candidates = Vec::new();
            for point in points {
                let numbers = self.plan.ranges.iter().zip(&point);
                let values = numbers.map(|(range, share)| number_at(range, *share)).collect();
                let number = 1 + (tuned.candidates.len() + candidates.len()) as u64;
                candidates.push(Candidate { number, generation, values, outcome: Outcome::default() });
            }
            let tasks: Vec<_> =
                candidates.iter().flat_map(|candidate| self.plan.tasks(candidate, false)).collect();
            self.run(tasks)?;
            let judged: Option<Vec<_>> =
                candidates.into_iter().map(|candidate| self.judged(candidate, false)).collect();
            let Some(judged) = judged else {
                tuned.interrupted = true;
                return Ok(());
            };
            past.push(judged.iter().map(|candidate| candidate.outcome.cost()).collect());
            tuned.candidates.extend(judged);
            tuned.refuse_hopeless(&self.plan.tuning.goal)?;
        }
        Ok(())
    }

    /// The best and the untuned with seeds that had no part in the search.
    fn compare(&mut self, tuned: &mut Tuned) -> Result<(), Error> {
        let (Some(best), Some(untuned)) = (tuned.best().cloned(), tuned.untuned.clone()) else {
            return Ok(());
        };
        if self.plan.tuning.check_seeds == 0 {
            return Ok(());
        }
        let tasks =
            [&best, &untuned].into_iter().flat_map(|candidate| self.plan.tasks(candidate, true)).collect();
        self.run(tasks)?;
        match (self.judged(best, true), self.judged(untuned, true)) {
            (Some(best), Some(untuned)) => tuned.checked = Some((best.outcome, untuned.outcome)),
            _ => tuned.interrupted = true,
        }
        Ok(())
    }

    /// Does those runs that are missing. Returns how long they took, one after the other, and how many they were.
    fn run(&mut self, tasks: Vec<Task>) -> Result<(Duration, u64), Error> {
        self.batches.run(tasks, self.plan.most_runs)
    }

    /// A candidate with its results; `None` if not all of its runs are done.
    fn judged(&self, candidate: Candidate, is_check: bool) -> Option<Candidate> {
        let runs = self.plan.tasks(&candidate, is_check).into_iter().map(|task| task.run);
        let rows = runs.map(|run| self.batches.rows.get(&run)).collect::<Option<Vec<_>>>()?;
        let outcome = Outcome::of(self.plan.experiment, &self.plan.tuning.goal, rows.into_iter());
        Some(Candidate { outcome, ..candidate })
    }

    fn is_stopped(&self) -> bool {
        self.options.stop.load(Ordering::Relaxed)
    }
}

/// Removes what an earlier tuning made of its journal.
fn remove_outputs(folder: &Folder) -> Result<(), Error> {
    outcome::FILES.iter().try_for_each(|name| folder.remove(name))
}

const NO_SHARDS: &str = "--shard: tuning has no shards, as each generation depends on the results of the one before; --jobs and \
                         --connect share its work";
