//! Requirements on quantities of a run, and by how much the run keeps to them: robustness as in signal temporal logic (Donzé and
//! Maler, *Robust satisfaction of temporal logic over real-valued signals*, 2010), sample by sample.
//!
//! 1. A [`Formula`] is a condition on one sample, parsed from text: `clearance_m > 0.05`. Who has the quantities resolves their names.
//! 2. Its robustness is by how much it holds of a sample.

mod error;
mod expression;
mod formula;
mod margin;
mod parse;

pub use error::{Expectation, FormulaError, Hint, MOST_BYTES, MOST_DEPTH, Token};
pub use formula::Formula;
