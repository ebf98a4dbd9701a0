//! Means and shares with the intervals that they are in with a confidence of 95 %.

mod distribution;
mod paired;
mod proportion;
mod sample;

pub(crate) use distribution::student;
pub use paired::{mcnemar, pairs_for_difference, pairs_for_shares};
pub use proportion::{clopper_pearson, runs_without_failure, wilson};
pub use sample::Sample;
