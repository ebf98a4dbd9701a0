//! The fields of a scenario file, as they are written. Their comments are their descriptions in editors and in the manual, and say at their
//! end what type, default and range are where the code does not (`schema/text.rs`).

mod cable;
mod robot;

use alloc::string::String;
use alloc::vec::Vec;

use baudbot_fields::number::{Coordinate, Length, Millis, Number, Seconds, Share, Whole};

pub(super) use cable::{Adapter, AdapterKind, Depth, Firmware, Gap, Link, LinkKind, Mode, Outage, Protocol};
pub(super) use robot::{Body, Brain, Microcontroller, Robot, Start, Tables};

use super::arena::RawArena;
use super::context::{Lasting, MAX_SUBSTEPS, MIN_PERIOD_MS};

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct Scenario {
    /// Name of the scenario, on one line and without control characters. It is also the name of its world on a
    /// server; without it, the world has the file's name.
    #[serde(default)]
    pub(super) name: String,
    /// Description of the scenario, for people.
    #[serde(default)]
    pub(super) description: String,
    /// Seed of all random streams ([determinism](../explanation/determinism.md)). Range: 0 to 2^63 − 1.
    #[serde(default = "default::seed")]
    pub(super) seed: u64,
    /// Length of a tick Δt ([timing](../explanation/timing.md)).
    #[serde(default = "Number::<Step>::constant::<10>")]
    pub(super) step_ms: Number<Step>,
    /// Number of Euler steps of the bodies in a tick. They must divide the tick into whole nanoseconds.
    #[serde(default = "Substeps::constant::<1>")]
    pub(super) substeps: Substeps,
    /// Switches on the noise of sensors and motors. Byte errors of the link are not affected.
    #[serde(default = "default::yes")]
    pub(super) noise: bool,
    /// Effect of a collision: the robot slides along what it ran into, the robot stops, or the run ends.
    #[serde(default)]
    pub(super) collision: Collision,
    /// Coefficient of sliding friction between robots and what they slide along, other robots included. With 0
    /// robots slide freely; with `inf` they stop as with `stop-robot`. Default: 0.3, wood on wood. Range: not
    /// negative; only with `slide`.
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    pub(super) wall_friction: Option<f64>,
    /// Conditions that end the run. Default: none.
    #[serde(default)]
    pub(super) end: End,
    /// Measurement of area coverage. Default: none.
    #[serde(default)]
    pub(super) metrics: Metrics,
    /// Everything besides the robots. Default: empty.
    #[serde(default)]
    pub(super) arena: RawArena,
    /// The robots. Their order in the file has no effect. Range: at most 10,000 robots.
    #[cfg_attr(feature = "schema", schemars(length(max = 10_000)))]
    #[serde(default)]
    pub(super) robots: Vec<Robot>,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema, serde::Serialize))]
pub(super) enum Collision {
    #[default]
    Slide,
    StopRobot,
    StopRun,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct End {
    /// The run ends at the end of the first tick that ends at or after this time.
    pub(super) after_s: Option<Number<Seconds<Lasting>>>,
    /// The run ends when the centre of any robot is in this disc at the end of a tick.
    pub(super) goal: Option<Goal>,
    /// The run ends when all robots together have had this number of collisions.
    pub(super) collisions: Option<Number<Whole<1, { u64::MAX }>>>,
    /// The run ends when every zone that is a goal has had a robot's centre in it. Range: needs a zone with
    /// `goal`.
    #[serde(default)]
    pub(super) all_goals: bool,
    /// The run ends when this fraction of the free floor is covered. Range: needs `metrics.cell_m`.
    pub(super) covered: Option<Number<Share>>,
    /// The run ends when this fraction of the free floor is sensed. Range: needs `metrics.sensed_by`.
    pub(super) sensed: Option<Number<Share>>,
    /// The run ends when any battery is empty. Range: needs a robot with a battery.
    #[serde(default)]
    pub(super) battery_empty: bool,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct Metrics {
    /// Side of a cell. Without it, coverage is not measured. Walls must enclose the robots. Range: at most 4,000,000
    /// cells.
    pub(super) cell_m: Option<Number<Length>>,
    /// The sensor whose rays are counted, on each robot that has one of this name. Range: name of a sensor with
    /// rays and a range; needs `cell_m`.
    pub(super) sensed_by: Option<String>,
    /// Interval at which the rays of `sensed_by` are cast, at the end of a tick. This takes time on your machine,
    /// but no simulated time. Default: 100.0.
    pub(super) sense_ms: Option<Number<Millis<Sensing>>>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct Goal {
    /// Centre of the disc.
    pub(super) x_m: Number<Coordinate>,
    /// Centre of the disc.
    pub(super) y_m: Number<Coordinate>,
    /// Radius of the disc.
    pub(super) radius_m: Number<Length>,
}

baudbot_fields::rules! {
    /// The length of a tick, in milliseconds.
    Step: Any, MIN_PERIOD_MS, 1e3;
    /// The period in which rays are counted, in milliseconds.
    Sensing: Any, MIN_PERIOD_MS, 1e6;
}

type Substeps = Number<Whole<1, MAX_SUBSTEPS, u32>>;

mod default {
    pub(super) fn seed() -> u64 {
        1
    }

    pub(super) fn yes() -> bool {
        true
    }
}
