//! The budget against runs: what it foretells is what happens, and its bounds hold whatever the scenario.

mod examples;
mod limits;
mod random;
mod remedies;
mod run;
mod writers;
