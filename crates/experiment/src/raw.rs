//! The fields of an experiment file.

use serde::Deserialize;
use toml::{Table, Value};

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Experiment {
    pub(crate) name: Option<String>,
    #[serde(default)]
    pub(crate) description: String,
    pub(crate) scenario: String,
    pub(crate) brain: Option<Value>,
    pub(crate) brains: Option<Vec<String>>,
    pub(crate) seconds: Option<f64>,
    pub(crate) seeds: Option<Value>,
    #[serde(default)]
    pub(crate) design: Kind,
    pub(crate) samples: Option<u64>,
    pub(crate) seed: Option<u64>,
    #[serde(default)]
    pub(crate) fields: Vec<Field>,
    pub(crate) success: Option<Table>,
    pub(crate) require: Option<Value>,
    #[serde(default)]
    pub(crate) nearness: bool,
    #[serde(default)]
    pub(crate) find: Find,
    pub(crate) tune: Option<Tune>,
    #[serde(default)]
    pub(crate) worst: Worst,
    #[serde(default)]
    pub(crate) charts: Vec<Chart>,
}

/// Requirements on the robots of a run, or on one.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Require {
    pub(crate) always: Option<String>,
    pub(crate) never: Option<String>,
    pub(crate) eventually: Option<String>,
    pub(crate) whenever: Option<String>,
    pub(crate) then: Option<String>,
    pub(crate) within_s: Option<f64>,
    pub(crate) from_s: Option<f64>,
    pub(crate) robot: Option<String>,
}

/// The search for the worst run.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Worst {
    pub(crate) method: Option<Strategy>,
    pub(crate) seed: Option<u64>,
    pub(crate) particles: Option<u64>,
    pub(crate) repeats: Option<u64>,
}

/// The way in which the worst run is searched for.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// Each run is drawn anew, so that the share that fails bounds the probability of failure.
    Random,
    /// Covariance matrix adaptation, from the worst of some that were drawn, again and again.
    CmaEs,
    /// Adaptive multilevel splitting: runs that came near to a failure go on from there with other random numbers.
    Splitting,
}

/// A brain that is a program.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Program {
    pub(crate) exec: String,
    #[serde(default)]
    pub(crate) reuse: bool,
}

/// The kind of design.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Kind {
    #[default]
    Grid,
    List,
    Random,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Field {
    pub(crate) field: Option<String>,
    pub(crate) label: Option<String>,
    pub(crate) unit: Option<String>,
    pub(crate) values: Option<Vec<Value>>,
    pub(crate) levels: Option<Vec<Level>>,
    pub(crate) from: Option<f64>,
    pub(crate) to: Option<f64>,
    pub(crate) log: Option<bool>,
    pub(crate) whole: Option<bool>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Level {
    pub(crate) name: String,
    #[serde(default)]
    pub(crate) set: Vec<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Find {
    #[serde(default)]
    pub(crate) wants: Wants,
    pub(crate) share: Option<f64>,
    pub(crate) tolerance: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Tune {
    #[serde(default)]
    pub(crate) method: Method,
    #[serde(default)]
    pub(crate) maximize: Table,
    pub(crate) population: Option<u64>,
    pub(crate) generations: Option<u64>,
    pub(crate) seed: Option<u64>,
    pub(crate) check_seeds: Option<u64>,
}

/// The method that searches for numbers.
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

/// The end of a field's values that is sought.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Wants {
    /// The lowest value that succeeds.
    #[default]
    Lowest,
    /// The highest value that succeeds.
    Highest,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Chart {
    pub(crate) figure: String,
    #[serde(default)]
    pub(crate) kind: ChartKind,
    pub(crate) x: Option<String>,
    pub(crate) by: Option<String>,
    pub(crate) title: Option<String>,
    #[serde(default)]
    pub(crate) difference: bool,
}

/// The form of a chart.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum ChartKind {
    /// A line for each level of a field, over another.
    #[default]
    Lines,
    /// A field of colours with a number in each.
    Heat,
}
