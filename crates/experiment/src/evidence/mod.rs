//! Presets held against measurements of real robots.
//!
//! A [`Comparison`] is a file in `crates/experiment/comparisons`: a measurement on a real robot, with its source, and
//! the [`Experiment`](experiment::Experiment) that repeats it in a world of ours with the preset as it is.
//! [`Comparison::run`] does the experiment, and the [`Bound`] says whether a point agrees. Single numbers are held
//! against their fields of a preset by [`fields`]. A number without a measurement is a guess, and [`guesses`] lists
//! those with what would settle each.
//!
//! [`page`] makes `docs/evidence.md` and its pictures of all of this. `known` says in a line how well a preset is known.

mod at;
mod comparison;
pub mod experiment;
pub mod fields;
pub mod guesses;
mod known;
pub mod page;
mod picture;
mod sample;

pub use at::At;
pub use comparison::{Bound, Compared, Comparison, Point, Reliability, comparisons};
pub use experiment::ExperimentError;
pub use known::known;
pub use sample::Sample;
