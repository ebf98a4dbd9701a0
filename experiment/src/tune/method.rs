//! How numbers are looked for, and one such search.

use serde::Deserialize;

/// How numbers are looked for.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
pub enum Method {
    /// Covariance matrix adaptation: samples of a normal distribution that moves, grows, shrinks and leans as the better half
    /// of them say. It begins in the middle of all ranges, and folds back what is beyond their ends.
    #[default]
    #[serde(rename = "cma-es")]
    CmaEs,
    /// Particle swarm optimization: each particle is drawn to the best place that it has seen, and to the best of all.
    #[serde(rename = "pso")]
    Swarm,
    /// A genetic algorithm: tournaments, children between their parents or a little beyond, mutations by up to an eighth of
    /// the range.
    #[serde(rename = "ga")]
    Genetic,
}

/// One optimization.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Course {
    pub(super) method: Method,
    /// How many numbers are looked for; at least 1.
    pub(super) dimensions: usize,
    /// Candidates of a generation; a genetic algorithm may have fewer, as it keeps some.
    pub(super) population: usize,
    pub(super) seed: u64,
}
