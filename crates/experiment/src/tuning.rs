//! The tuning of an experiment's fields, as its file states it.

use crate::error::Error;
use crate::goal::Goal;
use crate::raw::{self, Method};

/// The search for numbers, and the measure of their worth.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuning {
    /// The method of the search.
    pub method: Method,
    /// The quantity to be maximised.
    pub goal: Goal,
    /// Candidates of a generation; `None` is what suits the number of fields.
    pub population: Option<usize>,
    /// Most generations.
    pub generations: usize,
    /// The same seed gives the same candidates.
    pub seed: u64,
    /// Seeds that have no part in the search, with which its result is compared with the untuned values.
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
