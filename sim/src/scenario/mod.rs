//! Scenario files: TOML in, a [`Scenario`] out in which nothing can be wrong.
//!
//! `raw` says what a file may contain, with the parts that have a file of their own; `build`, `robots` and the others
//! turn that into the world's own types and refuse what makes no sense; `check` has the rules for single values,
//! `overrides` changes a file's fields by path, `preset` then puts presets in place, and `order` finds the order that
//! sensors stand in. `docs/scenario.md` describes the format to its users.

mod actuators;
mod arena;
mod build;
mod cable;
mod check;
mod error;
mod faults;
mod link;
mod motors;
mod noise;
mod order;
mod overrides;
mod preset;
mod raw;
mod robots;
mod sensors;
mod starts;
mod things;
mod warnings;

use alloc::string::{String, ToString};
use alloc::sync::Arc;
use alloc::vec::Vec;

use baudbot_geometry::Circle;
use serde::Deserialize;
use toml::de::DeTable;

pub use error::ScenarioError;
pub use overrides::Override;
pub use warnings::Warning;

use crate::arena::Arena;
use crate::collision::CollisionPolicy;
use crate::movable::Movable;
use crate::mover::Mover;
use crate::printable::PrintableLines;
use crate::referee::Rules;
use crate::robot::RobotSpec;
use crate::surroundings::Surroundings;
use crate::time::SimTime;

/// Longest scenario that is read, in bytes.
pub const MAX_BYTES: usize = 16 << 20;

/// A scenario: an arena, robots, and the rules of the run. Made by parsing only, so it is always sound.
#[derive(Clone, Debug)]
pub struct Scenario {
    source: Source,
    pub(crate) name: String,
    pub(crate) description: String,
    pub(crate) seed: u64,
    pub(crate) step_ns: u64,
    pub(crate) substeps: u32,
    pub(crate) noise: bool,
    pub(crate) collision: CollisionPolicy,
    pub(crate) end: End,
    pub(crate) rules: Rules,
    pub(crate) arena: Arena,
    pub(crate) surroundings: Surroundings,
    pub(crate) movers: Vec<Mover>,
    pub(crate) movables: Vec<Movable>,
    robots: Vec<RobotSpec>,
}

/// What a scenario was parsed from: parsing it again gives the same scenario.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The text of the file.
    pub toml: Arc<str>,
    /// The overrides, as texts.
    pub overrides: Vec<String>,
}

/// When a run ends, collisions aside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct End {
    /// After this time.
    pub after: Option<SimTime>,
    /// When the centre of any robot is in this disc.
    pub goal: Option<Circle>,
}

impl Scenario {
    /// Reads a scenario.
    ///
    /// # Errors
    /// Says where the text is not TOML, or which field is wrong, and how.
    pub fn parse(toml: &str) -> Result<Self, ScenarioError> {
        Self::parse_with(toml, &[])
    }

    /// Reads a scenario with some of its fields changed.
    ///
    /// # Errors
    /// As [`parse`](Self::parse); also if an override's path leads nowhere.
    pub fn parse_with(toml: &str, overrides: &[Override]) -> Result<Self, ScenarioError> {
        if toml.len() > MAX_BYTES {
            return Err(ScenarioError::TooLong { bytes: toml.len() as u64 });
        }
        let (mut table, mut order) = read(toml).map_err(|error| syntax(&error))?;
        for change in overrides {
            change.apply(&mut table)?;
        }
        let presets = preset::expand(&mut table)?;
        let mut raw: raw::Scenario = error::deserialize("", toml::Value::Table(table))?;
        for (robot, chain) in raw.robots.iter_mut().zip(&presets) {
            let names = order.next(chain);
            robot.sensors.arrange(&names.sensors);
            robot.actuators.arrange(&names.actuators);
        }
        let overrides = overrides.iter().map(ToString::to_string).collect();
        build::scenario(raw, Source { toml: toml.into(), overrides })
    }

    /// What it was parsed from. What has been changed by hand since is not in there.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// A short name; empty if the file gives none.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What the scenario is about, for people.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// Seed of all random streams.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Length of a tick Δt, in nanoseconds.
    pub fn step_ns(&self) -> u64 {
        self.step_ns
    }

    /// Euler steps of the bodies in a tick.
    pub fn substeps(&self) -> u32 {
        self.substeps
    }

    /// Whether sensors and motors are noisy; byte errors on the link are not noise in this sense and stay.
    pub fn noise(&self) -> bool {
        self.noise
    }

    /// What a collision does.
    pub fn collision(&self) -> CollisionPolicy {
        self.collision
    }

    /// When the run ends.
    pub fn end(&self) -> &End {
        &self.end
    }

    /// All that stands still.
    pub fn arena(&self) -> &Arena {
        &self.arena
    }

    /// Zones, lights and fields.
    pub fn surroundings(&self) -> &Surroundings {
        &self.surroundings
    }

    /// What moves by itself.
    pub fn movers(&self) -> &[Mover] {
        &self.movers
    }

    /// What robots can push.
    pub fn movables(&self) -> &[Movable] {
        &self.movables
    }

    /// What the referee looks at.
    pub fn rules(&self) -> &Rules {
        &self.rules
    }

    pub(crate) fn robots_mut(&mut self) -> &mut [RobotSpec] {
        &mut self.robots
    }

    /// The robots in the order of their names, whatever their order in the file.
    pub fn robots(&self) -> &[RobotSpec] {
        &self.robots
    }
}

/// What the text says, and in which order. It is parsed once: of a long text that is much work, and much memory.
fn read(toml: &str) -> Result<(toml::Table, order::Order), toml::de::Error> {
    let document = DeTable::parse(toml)?;
    let order = order::Order::of(document.get_ref());
    let table = toml::Table::deserialize(toml::Deserializer::from(document));
    let table = table.map_err(|mut error| {
        error.set_input(Some(toml));
        error
    })?;
    Ok((table, order))
}

/// With a picture of the line that is wrong, unless that is too long to be looked at.
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
