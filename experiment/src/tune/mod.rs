//! Tuning: the numbers of an experiment's fields that make its runs best.
//!
//! `tuning` is what the file says, `goal` what is made large; `optimizers` ask for candidates, generation by generation, and
//! `candidate` is one with what came of it. [`tune()`] runs them on all cores. `outcome` is what came of it
//! all.
//!
//! Runs are numbered: each candidate has a block of numbers, for the seeds of the search and those of the check at the end. So
//! the journal of a sweep is that of a tuning, too; and as an optimizer does the same whenever it is told the same, a tuning
//! that was killed goes on where it was. One that is over goes on if it is given more generations.

mod candidate;
#[cfg(feature = "tune")]
mod genetic;
mod goal;
#[cfg(feature = "tune")]
mod ledger;
mod method;
#[cfg_attr(not(feature = "tune"), path = "no_optimizers.rs")]
mod optimizers;
mod outcome;
#[cfg(test)]
mod tests;
mod tuning;

use std::collections::BTreeMap;
use std::sync::atomic::Ordering;
use std::time::Duration;

pub use candidate::{Candidate, Outcome};
pub use goal::Goal;
pub use method::Method;
pub use outcome::Tuned;
pub use tuning::Tuning;

use crate::check::check;
use crate::choice::Range;
use crate::design::Cell;
use crate::error::Error;
use crate::estimate::Estimate;
use crate::experiment::Experiment;
use crate::fingerprint::{build, fingerprint_with};
use crate::journal::{Header, Journal};
use crate::outputs::Folder;
use crate::pool::Workers;
use crate::row::{Row, Task};
use crate::sweep::{self, Options};
use candidate::{levels, number_at};
use method::Course;

/// Looks for the numbers of an experiment's fields that make its goal largest, and writes what came of it. Each field has a
/// range; the experiment without any of them is the untuned one, against which the result is held.
///
/// # Errors
/// If the experiment makes no sense, or has no `[tune]`; if the folder is another's, the tuning is long and not confirmed, no
/// candidate can be run, a file cannot be written or the server fails. What was run is in the journal.
pub fn tune(experiment: &Experiment, options: &Options<'_>) -> Result<Tuned, Error> {
    optimizers::check()?;
    let missing =
        || Error::field("tune", "is missing: what to maximize, such as maximize = { covered = 1.0 }");
    let tuning = experiment.tuning.as_ref().ok_or_else(missing)?;
    let ranges = tuning::ranges(experiment)?;
    if experiment.seeds.last() > i64::MAX as u64 - tuning.check_seeds {
        return Err(Error::field("seeds", "are too large: the seeds of the check come after them"));
    }
    let course = tuning.course(ranges.len());
    let most_runs = most_runs(experiment, tuning, &course)?;
    check(experiment)?;
    if !options.confirmed {
        Estimate::new(most_runs, 1, Duration::ZERO, 1).refuse_long("up to ")?;
    }
    let folder = Folder::take(options.out)?;
    // More generations go on with what there is.
    let own = format!("{:?}", (course, &tuning.goal, tuning.check_seeds, &experiment.success));
    let header = Header::new(&experiment.name, fingerprint_with(experiment, &own), build(), i64::MAX as u64);
    let mut journal = sweep::begin_journal(&folder, &header, options)?;
    let rows = journal.rows()?.map(|row| row.map(|row| (row.run, row))).collect::<Result<_, _>>()?;
    let name = sweep::world_name(folder.id(), options.out);
    let journal = &mut journal;
    let mut tuner = Tuner { experiment, tuning, options, course, ranges, rows, journal, name, most_runs };
    let untuned = match tuner.untuned() {
        Err(error) => {
            sweep::forget_journal(&folder, options.fresh)?;
            return Err(error);
        }
        Ok(untuned) => untuned,
    };
    if options.fresh {
        remove_outputs(&folder)?;
        sweep::keep_journal(&folder, tuner.journal)?;
    }
    let mut tuned = Tuned::new(untuned);
    tuner.search(&mut tuned)?;
    if !tuned.interrupted {
        tuner.compare(&mut tuned)?;
    }
    if !tuned.interrupted {
        tuned.write(experiment, &folder)?;
    }
    Ok(tuned)
}

struct Tuner<'a> {
    experiment: &'a Experiment,
    tuning: &'a Tuning,
    options: &'a Options<'a>,
    course: Course,
    ranges: Vec<Range>,
    rows: BTreeMap<u64, Row>,
    journal: &'a mut Journal,
    name: String,
    most_runs: u64,
}

