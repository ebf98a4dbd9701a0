//! Scenario files: TOML in, a [`Scenario`] out in which every value is sound.
//!
//! [`parse`] reads a file in five steps:
//!
//! 1. `order` remembers the order of sensors and actuators, which a parsed TOML table forgets.
//! 2. `overrides` changes fields by path.
//! 3. `preset` expands [presets].
//! 4. `raw` describes what a file may contain; parts of a file have modules of their own.
//! 5. `build`, `robots` and the other modules check every value and make the world's own types of it, by the rules for single values of
//!    [`baudbot_fields`]. A sensor reads its own data sheet.
//!
//! [`warnings`] reports what is allowed and hardly intended. With the feature `schema`, `schema` is a JSON Schema of all this, made of
//! the types of `raw` and their comments; the tables of `docs/reference/scenario.md` are made of it.
//!
//! [`budget`] computes what a control cycle of such a scenario costs, without a run.
//!
//! This crate has no files and no clock, as [`baudbot_sim`]: text comes in, types go out.

#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

/// The names of some fields of a table, and whether each is given.
macro_rules! given {
    ($raw:expr; $($field:ident),+) => { [$((stringify!($field), $raw.$field.is_some())),+] };
}

mod actuators;
mod arena;
mod body;
pub mod budget;
mod build;
mod cable;
mod chip;
mod context;
mod controls;
mod create;
mod error;
mod faults;
mod link;
mod microcontroller;
mod motors;
mod names;
mod on_pin;
mod order;
mod overrides;
mod pins;
mod preset;
pub mod presets;
mod raw;
mod robots;
#[cfg(feature = "schema")]
mod schema;
mod sensors;
mod serial_ports;
mod shapes;
mod starts;
mod things;
mod trail;
mod warnings;

use alloc::string::{String, ToString};

use baudbot_fields::printable::PrintableLines;
use baudbot_fields::{Fields, Path};
use baudbot_sim::Scenario;
use baudbot_sim::scenario::Source;
use serde::Deserialize;
use toml::de::DeTable;

pub use error::ScenarioError;
use error::Sheet;
pub use overrides::Override;
#[cfg(feature = "schema")]
pub use schema::schema;
pub use warnings::{Warning, warnings};

/// Length of the longest scenario that is read, in bytes.
pub const MAX_BYTES: usize = 16 << 20;

/// Reads a scenario.
///
/// # Errors
/// Reports where the text is not TOML, or which field is wrong, and how.
pub fn parse(toml: &str) -> Result<Scenario, ScenarioError> {
    parse_with(toml, &[])
}

/// Reads a scenario with some of its fields changed.
///
/// # Errors
/// As [`parse`]; also if the path of an override leads nowhere.
pub fn parse_with(toml: &str, overrides: &[Override]) -> Result<Scenario, ScenarioError> {
    let parsed = parse_while(toml, overrides, &|| true)?;
    Ok(parsed.expect("it is not given up"))
}

/// The same as [`parse_with`], as long as it `is_wanted`, which is asked between the steps; otherwise it is given up,
/// and there is none. Of a text of the greatest length a step takes about a second.
///
/// # Errors
/// As [`parse_with`].
pub fn parse_while(
    toml: &str,
    overrides: &[Override],
    is_wanted: &dyn Fn() -> bool,
) -> Result<Option<Scenario>, ScenarioError> {
    if toml.len() > MAX_BYTES {
        return Err(ScenarioError::TooLong { bytes: toml.len() as u64 });
    }
    let Some((mut table, mut order)) = read(toml, is_wanted).map_err(|error| syntax(&error))? else {
        return Ok(None);
    };
    for change in overrides {
        change.apply(&mut table)?;
    }
    let presets = preset::expand(&mut table)?;
    if !is_wanted() {
        return Ok(None);
    }
    let mut raw: raw::Scenario = Sheet::from(table).read(&Path::root())?;
    if !is_wanted() {
        return Ok(None);
    }
    for (robot, chain) in raw.robots.iter_mut().zip(&presets) {
        let names = order.next(chain);
        robot.sensors.arrange(&names.sensors);
        robot.actuators.arrange(&names.actuators);
    }
    let overrides = overrides.iter().map(ToString::to_string).collect();
    Ok(Some(build::scenario(raw, Source { toml: toml.into(), overrides })?))
}

/// The values of a text and their order. It is parsed once: of a long text that is much work, and much memory.
fn read(
    toml: &str,
    is_wanted: &dyn Fn() -> bool,
) -> Result<Option<(toml::Table, order::Order)>, toml::de::Error> {
    let document = DeTable::parse(toml)?;
    if !is_wanted() {
        return Ok(None);
    }
    let order = order::Order::of(document.get_ref());
    let table = toml::Table::deserialize(toml::Deserializer::from(document));
    let table = table.map_err(|mut error| {
        error.set_input(Some(toml));
        error
    })?;
    Ok(Some((table, order)))
}

/// The error with a picture of the line that is wrong, unless that is too long to read.
fn syntax(error: &toml::de::Error) -> ScenarioError {
    let text = PrintableLines(error).to_string();
    if text.lines().all(|line| line.len() <= MAX_SHOWN) {
        return ScenarioError::Syntax(text);
    }
    let place = text.lines().next().filter(|line| line.len() <= MAX_SHOWN).unwrap_or("TOML parse error");
    let message: String = error.message().chars().take(MAX_SHOWN).collect();
    ScenarioError::Syntax(alloc::format!("{place}: {}", PrintableLines(message)))
}

/// Bytes of the longest line that an error shows.
const MAX_SHOWN: usize = 400;
