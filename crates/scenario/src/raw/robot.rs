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
use crate::controls::RawOperation;
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
    /// Pose and speed at the start. The robot must not overlap anything there. Default: all zeros.
    pub(crate) start: Option<Start>,
    /// Starts of [several robots](#robotsstarts) that are otherwise identical, in place of `start`.
    pub(crate) starts: Option<Vec<Start>>,
    /// Body and wheels.
    pub(crate) body: Body,
    /// The [two motors](actuators.md#robotsmotors), which are identical. Default: ARSim's.
    #[cfg_attr(feature = "schema", schemars(with = "serde_json::Value"))]
    #[serde(default)]
    pub(crate) motors: toml::Table,
    /// [Turrets, lamps, speakers and dispensers](actuators.md#robotsactuatorsname) by name. Their order in the file is
    /// their order in a command. Default: none.
    #[cfg_attr(feature = "schema", schemars(with = "serde_json::Value"))]
    #[serde(default)]
    pub(crate) actuators: Tables,
    /// The [battery](actuators.md#robotsbattery). Without one, power cannot run out.
    pub(crate) battery: Option<Battery>,
    /// The [sensors](sensors.md) by name. Their order in the file is their order on the wire. Default: none.
    #[cfg_attr(feature = "schema", schemars(with = "serde_json::Value"))]
    #[serde(default)]
    pub(crate) sensors: Tables,
    /// Durations of the microcontroller's tasks, or [a program of your own](firmware.md) in place of them. Default:
    /// no time at all.
    #[serde(default)]
    pub(crate) microcontroller: Microcontroller,
    /// [Parts on the pins](firmware.md#pins) of the microcontroller, by the pin's name. Default: none.
    #[cfg_attr(feature = "schema", schemars(with = "serde_json::Value"))]
    #[serde(default)]
    pub(crate) pins: Pins,
    /// [Operations](#robotsoperations) of buttons, switches and potentiometers on the pins. Default: none. Range: at most 1000.
    #[cfg_attr(feature = "schema", schemars(length(max = 1000)))]
    #[serde(default)]
    pub(crate) operations: Vec<RawOperation>,
    /// Protocol of the microcontroller, and when it sends messages. Default: framed, streaming.
    #[serde(default)]
    pub(crate) firmware: Firmware,
    /// The cable to the brain, or none. Default: ideal.
    #[serde(default)]
    pub(crate) link: Link,
    /// Thinking time of the brain's steps that declare none, and the brain's deadline. Default: no time at all.
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
pub(crate) struct Part {
    /// Corners in the robot's frame; the outline must not cross itself. Type: list of `[x, y]`. Default: this or
    /// `radius_m`. Range: 3 to 4096 points; each −10^6 to 10^6.
    #[cfg_attr(feature = "schema", schemars(with = "Option<Corners>", length(min = 3, max = 4096)))]
    pub(crate) outline_m: Option<Vec<[f64; 2]>>,
    /// Radius of a disc. Default: this or `outline_m`.
    pub(crate) radius_m: Option<Number<Length>>,
    /// Centre of a disc, forwards of the robot's centre. Default: 0.0.
    pub(crate) x_m: Option<Number<Coordinate>>,
    /// Centre of a disc, to the left of the robot's centre. Default: 0.0.
    pub(crate) y_m: Option<Number<Coordinate>>,
    /// Height at which it begins. Default: the floor. Range: 10^−6 to `height_m`.
    pub(crate) lower_edge_m: Option<Number<Length>>,
    /// Height at which it ends. Default: unlimited.
    pub(crate) height_m: Option<Number<Length>>,
    /// Colour for cameras of other robots. Type: `[red, green, blue]`. Default: the body's. Range: each 0 to 255.
    pub(crate) color: Option<[u8; 3]>,
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
    /// Height of the body. Sensors of other robots that are mounted higher see over it. Default: unlimited.
    pub(crate) height_m: Option<Number<Length>>,
    /// Colour of the body for cameras of other robots. Type: `[red, green, blue]`. Default: `[128, 128, 128]`. Range:
    /// each 0 to 255.
    pub(crate) color: Option<[u8; 3]>,
    /// Parts of the body that sensors of other robots see: `[[robots.body.parts]]`. Default: none. Range: at most 64,
    /// with 4096 corners together.
    #[serde(default)]
    pub(crate) parts: Vec<Part>,
    /// Mass M of Eq. (2.31).
    pub(crate) mass_kg: Number<Positive>,
    /// Moment of inertia about the vertical axis, Eq. (2.32).
    pub(crate) inertia_kg_m2: Number<Positive>,
    /// Radius of a wheel, r of Eq. (2.1).
    pub(crate) wheel_radius_m: Number<Length>,
    /// Half the distance between the wheels, R of Eqs. (2.2) and (2.3). Default: `radius_m`, or that of the
    /// disc around the outline.
    pub(crate) half_track_m: Option<Number<Length>>,
    /// E_d: diameter of the right wheel divided by that of the left wheel. See
    /// [below](#robots-that-differ-from-their-data-sheet). Default: 1.0.
    pub(crate) wheel_ratio: Option<Number<Deviation>>,
    /// E_s: mean diameter of the two wheels, as a multiple of the data sheet's. Default: 1.0.
    pub(crate) wheel_scale: Option<Number<Deviation>>,
    /// E_b: distance between the wheels (wheelbase), as a multiple of the data sheet's. Default: 1.0.
    pub(crate) track_ratio: Option<Number<Deviation>>,
    /// Mass of a wheel, m of Eqs. (2.26) and (2.30).
    #[serde(default)]
    pub(crate) wheel_mass_kg: Number<NotNegative>,
    /// Moment of inertia of a wheel about its axis, Eqs. (2.26) and (2.30).
    #[serde(default)]
    pub(crate) wheel_inertia_kg_m2: Number<NotNegative>,
    /// Damping of the speed, α of Eq. (2.31).
    #[serde(default)]
    pub(crate) damping_n_s_m: Number<NotNegative>,
    /// Damping of the turn rate, β of Eq. (2.32).
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
    /// Speed of the microcontroller with a brain on board, for `brain.operations`.
    pub(crate) operations_per_s: Option<Number<Between<1, 1_000_000_000_000>>>,
    /// Memory available to a brain, for `brain.memory_bytes`.
    pub(crate) ram_bytes: Option<u64>,
    /// Time from the start of the run until the firmware starts, as opening a serial port resets the chip of
    /// many boards ([timing](../explanation/timing.md#a-chip-that-is-reset)). Range: not on board.
    pub(crate) bootloader_s: Number<Seconds<Between<0, 60>>>,
    /// The chip that runs `program`. Default: `"atmega328p"`.
    pub(crate) chip: Option<String>,
    /// Nominal frequency of the chip's clock source. Default: 16 × 10^6. Range: whole.
    pub(crate) clock_hz: Option<Number<Between<32_000, 32_000_000>>>,
    /// Deviation of the clock from `clock_hz` in parts per million, positive if it is fast: about 50 for a crystal,
    /// 5000 for a resonator. Default: 0.0.
    pub(crate) clock_ppm: Option<Number<Between<-100_000, 100_000>>>,
    /// The fuse bytes low, high and extended. Default: those of an ELF file; else an external clock and no boot
    /// section. Range: 3 bytes, each 0 to 255.
    #[cfg_attr(feature = "schema", schemars(inner(range(max = 255)), length(equal = 3)))]
    pub(crate) fuses: Option<Vec<u64>>,
    /// The program that runs on the chip, as [a file](#program). It replaces the modelled firmware: of the fields
    /// for durations only `bootloader_s` still has an effect.
    pub(crate) program: Option<RawProgram>,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Brain {
    /// Simulated thinking time of a brain's step that does not declare its own. Real and scaled time use the
    /// wall clock's instead. Default: 0.0.
    pub(crate) thinking_us: Option<Number<Micros<Between<0, 1_000_000_000>>>>,
    /// Thinking time in operations of the microcontroller: a step takes `operations` / `operations_per_s`, at most
    /// 1000 s. Range: only on board, not with `thinking_us`; needs `microcontroller.operations_per_s`.
    pub(crate) operations: Option<u64>,
    /// Memory that the brain needs; more than `microcontroller.ram_bytes` is refused. Range: only on board.
    pub(crate) memory_bytes: Option<u64>,
    /// Time after [the start of its cycle](../explanation/timing.md#control-cycles) by which a command must have
    /// taken effect. Without it the limit is Δt, and a late command has no consequences.
    pub(crate) deadline_ms: Option<Number<Millis<DeadlineMs>>>,
    /// Consequence of a missed deadline, whether the command comes late or never: the old command stays in effect,
    /// the motors are switched off until the next command is obeyed, or the run ends. The motors' [dead
    /// time](actuators.md#robotsmotors) delays the consequence as it delays commands. Default: `"hold"`. Range:
    /// only with `deadline_ms`.
    pub(crate) on_late: Option<OnLate>,
    /// [When the brain writes commands](../explanation/timing.md#when-a-brain-writes): in answer to each message only
    /// (`"on-message"`); once a tick, but not before the last command is off the cable (`"when-free"`); once a tick
    /// (`"every-tick"`); up to a number per second (`"10-per-s"`). `baudbot budget` assumes this, and runs count
    /// deviations from it. Default: what the brain declares, or `"on-message"`.
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
