//! Means and shares with the intervals that they are in with a confidence of 95 %.

mod distribution;
mod proportion;
mod sample;

pub use proportion::wilson;
pub use sample::Sample;
