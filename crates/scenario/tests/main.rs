//! Scenario files: their content, refusals, presets, examples of the documentation, and their schema.

mod budget;
#[path = "../../sim/tests/common/mod.rs"]
mod common;
mod documentation;
mod files;
mod measured;
mod presets;
#[cfg(feature = "schema")]
mod schema;
mod starts;
mod warnings;
