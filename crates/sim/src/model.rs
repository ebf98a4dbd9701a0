//! The description of a robot before it moves: its parts, its start, and its faults.

use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::ops::Deref;

pub use baudbot_fields::{Frequency, NoWrites, Writes};
use baudbot_geometry::{Point, Pose};

use crate::actuator::Actuator;
use crate::arena::Look;
use crate::battery::Battery;
use crate::chip::ChipSpec;
use crate::drive::Drive;
use crate::fault::{Fault, FaultEffect, FaultKind, When};
use crate::firmware::Firmware;
use crate::link::Link;
use crate::movable::Form;
pub use crate::port_use::PortUse;
use crate::processor::Processor;
use crate::sensor::Sensors;
use crate::surroundings::Region;
use crate::time::SimTime;

/// A robot of a scenario: its name, where it starts, and what it is.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotSpec {
    /// Unique in its world.
    pub name: String,
    /// The name of the scenario's table that it stands in together with others, if there are `starts` in that.
    pub group: Option<Arc<str>>,
    /// The place and the manner of its start.
    pub start: Start,
    /// The model. Robots that are alike share it: a crowd of them needs little memory, and little of it is looked at.
    pub model: Arc<RobotModel>,
    /// Who reads its laptop's serial ports ([`Intervention::OpenPort`](crate::Intervention::OpenPort)). Scenarios begin with
    /// [`PortUse::Closed`].
    pub port_use: PortUse,
}

/// A robot is what its model is, so that `robot.link` is `robot.model.link`.
impl Deref for RobotSpec {
    type Target = RobotModel;

    fn deref(&self) -> &RobotModel {
        &self.model
    }
}

/// The model of a robot, without its name and its start.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotModel {
    /// Body, wheels and motors.
    pub drive: Drive,
    /// Corners of the body in the robot's frame, in metres; none if it is a disc. The collision geometry of §3.2.5.
    pub outline: Vec<Point>,
    /// Its height and its colour.
    pub look: Look,
    /// What stands on it or sticks out of it, such as a mast: seen by others' sensors, and in no contact.
    pub parts: Vec<Part>,
    /// Largest motor signal that a brain may ask for; `None` means any, as in ARSim.
    pub signal_limit: Option<f64>,
    /// Actuators besides the wheels, in the order of the wire.
    pub actuators: Vec<Actuator>,
    /// The battery, if that can run out.
    pub battery: Option<Battery>,
    /// Motors stand still if no command comes for so long, in nanoseconds.
    pub command_timeout_ns: Option<u64>,
    /// The delay from the microcontroller's obedience until commands reach the motors, in nanoseconds. Other
    /// actuators are not delayed.
    pub dead_time_ns: u64,
    /// Sensors. Models whose sensors are alike share them.
    pub sensors: Sensors,
    /// The cost of the microcontroller's tasks.
    pub processor: Processor,
    /// A program of the user's own on it, if there is one: then nothing is due by schedules, and no task has a cost.
    pub chip: Option<Arc<ChipSpec>>,
    /// The protocol on its wire.
    pub firmware: Firmware,
    /// The cable to the brain.
    pub link: Link,
    /// The thinking time of a brain that has no figure of its own, in nanoseconds.
    pub thinking_ns: u64,
    /// When its brain writes, if that is stated.
    pub writes: Option<Writes>,
    /// When its commands must be there.
    pub deadline: Deadline,
    /// Its faults.
    pub faults: Vec<Fault>,
    /// The number of operations of a brain on board, if the scenario has one.
    pub brain_operations: Option<u64>,
    /// Memory that a brain on board needs for its variables, in bytes, if the scenario says.
    pub brain_memory_bytes: Option<u64>,
}

/// A part of a body for sensing (§3.2.3).
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The outline in the robot's frame.
    pub outline: Region,
    /// From which height to which it reaches, and its colour.
    pub look: Look,
}

impl RobotModel {
    /// The time of a command on the cable by the rate of that alone, in nanoseconds: all that a brain knows of it. 0
    /// on a cable without a rate.
    pub fn command_time_ns(&self) -> u64 {
        match &self.link {
            Link::Ideal | Link::Onboard | Link::Usb(_) => 0,
            link @ Link::Uart(_) => link.burst_ns(self.firmware.command_len_max() as u64),
        }
    }
}

impl RobotSpec {
    /// The name of its table in the scenario, by which its fields can be changed.
    pub fn table_name(&self) -> &str {
        self.group.as_deref().unwrap_or(&self.name)
    }

    /// Whether its brain is the microcontroller's program: then nothing is framed and nothing received.
    pub fn is_onboard(&self) -> bool {
        matches!(self.link, Link::Onboard)
    }

    /// The fault of this sensor. One whose signal is lost cannot stick.
    #[inline]
    pub(crate) fn fault_effect(&self, sensor: usize, at: SimTime) -> Option<FaultEffect> {
        let of = |fault: &Fault| {
            let effect = match &fault.kind {
                FaultKind::Sensor { sensor: i, .. } if *i == sensor => FaultEffect::Sticks,
                FaultKind::LostSignal { sensor: i, .. } if *i == sensor => FaultEffect::Lost,
                FaultKind::Sensor { .. } | FaultKind::LostSignal { .. } => return None,
                FaultKind::Cable | FaultKind::ByteErrors { .. } | FaultKind::Brain => return None,
            };
            fault.when.until(at).map(|_| effect)
        };
        if self.faults.is_empty() {
            return None;
        }
        let all = || self.faults.iter().filter_map(of);
        all().find(|effect| *effect == FaultEffect::Lost).or_else(|| all().next())
    }

    /// From when on its brain does not stall, from `from` on and as far as `end`.
    pub(crate) fn awake_from(&self, from: SimTime, end: SimTime) -> SimTime {
        let mut from = from;
        while from < end
            && let Some(until) = self.stalls().filter_map(|when| when.until(from)).max()
        {
            from = until;
        }
        from
    }

    /// The faults that make its brain stall.
    pub(crate) fn stalls(&self) -> impl Iterator<Item = When> {
        self.faults.iter().filter(|fault| fault.kind == FaultKind::Brain).map(|fault| fault.when)
    }

    /// The shape of its body.
    pub fn form(&self) -> Form<'_> {
        Form::of(&self.outline, self.drive.radius_m)
    }
}

/// The place and the manner of a robot's start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// World from robot.
    pub pose: Pose,
    /// Speed along the heading, in m/s.
    pub speed_m_s: f64,
    /// In rad/s.
    pub turn_rate_rad_s: f64,
    /// The motors do not see the start speed in the first step: ARSim's quirk.
    pub wheels_at_rest: bool,
}

/// When a command must have answered the readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Deadline {
    /// After the cycle began, in nanoseconds. Δt if the scenario states none.
    pub within_ns: u64,
    /// The turn of a brain that is late; `None` if the scenario states no deadline: then lateness is only counted.
    pub on_late: Option<OnLate>,
}

/// The consequence when a cycle is not closed by its deadline.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum OnLate {
    /// The old command stays in force.
    #[default]
    Hold,
    /// The motors are switched off until the next command is obeyed.
    Stop,
    /// The run ends.
    End,
}
