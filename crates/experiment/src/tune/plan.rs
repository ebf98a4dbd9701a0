//! The plan of a tuning, which is known before the first run.

use crate::design::Cell;
use crate::error::Error;
use crate::experiment::{Experiment, bounded};
use crate::factor::{Choice, Field, Range};
use crate::fingerprint::{build, fingerprint_with};
use crate::journal::Header;
use crate::run_record::Task;
use crate::tuning::Tuning;

use super::candidate::{Candidate, levels};
use super::course::Course;

pub(super) struct Plan<'a> {
    pub(super) experiment: &'a Experiment,
    pub(super) tuning: &'a Tuning,
    pub(super) course: Course,
    pub(super) ranges: Vec<Range>,
    /// The most runs that there are; each candidate has numbers for those of a check, too.
    pub(super) most_runs: u64,
}

impl<'a> Plan<'a> {
    pub(super) fn new(experiment: &'a Experiment) -> Result<Self, Error> {
        let missing =
            || Error::field("tune", "is missing: what to maximize, such as maximize = { covered = 1.0 }");
        let tuning = experiment.tuning.as_ref().ok_or_else(missing)?;
        let ranges = ranges(experiment)?;
        if experiment.seeds.last() > i64::MAX as u64 - tuning.check_seeds {
            return Err(Error::field("seeds", "are too large: the seeds of the check come after them"));
        }
        let course = Course::new(tuning, ranges.len());
        let most_runs = most_runs(experiment, tuning, &course)?;
        Ok(Self { experiment, tuning, course, ranges, most_runs })
    }

    /// The journal's. More generations go on with what there is.
    pub(super) fn header(&self) -> Header {
        let Self { experiment, tuning, course, .. } = self;
        let own = format!("{:?}", (course, &tuning.goal, tuning.check_seeds, &experiment.success));
        Header::new(&experiment.name, fingerprint_with(experiment, &own), build(), i64::MAX as u64)
    }

    /// Whether a candidate is among these runs, and not only the untuned brain.
    pub(super) fn has_candidates(&self, runs: &[u64]) -> bool {
        let first = self.experiment.seeds.count() + self.tuning.check_seeds;
        runs.last().is_some_and(|last| *last >= first)
    }

    /// The runs of a candidate: those of the search, or those of the check.
    pub(super) fn tasks(&self, candidate: &Candidate, is_check: bool) -> Vec<Task> {
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
}

/// The ranges of an experiment's fields.
pub(super) fn ranges(experiment: &Experiment) -> Result<Vec<Range>, Error> {
    let range = |(i, field): (usize, &Field)| match &field.choice {
        Choice::Range(range) => Ok(range.clone()),
        Choice::Levels(_) => {
            let problem = "has values instead of a range; a tuned field goes `from` a number `to` another";
            Err(Error::field(format!("fields[{i}]"), problem))
        }
    };
    let ranges = experiment.fields.iter().enumerate().map(range).collect::<Result<Vec<_>, _>>()?;
    if ranges.is_empty() {
        return Err(Error::field("fields", "is missing: give at least one [[fields]] to tune"));
    }
    Ok(ranges)
}

fn most_runs(experiment: &Experiment, tuning: &Tuning, course: &Course) -> Result<u64, Error> {
    let (seeds, checks) = (experiment.seeds.count(), tuning.check_seeds);
    let candidates = 1 + (course.population * tuning.generations) as u64;
    let path = if seeds >= candidates { "seeds" } else { "tune.generations" };
    bounded(path, u128::from(candidates) * u128::from(seeds) + u128::from(2 * checks))
}
