//! The description of a world before its first tick.

use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;

use baudbot_fields::endpoint::Endpoint;
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
    /// The scenario's source, without manual changes that were made since.
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
    /// The consequence of a collision.
    pub collision: CollisionPolicy,
    /// The conditions for the end of the run.
    pub end: End,
    /// The rules that the referee applies.
    pub rules: Rules,
    /// Everything that stands still.
    pub arena: Arc<Arena>,
    /// Zones, lights and fields.
    pub surroundings: Surroundings,
    /// Things that move by themselves.
    pub movers: Vec<Mover>,
    /// Things that robots can push.
    pub movables: Vec<Movable>,
    /// The robots in the order of their names, whatever their order in the file.
    pub robots: Vec<RobotSpec>,
    /// Serial ports that a server is to open at their cables for programs.
    pub serial_ports: Vec<SerialPort>,
}

/// A serial port at a robot's cable, and where programs find it. Nothing in the world depends on it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SerialPort {
    /// Name of the robot.
    pub robot: String,
    /// The sensor whose own cable it is; none for the microcontroller's.
    pub sensor: Option<String>,
    /// The place.
    pub endpoint: Endpoint,
}

/// The source of a scenario: parsing it again gives the same scenario.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The text of the file.
    pub toml: Arc<str>,
    /// The overrides, as texts.
    pub overrides: Vec<String>,
}

/// The conditions for the end of a run, collisions aside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct End {
    /// The run ends after this time.
    pub after: Option<SimTime>,
    /// The disc that ends the run once the centre of any robot is in it.
    pub goal: Option<Circle>,
}
