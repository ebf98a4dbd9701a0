//! Requirements on quantities of a run, and by how much the run keeps to them: robustness as in signal temporal logic (Donzé and
//! Maler, *Robust satisfaction of temporal logic over real-valued signals*, 2010), sample by sample.
//!
//! 1. A [`Formula`] is a condition on one sample, parsed from text: `clearance_m > 0.05`. Who has the quantities resolves their names.
//! 2. A [`Requirement`] says when its formulas must hold: always, never, eventually, or soon after another one does.
//! 3. A [`Monitor`] sees the samples of a run, and has a [`Verdict`] at any time.
//!
//! Deviations from signal temporal logic: time is that of the samples, and nothing is assumed between them; temporal operators do not
//! stand in one another; a verdict also says whether the requirement holds, as the sign of 0 tells nothing.

mod error;
mod expression;
mod formula;
mod margin;
mod monitor;
mod parse;
mod requirement;
mod window;

pub use error::{Expectation, FormulaError, Hint, MOST_BYTES, MOST_DEPTH, Token};
pub use formula::Formula;
pub use monitor::{Monitor, OrderError, Verdict};
pub use requirement::{Requirement, Rule};
