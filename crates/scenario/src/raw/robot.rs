//! The fields of a robot, but for those of its cable.

use alloc::collections::BTreeMap;
use alloc::string::String;
use alloc::vec::Vec;

use baudbot_fields::number::{
    Between, Coordinate, Length, Micros, Millis, NotNegative, Number, Positive, Seconds,
};
use baudbot_sim::battery::Battery;
use baudbot_sim::model::OnLate;

use super::cable::{Firmware, Link};
use crate::faults::RawFault;
use crate::on_pin::{Pins, RawProgram};
#[cfg(feature = "schema")]
use crate::shapes::Corners;

/// What motors may contain depends on their kind, so they are kept as a table until it is known.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Robot {
    /// Unique among the robots, see [names](#names). Random streams are named after it.
    pub(crate) name: String,
    /// Pose and speed at the start. It must not stand in anything. Default: all zeros.
    pub(crate) start: Option<Start>,
    /// Instead of `start`: [a robot at each of these](#robotsstarts), otherwise identical.
    pub(crate) starts: Option<Vec<Start>>,
    /// Body and wheels.
    pub(crate) body: Body,
    /// The [two motors](actuators.md#robotsmotors), which are identical. Default: ARSim's.
    #[cfg_attr(feature = "schema", schemars(with = "serde_json::Value"))]
    #[serde(default)]
    pub(crate) motors: toml::Table,
    /// [Turrets, lamps and speakers](actuators.md#robotsactuatorsname) by name. Their order in the file is
    /// their order in a command. Default: none.
    #[cfg_attr(feature = "schema", schemars(with = "serde_json::Value"))]
    #[serde(default)]
    pub(crate) actuators: Tables,
    /// The [battery](actuators.md#robotsbattery), if power can run out.
    pub(crate) battery: Option<Battery>,
    /// The [sensors](sensors.md) by name. Their order in the file is their order on the wire. Default: none.
    #[cfg_attr(feature = "schema", schemars(with = "serde_json::Value"))]
    #[serde(default)]
    pub(crate) sensors: Tables,
    /// Duration of the microcontroller's tasks, or [a program of your own](firmware.md) in place of them.
    /// Default: no time at all.
    #[serde(default)]
    pub(crate) microcontroller: Microcontroller,
    /// [What is on the pins](firmware.md#pins) of the microcontroller, by the pin's name. Default: none.
    #[cfg_attr(feature = "schema", schemars(with = "serde_json::Value"))]
    #[serde(default)]
    pub(crate) pins: Pins,
    /// Its messages on the wire, and when it sends them. Default: framed, streaming.
    #[serde(default)]
    pub(crate) firmware: Firmware,
    /// The cable to the brain, or none. Default: ideal.
    #[serde(default)]
    pub(crate) link: Link,
    /// Duration of a brain's step that declares none, and its deadline. Default: no time at all.
    #[serde(default)]
    pub(crate) brain: Brain,
    /// [Faults](#robotsfaults). Default: none. Range: at most 64 faults.
    #[cfg_attr(feature = "schema", schemars(length(max = 64)))]
    #[serde(default)]
    pub(crate) faults: Vec<RawFault>,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Start {
    /// Position of the body's centre.
    #[serde(default)]
    pub(crate) x_m: Number<Coordinate>,
    /// Position of the body's centre.
    #[serde(default)]
    pub(crate) y_m: Number<Coordinate>,
    /// Heading; whole turns are removed.
    #[serde(default)]
    pub(crate) heading_rad: Number<Between<-1000, 1000>>,
    /// Speed along the heading.
    #[serde(default)]
    pub(crate) speed_m_s: Number<Between<-1000, 1000>>,
    /// Turn rate, positive to the left.
    #[serde(default)]
    pub(crate) turn_rate_rad_s: Number<Between<-1000, 1000>>,
    /// ARSim's quirk: the motors do not see the start speed in the first step.
    #[serde(default)]
    pub(crate) wheels_at_rest: bool,
    /// Name of the robot that starts here. Default: the table's, and a number. Range: see [names](#names); only
    /// in `starts`.
    pub(crate) name: Option<String>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Body {
    /// Radius of a round body. Default: this or `outline_m`.
    pub(crate) radius_m: Option<Number<Length>>,
    /// Corners of the body in the robot's frame: the collision geometry of §3.2.5. The robot's centre, (0, 0)
    /// between the wheels, lies inside, and the outline must not cross itself. Type: list of `[x, y]`. Default:
    /// this or `radius_m`. Range: 3 to 4096 points; each −10^6 to 10^6.
    #[cfg_attr(feature = "schema", schemars(with = "Option<Corners>", length(min = 3, max = 4096)))]
    pub(crate) outline_m: Option<Vec<[f64; 2]>>,
    /// Sensors of other robots that are mounted higher see over it. Default: unlimited.
    pub(crate) height_m: Option<Number<Length>>,
    /// Its colour for cameras of other robots. Type: `[red, green, blue]`. Default: `[128, 128, 128]`. Range:
    /// each 0 to 255.
    pub(crate) color: Option<[u8; 3]>,
    /// M of Eq. (2.31).
    pub(crate) mass_kg: Number<Positive>,
    /// Moment of inertia about the vertical axis, Eq. (2.32).
    pub(crate) inertia_kg_m2: Number<Positive>,
    /// r of Eq. (2.1).
    pub(crate) wheel_radius_m: Number<Length>,
    /// Half the distance between the wheels, R of Eqs. (2.2) and (2.3). Default: `radius_m`, or that of the
    /// disc around the outline.
    pub(crate) half_track_m: Option<Number<Length>>,
    /// E_d: diameter of the right wheel by that of the left one. See
    /// [below](#robots-that-differ-from-their-data-sheet). Default: 1.0.
    pub(crate) wheel_ratio: Option<Number<Deviation>>,
    /// E_s: mean diameter of the two wheels, as a multiple of the data sheet's. Default: 1.0.
    pub(crate) wheel_scale: Option<Number<Deviation>>,
    /// E_b: distance between the wheels (wheelbase), as a multiple of the data sheet's. Default: 1.0.
    pub(crate) track_ratio: Option<Number<Deviation>>,
    /// m of Eqs. (2.26) and (2.30).
    #[serde(default)]
    pub(crate) wheel_mass_kg: Number<NotNegative>,
    /// Moment of inertia of a wheel about its axis, Eqs. (2.26) and (2.30).
    #[serde(default)]
    pub(crate) wheel_inertia_kg_m2: Number<NotNegative>,
    /// α of Eq. (2.31).
    #[serde(default)]
    pub(crate) damping_n_s_m: Number<NotNegative>,
    /// β of Eq. (2.32).
    #[serde(default)]
    pub(crate) turn_damping_nm_s: Number<NotNegative>,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Microcontroller {
    /// Time to frame readings, for each byte that goes on the wire.
    pub(crate) framing_us_per_byte: Number<Micros<Between<0, 1_000_000>>>,
    /// Time to take a byte from the receiver.
    pub(crate) receiving_us_per_byte: Number<Micros<Between<0, 1_000_000>>>,
    /// Time to obey a command once its last byte is taken.
    pub(crate) obeying_us: Number<Micros<Between<0, 1_000_000>>>,
    /// Its speed with a brain on board, for `brain.operations`.
    pub(crate) operations_per_s: Option<Number<Between<1, 1_000_000_000_000>>>,
    /// Memory available to a brain, for `brain.memory_bytes`.
    pub(crate) ram_bytes: Option<u64>,
    /// Time from the start of the run until the firmware starts, as opening a serial port resets the chip of
    /// many boards ([timing](../explanation/timing.md#a-chip-that-is-reset)). Range: not on board.
    pub(crate) bootloader_s: Number<Seconds<Between<0, 60>>>,
    /// The chip that runs `program`. Default: `"atmega328p"`.
    pub(crate) chip: Option<String>,
    /// The frequency of its clock source. Default: 16 × 10^6. Range: whole.
    pub(crate) clock_hz: Option<Number<Between<32_000, 32_000_000>>>,
    /// How much faster that is than it should be, in millionths: a crystal's 50, a resonator's 5000. Default:
    /// 0.0.
    pub(crate) clock_ppm: Option<Number<Between<-100_000, 100_000>>>,
    /// The fuse bytes low, high and extended. Default: those of an ELF file; else an external clock and no boot
    /// section. Range: 3 bytes, each 0 to 255.
    #[cfg_attr(feature = "schema", schemars(inner(range(max = 255)), length(equal = 3)))]
    pub(crate) fuses: Option<Vec<u64>>,
    /// The program that runs on it, as [a file](#program): the robot then does what the program says, and the
    /// other fields for durations have no meaning.
    pub(crate) program: Option<RawProgram>,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Brain {
    /// Simulated thinking time of a brain's step that does not declare its own. Real and scaled time use the
    /// wall clock's instead. Default: 0.0.
    pub(crate) thinking_us: Option<Number<Micros<Between<0, 1_000_000_000>>>>,
    /// The same in operations of the microcontroller, which takes `operations` / `operations_per_s` for a step,
    /// at most 1000 s. Range: only on board, not with `thinking_us`; needs `microcontroller.operations_per_s`.
    pub(crate) operations: Option<u64>,
    /// Memory that the brain needs; more than `microcontroller.ram_bytes` is refused. Range: only on board.
    pub(crate) memory_bytes: Option<u64>,
    /// Time after [the start of its cycle](../explanation/timing.md#control-cycles) by which a command must be
    /// there. Without it Δt counts, and a late command has no consequences.
    pub(crate) deadline_ms: Option<Number<Millis<DeadlineMs>>>,
    /// When a brain is late: the old command stays in force; the motors are off until the next command is
    /// obeyed; the run ends. The motors' [dead time](actuators.md#robotsmotors) delays that as it delays
    /// commands. Default: `"hold"`. Range: only with `deadline_ms`.
    pub(crate) on_late: Option<OnLate>,
    /// [When it writes commands](../explanation/timing.md#when-a-brain-writes), which `baudbot budget` goes by and runs count
    /// exceptions from: an answer to each message and no more (`"on-message"`); once a tick, but not before the last command is
    /// off the cable (`"when-free"`); once a tick (`"every-tick"`); up to so many commands a second (`"10-per-s"`). Default: what
    /// the brain says of itself, or `"on-message"`.
    pub(crate) writes: Option<String>,
}

baudbot_fields::rules! {
    /// A number of a robot over that of its data sheet: no wheel and no track is farther from it.
    Deviation: Any, 0.5, 2.0;
    /// A deadline, in milliseconds.
    DeadlineMs: Any, 0.01, 1e8;
}

/// A robot's sensors or actuators by name. What one may contain depends on its kind, so each is kept as a table
/// until its kind is known.
#[derive(Debug, Default, serde::Deserialize)]
#[serde(from = "BTreeMap<String, toml::Table>")]
pub(crate) struct Tables(pub(crate) Vec<(String, toml::Table)>);

impl From<BTreeMap<String, toml::Table>> for Tables {
    fn from(tables: BTreeMap<String, toml::Table>) -> Self {
        Self(tables.into_iter().collect())
    }
}

impl Tables {
    /// Puts them into the order of `names`; those that an override added come last.
    pub(crate) fn arrange(&mut self, names: &[String]) {
        self.0.sort_by_key(|(name, _)| names.iter().position(|other| other == name).unwrap_or(names.len()));
    }
}
