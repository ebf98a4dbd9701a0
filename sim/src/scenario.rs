//! What a world is made of, before its first tick.

use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;

use baudbot_geometry::Circle;

use crate::arena::Arena;
use crate::collision::CollisionPolicy;
use crate::model::RobotSpec;
use crate::movable::Movable;
use crate::mover::Mover;
use crate::rules::Rules;
use crate::surroundings::Surroundings;
use crate::time::SimTime;

/// A scenario: an arena, robots, and the rules of the run.
///
/// The parser of scenario files (`baudbot-scenario`) makes it and checks every value. A world takes a scenario as it is: in
/// one that is made or changed elsewhere, the ranges that the parser demands must hold.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// What it was parsed from. What has been changed by hand since is not in there.
    pub source: Source,
    /// A short name; empty if the file gives none.
    pub name: String,
    /// The scenario's description, for people.
    pub description: String,
    /// Seed of all random streams.
    pub seed: u64,
    /// Length of a tick Δt, in nanoseconds; a multiple of `substeps`.
    pub step_ns: u64,
    /// Euler steps of the bodies in a tick.
    pub substeps: u32,
    /// Whether sensors and motors are noisy; byte errors on the link are not noise in this sense and stay.
    pub noise: bool,
    /// What a collision does.
    pub collision: CollisionPolicy,
    /// When the run ends.
    pub end: End,
    /// What the referee looks at.
    pub rules: Rules,
    /// All that stands still.
    pub arena: Arena,
    /// Zones, lights and fields.
    pub surroundings: Surroundings,
    /// What moves by itself.
    pub movers: Vec<Mover>,
    /// What robots can push.
    pub movables: Vec<Movable>,
    /// The robots in the order of their names, whatever their order in the file.
    pub robots: Vec<RobotSpec>,
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
