//! One search for numbers.

use crate::raw::Method;
use crate::tuning::Tuning;

/// One optimization.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Course {
    pub(crate) method: Method,
    /// The number of dimensions; at least 1.
    pub(crate) dimensions: usize,
    /// Candidates of a generation; a genetic algorithm may have fewer, as it keeps some.
    pub(crate) population: usize,
    pub(crate) seed: u64,
    /// The middle of the first generation of CMA-ES; `None` is that of all ranges.
    pub(crate) start: Option<Vec<f64>>,
}

impl Course {
    pub(super) fn new(tuning: &Tuning, dimensions: usize) -> Self {
        let population = tuning.population.unwrap_or_else(|| suited_population(dimensions));
        Self { method: tuning.method, dimensions, population, seed: tuning.seed, start: None }
    }
}

/// Hansen's recommendation for CMA-ES, with a few more, as runs are noisy.
pub(crate) fn suited_population(dimensions: usize) -> usize {
    8 + (3.0 * (dimensions as f64).ln()) as usize
}
