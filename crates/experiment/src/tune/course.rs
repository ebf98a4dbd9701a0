//! One search for numbers.

use crate::raw::Method;
use crate::tuning::Tuning;

/// One optimization.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Course {
    pub(super) method: Method,
    /// The number of dimensions; at least 1.
    pub(super) dimensions: usize,
    /// Candidates of a generation; a genetic algorithm may have fewer, as it keeps some.
    pub(super) population: usize,
    pub(super) seed: u64,
}

impl Course {
    pub(super) fn new(tuning: &Tuning, dimensions: usize) -> Self {
        // Hansen's recommendation for CMA-ES, with a few more, as runs are noisy.
        let suited = 8 + (3.0 * (dimensions as f64).ln()) as usize;
        let population = tuning.population.unwrap_or(suited);
        Self { method: tuning.method, dimensions, population, seed: tuning.seed }
    }
}