impl Tuner<'_> {
    /// The brain as it is: `None` if its runs were stopped. From them it is known how long the others may take.
    fn untuned(&mut self) -> Result<Option<Candidate>, Error> {
        let none = Candidate { number: 0, generation: 0, values: Vec::new(), outcome: Outcome::default() };
        let took = self.run(self.tasks(&none, false))?;
        let pilots = took.1;
        if pilots > 0 && !self.options.confirmed && !self.is_stopped() {
            let missing = self.most_runs.saturating_sub(self.rows.len() as u64);
            Estimate::new(missing, pilots, took.0, self.options.jobs).refuse_long("up to ")?;
        }
        Ok(self.judged(none, false))
    }

    /// Generation by generation.
    fn search(&mut self, tuned: &mut Tuned) -> Result<(), Error> {
        let mut past: Vec<Vec<f64>> = Vec::new();
        while past.len() < self.tuning.generations && !tuned.interrupted {
            let asked = self.course.generation(&past);
            let asked =
                asked.map_err(|problem| Error::field("tune", format!("the optimizer says: {problem}")))?;
            let Some(points) = asked else {
                tuned.converged = true;
                return Ok(());
            };
            let generation = past.len() + 1;
            let mut candidates = Vec::new();
            for point in points {
                let numbers = self.ranges.iter().zip(&point);
                let values = numbers.map(|(range, share)| number_at(range, *share)).collect();
                let number = 1 + (tuned.candidates.len() + candidates.len()) as u64;
                candidates.push(Candidate { number, generation, values, outcome: Outcome::default() });
            }
            let tasks: Vec<_> =
                candidates.iter().flat_map(|candidate| self.tasks(candidate, false)).collect();
            self.run(tasks)?;
            let judged: Option<Vec<_>> =
                candidates.into_iter().map(|candidate| self.judged(candidate, false)).collect();
            let Some(judged) = judged else {
                tuned.interrupted = true;
                return Ok(());
            };
            past.push(judged.iter().map(|candidate| candidate.outcome.cost()).collect());
            tuned.candidates.extend(judged);
            tuned.refuse_hopeless(&self.tuning.goal)?;
        }
        Ok(())
    }

    /// The best and the untuned with seeds that had no part in the search.
    fn compare(&mut self, tuned: &mut Tuned) -> Result<(), Error> {
        let (Some(best), Some(untuned)) = (tuned.best().cloned(), tuned.untuned.clone()) else {
            return Ok(());
        };
        if self.tuning.check_seeds == 0 {
            return Ok(());
        }
        let tasks = [&best, &untuned].into_iter().flat_map(|candidate| self.tasks(candidate, true)).collect();
        self.run(tasks)?;
        match (self.judged(best, true), self.judged(untuned, true)) {
            (Some(best), Some(untuned)) => tuned.checked = Some((best.outcome, untuned.outcome)),
            _ => tuned.interrupted = true,
        }
        Ok(())
    }

    /// The runs of a candidate: those of the search, or those of the check.
    fn tasks(&self, candidate: &Candidate, is_check: bool) -> Vec<Task> {
        let (seeds, checks) = (self.experiment.seeds.count(), self.tuning.check_seeds);
        let cell = Cell { number: candidate.number, levels: levels(&self.ranges, &candidate.values) };
        let first = candidate.number * (seeds + checks);
        let task = |place: u64| {
            let seed = match place.checked_sub(seeds) {
                None => self.experiment.seeds.get(place),
                Some(beyond) => self.experiment.seeds.last() + 1 + beyond,
            };
            Task { run: first + place, cell: cell.clone(), seed }
        };
        let places = if is_check { seeds..seeds + checks } else { 0..seeds };
        places.map(task).collect()
    }

    /// Does those runs that are missing. Says how long they took, one after the other, and how many they were.
    fn run(&mut self, tasks: Vec<Task>) -> Result<(Duration, u64), Error> {
        let missing: Vec<_> = tasks.into_iter().filter(|task| !self.rows.contains_key(&task.run)).collect();
        let (mut time, mut count) = (Duration::ZERO, 0);
        let (options, most) = (self.options, self.most_runs);
        (options.progress)(self.rows.len() as u64, most);
        let workers = Workers { place: options.place.clone(), jobs: options.jobs, name: self.name.clone() };
        let (journal, rows) = (&mut *self.journal, &mut self.rows);
        let worked = workers.work(self.experiment, missing.into_iter(), options.stop, |row, took| {
            time += took;
            count += 1;
            journal.append(&row)?;
            rows.insert(row.run, row);
            (options.progress)(rows.len() as u64, most);
            Ok(())
        });
        let synced = self.journal.sync();
        worked.and(synced).map(|()| (time, count))
    }

    /// A candidate with what came of it; `None` if not all of its runs are done.
    fn judged(&self, candidate: Candidate, is_check: bool) -> Option<Candidate> {
        let runs = self.tasks(&candidate, is_check).into_iter().map(|task| task.run);
        let rows = runs.map(|run| self.rows.get(&run)).collect::<Option<Vec<_>>>()?;
        let outcome = Outcome::of(self.experiment, &self.tuning.goal, rows.into_iter());
        Some(Candidate { outcome, ..candidate })
    }

    fn is_stopped(&self) -> bool {
        self.options.stop.load(Ordering::Relaxed)
    }
}

/// So many runs there are at most; each candidate has numbers for those of a check, too.
fn most_runs(experiment: &Experiment, tuning: &Tuning, course: &Course) -> Result<u64, Error> {
    let (seeds, checks) = (experiment.seeds.count(), tuning.check_seeds);
    let candidates = 1 + (course.population * tuning.generations) as u64;
    let numbers = seeds.checked_add(checks).and_then(|block| block.checked_mul(candidates));
    let is_countable = numbers.is_some_and(|numbers| numbers <= i64::MAX as u64);
    if !is_countable {
        return Err(Error::field("seeds", "there are more than 2^63 runs"));
    }
    Ok(candidates * seeds + 2 * checks)
}

/// Removes what an earlier tuning made of its journal.
fn remove_outputs(folder: &Folder) -> Result<(), Error> {
    outcome::FILES.iter().try_for_each(|name| folder.remove(name))
}
