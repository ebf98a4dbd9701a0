//! Scenario files: what they may contain, what is refused, presets, what the documentation says of them, and their schema.

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
