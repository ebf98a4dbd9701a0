//! The budget against runs: what it foretells is what happens, and its bounds hold whatever the scenario.

mod common;

#[path = "budget/examples.rs"]
mod examples;
#[path = "budget/limits.rs"]
mod limits;
#[path = "budget/mends.rs"]
mod mends;
#[path = "budget/random.rs"]
mod random;
#[path = "budget/run.rs"]
mod run;
