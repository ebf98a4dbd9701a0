//! Runs: a world, and the brain of each of its robots.
//!
//! 1. [`assignment`] says which brain drives which robot, and has those at work that attach to a server.
//! 2. [`in_process`] is a world and its brains in one thread, without a server.
//! 3. [`programs`] are brains that are programs of their own: started, watched, and ended with all their children.
//! 4. [`learn`] has environments for programs that learn: worlds that are stepped a control cycle at a time.

pub mod assignment;
pub mod in_process;
#[cfg(feature = "learn")]
pub mod learn;
pub mod programs;
mod suggest;

pub use suggest::UnknownName;
