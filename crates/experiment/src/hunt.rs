//! The search for the worst run, as the experiment's file states it.

use crate::error::Error;
use crate::raw::{self, Strategy};

/// The way in which the worst run is searched for.
#[derive(Clone, Debug, PartialEq)]
pub struct Hunt {
    /// The strategy; `None` is [`Strategy::CmaEs`] if there are fields, and [`Strategy::Random`] without.
    pub strategy: Option<Strategy>,
    /// The same seed gives the same runs.
    pub seed: u64,
    /// Runs that are under way at a time, for [`Strategy::Splitting`].
    pub particles: usize,
    /// Independent estimates, for [`Strategy::Splitting`].
    pub repeats: usize,
}

impl Hunt {
    pub(crate) fn new(raw: &raw::Worst) -> Result<Self, Error> {
        Ok(Self {
            strategy: raw.method,
            seed: raw.seed.unwrap_or(1),
            particles: within("particles", raw.particles.unwrap_or(PARTICLES), 10, 100_000)?,
            repeats: within("repeats", raw.repeats.unwrap_or(REPEATS), 2, 1000)?,
        })
    }
}

fn within(name: &str, count: u64, least: u64, most: u64) -> Result<usize, Error> {
    if (least..=most).contains(&count) {
        return Ok(count as usize);
    }
    Err(Error::field(format!("worst.{name}"), format!("must be from {least} to {most}, is {count}")))
}

const PARTICLES: u64 = 100;
const REPEATS: u64 = 10;
