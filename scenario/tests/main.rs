//! Scenario files: what they may contain, what is refused, presets, and what the documentation says of them.

#[path = "../../sim/tests/common/mod.rs"]
mod common;
mod documentation;
mod files;
mod measured;
mod presets;
mod starts;
mod warnings;
