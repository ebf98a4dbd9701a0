//! Fits numbers of a scenario to logs of real robots.
//!
//! [`log`] reads a log: a table with units in the names of its columns.

pub mod log;
