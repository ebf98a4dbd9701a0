//! Area coverage in rows: to and fro across all of a known floor, as one mows a lawn (§6.1: area coverage).
//!
//! [`regions`] divides the floor into regions without a hole, by a line that sweeps across it: the boustrophedon cellular
//! decomposition of Choset and Pignon 1997, on a grid. [`Region::rows`] has the rows of one, and [`CoverRows`] drives them,
//! region after region.

mod behavior;
mod passage;
mod regions;

pub use behavior::{CoverRows, Parameters};
pub use regions::{Parts, Region, Rows, regions};
