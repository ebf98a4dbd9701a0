//! How an experiment's fields are tuned, as its file says it.

use crate::choice::{Choice, Range};
use crate::error::Error;
use crate::experiment::Experiment;
use crate::raw;

use super::goal::Goal;
use super::method::{Course, Method};

/// How numbers are looked for, and what makes them good.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuning {
    /// How they are looked for.
    pub method: Method,
    /// What is made large.
    pub goal: Goal,
    /// Candidates of a generation; `None` is what suits the number of fields.
    pub population: Option<usize>,
    /// Most generations.
    pub generations: usize,
    /// The same seed gives the same candidates.
    pub seed: u64,
    /// Seeds that have no part in the search, with which its result is held against the untuned.
    pub check_seeds: u64,
}

impl Tuning {
    pub(crate) fn new(raw: raw::Tune) -> Result<Self, Error> {
        let population = raw.population.map(|count| within("population", count, 4, MOST_CANDIDATES));
        Ok(Self {
            method: raw.method,
            goal: Goal::new(&raw.maximize)?,
            population: population.transpose()?,
            generations: within("generations", raw.generations.unwrap_or(GENERATIONS), 1, MOST_GENERATIONS)?,
            seed: raw.seed.unwrap_or(1),
            check_seeds: within("check_seeds", raw.check_seeds.unwrap_or(CHECK_SEEDS), 0, MOST_CANDIDATES)?
                as u64,
        })
    }

    pub(super) fn course(&self, dimensions: usize) -> Course {
        // Hansen's recommendation for CMA-ES, with a few more, as runs are noisy.
        let suited = 8 + (3.0 * (dimensions as f64).ln()) as usize;
        let population = self.population.unwrap_or(suited);
        Course { method: self.method, dimensions, population, seed: self.seed }
    }
}

/// The ranges of an experiment's fields.
pub(super) fn ranges(experiment: &Experiment) -> Result<Vec<Range>, Error> {
    let range = |(i, field): (usize, &crate::choice::Field)| match &field.choice {
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

fn within(name: &str, count: u64, least: u64, most: u64) -> Result<usize, Error> {
    if (least..=most).contains(&count) {
        return Ok(count as usize);
    }
    Err(Error::field(format!("tune.{name}"), format!("must be from {least} to {most}, is {count}")))
}

const GENERATIONS: u64 = 30;
const CHECK_SEEDS: u64 = 10;
const MOST_CANDIDATES: u64 = 10_000;
/// An optimizer is run from its beginning in each generation.
const MOST_GENERATIONS: u64 = 2000;
