//! Experiments: a scenario that is run many times with some of its fields varied, and what came of it.
//!
//! From the file inwards:
//!
//! 1. An [`Experiment`] is what an experiment file says, checked; `raw` is what may stand in such a file, `factor` a
//!    field with its values, `design` which of their combinations are run. [`check`] finds paths that lead nowhere.
//! 2. `setup` is the scenario of a run, with the brain of each robot. `local_runner` makes a [`Row`] of a run in this process, `remote` of one
//!    on a server, with its [`figures`]. [`served`] is a run on a server that is watched tick by tick.
//! 3. [`sweep()`] runs what is missing on all cores. The `journal` keeps each row as it comes, so that a sweep which was
//!    killed goes on where it was; `outputs` makes tables of it, `table` what is told about each cell. A [`Shard`] is the share of
//!    one of many machines; [`merge()`] makes of their journals what one machine would have made.
//! 4. [`find`] looks for the value at which a brain just succeeds, [`mod@tune`] for the numbers with which it does best.
//! 5. [`chart`] says what charts show, and `baudbot_plot` draws them; `columnar` writes Parquet, if the feature `parquet` is
//!    on. The optimizers of [`mod@tune`] need the feature `tune`.
//! 6. [`grade`] holds what a brain did in an exercise against criteria that are worth points, [`evidence`] presets against measurements
//!    of real robots.

mod batches;
pub mod chart;
mod check;
mod checked_fields;
#[cfg(feature = "parquet")]
pub mod columnar;
mod csv_table;
pub mod design;
mod error;
mod estimate;
pub mod evidence;
mod experiment;
pub mod factor;
mod failure;
pub mod figures;
pub mod find;
mod fingerprint;
mod goal;
pub mod grade;
mod hunt;
mod ids;
mod journal;
mod local_runner;
mod merge;
mod observed_world;
mod observer;
mod outputs;
mod packed;
mod paired;
#[cfg(feature = "parquet")]
mod parquet_table;
mod places;
mod pool;
mod private_server;
mod raw;
mod read;
mod remote;
mod requested_charts;
pub mod requirement;
mod resumed;
mod run_options;
mod run_record;
mod seeds;
pub mod served;
mod setup;
mod shard;
pub mod statistics;
mod success;
pub mod summary;
mod sweep;
pub mod table;
#[cfg(test)]
mod tests;
mod told;
pub mod tune;
mod tuning;
pub mod worst;

pub use check::check;
pub use error::Error;
pub use estimate::{Estimate, span};
pub use experiment::{Experiment, Find, MOST_RUNS};
pub use goal::Goal;
pub use ids::unique_name;
pub use local_runner::run;
pub use merge::{Merged, Missing, MissingShard, merge};
pub use packed::Packed;
pub use paired::Comparison;
pub use pool::{BRAIN_TIMEOUT, Place, Workers};
pub use raw::{ChartKind, Method, Wants};
pub use read::ReadError;
pub use requested_charts::Chart;
pub use requirement::Demand;
pub use run_record::{Ran, Row, RunError, Task};
pub use seeds::Seeds;
pub use shard::{Shard, ShardError};
pub use success::{Condition, Conditions, Quantity, Success};
pub use sweep::{Options, Swept, sweep};
pub use told::Told;
pub use tune::{Tuned, tune};
pub use tuning::Tuning;
pub use worst::{Limit, Worst, merge_worst, trial, worst};
