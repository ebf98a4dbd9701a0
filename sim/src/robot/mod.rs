//! A robot: what it is, and the state it is in.
//!
//! What happens on it within a tick is in `advance`, what its control cycles are in `cycles`.

mod advance;
mod cycles;
mod onboard;
mod recorder;

use alloc::format;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::ops::Deref;

use baudbot_geometry::{Point, Pose};
use serde::{Deserialize, Serialize};

pub use cycles::{Cycles, Deadline, OnLate};
pub(crate) use recorder::Recorder;

use crate::actuator::{Actuator, ActuatorState};
use crate::arena::Look;
use crate::battery::{Battery, BatteryState};
use crate::collision::Partner;
use crate::drive::{Drive, Motion, Wheels};
use crate::fault::{Amiss, Fault, FaultKind, When};
use crate::firmware::Firmware;
use crate::laptop::Laptop;
use crate::link::{Direction, Line, Link};
use crate::microcontroller::{Microcontroller, Processor};
use crate::motor::NoiseState;
use crate::movable::Form;
use crate::port::PortState;
use crate::random::Stream;
use crate::scene::{Ping, Scene};
use crate::sensor::Sensors;
use crate::time::SimTime;

/// A robot of a scenario: its name, where it starts, and what it is.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotSpec {
    /// Unique in its world.
    pub name: String,
    /// The name of the scenario's table that it stands in together with others, if there are `starts` in that.
    pub group: Option<Arc<str>>,
    /// Where and how it starts.
    pub start: Start,
    /// What it is. Robots that are alike share it: a crowd of them needs little memory, and little of it is looked at.
    pub model: Arc<RobotModel>,
}

/// A robot is what its model is, so that `robot.link` is `robot.model.link`.
impl Deref for RobotSpec {
    type Target = RobotModel;

    fn deref(&self) -> &RobotModel {
        &self.model
    }
}

/// What a robot is, whatever its name and wherever it starts.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotModel {
    /// Body, wheels and motors.
    pub drive: Drive,
    /// Corners of the body in the robot's frame, in metres; none if it is a disc. The collision geometry of §3.2.5.
    pub outline: Vec<Point>,
    /// What it looks like from the side.
    pub look: Look,
    /// Largest motor signal that a brain may ask for; `None` means any, as in ARSim.
    pub signal_limit: Option<f64>,
    /// Actuators besides the wheels, in the order of the wire.
    pub actuators: Vec<Actuator>,
    /// What feeds it, if that can run out.
    pub battery: Option<Battery>,
    /// How full that is at the start, in [0, 1].
    pub charge: f64,
    /// Motors stand still if no command comes for so long, in nanoseconds.
    pub command_timeout_ns: Option<u64>,
    /// Sensors. Models whose sensors are alike share them.
    pub sensors: Sensors,
    /// What the microcontroller's tasks cost.
    pub processor: Processor,
    /// What it says on its wire.
    pub firmware: Firmware,
    /// The cable to the brain.
    pub link: Link,
    /// How long a brain thinks that does not say, in nanoseconds.
    pub thinking_ns: u64,
    /// When its commands must be there.
    pub deadline: Deadline,
    /// What goes wrong on it.
    pub faults: Vec<Fault>,
    /// How many operations a brain on board thinks, if the scenario says it so.
    pub brain_operations: Option<u64>,
    /// Memory that a brain on board needs for its variables, in bytes, if the scenario says.
    pub brain_memory_bytes: Option<u64>,
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

    /// What is wrong with this sensor. One whose signal is lost cannot stick.
    pub(crate) fn amiss(&self, sensor: usize, at: SimTime) -> Option<Amiss> {
        let of = |fault: &Fault| {
            let amiss = match &fault.kind {
                FaultKind::Sensor { sensor: i, .. } if *i == sensor => Amiss::Sticks,
                FaultKind::LostSignal { sensor: i, .. } if *i == sensor => Amiss::Lost,
                FaultKind::Sensor { .. } | FaultKind::LostSignal { .. } => return None,
                FaultKind::Cable | FaultKind::ByteErrors { .. } | FaultKind::Brain => return None,
            };
            fault.when.until(at).map(|_| amiss)
        };
        let all = || self.faults.iter().filter_map(of);
        all().find(|amiss| *amiss == Amiss::Lost).or_else(|| all().next())
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

/// Where and how a robot starts.
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

/// The state of a robot.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Robot {
    pub(crate) motion: Motion,
    /// The motor signals in force.
    pub(crate) signals: Wheels,
    pub(crate) motor_noise: NoiseState,
    /// Ran into something in the last tick.
    pub(crate) collided: bool,
    /// What it ran into since there was last some room around it.
    pub(crate) contacts: Vec<Partner>,
    pub(crate) microcontroller: Microcontroller,
    pub(crate) uplink: Line,
    pub(crate) downlink: Line,
    pub(crate) laptop: Laptop,
    /// The cables of the sensors that have their own, in their order.
    pub(crate) ports: Vec<PortState>,
    pub(crate) actuators: Vec<ActuatorState>,
    pub(crate) battery: Option<BatteryState>,
    /// The pulse that it sent in this tick, and the one that others hear, which is of the last tick.
    pub(crate) pings: [Option<Ping>; 2],
    /// When the last command was obeyed.
    pub(crate) commanded_at: SimTime,
    pub(crate) counters: RobotCounters,
    pub(crate) cycles: Cycles,
    #[serde(skip)]
    pub(crate) recorder: Recorder,
    /// Memory of a message that is over, for the next one.
    #[serde(skip)]
    spare: Vec<(usize, SimTime)>,
}

/// The tick in which a robot is advanced, with the scene as it is at its start.
#[derive(Clone, Copy)]
pub(crate) struct Moment<'a> {
    pub(crate) scene: &'a Scene<'a>,
    /// Whether sensors are noisy.
    pub(crate) noise: bool,
    pub(crate) start: SimTime,
    pub(crate) end: SimTime,
}

/// What happened to a robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RobotCounters {
    /// Times that it ran into something.
    pub collisions: u64,
    /// Way of its centre, in metres, forwards and backwards added.
    pub distance_m: f64,
    /// Steps that its brain could take.
    pub turns: u64,
}

impl Robot {
    pub(crate) fn new(spec: &RobotSpec, seed: u64, noise: bool) -> Self {
        let name = |part: &str| format!("{}/{part}", spec.name);
        let Start { pose, speed_m_s, turn_rate_rad_s, wheels_at_rest } = spec.start;
        let mut motion = spec.drive.place(pose, speed_m_s, turn_rate_rad_s);
        if wheels_at_rest {
            motion.wheel_speed_rad_s = Wheels::default();
        }
        Self {
            motion,
            signals: Wheels::default(),
            motor_noise: NoiseState::new(&spec.drive.motor_noise, Stream::new(seed, &name("motors:noise"))),
            collided: false,
            contacts: Vec::new(),
            microcontroller: Microcontroller::new(spec, seed, noise),
            uplink: Line::up(&spec.link, seed, &name("link:up")),
            downlink: Line::down(&spec.link, seed, &name("link:down")),
            laptop: Laptop::new(spec.sensors.len(), &spec.firmware),
            ports: spec
                .sensors
                .ports()
                .iter()
                .map(|&i| PortState::new(&spec.sensors[i], seed, &spec.name))
                .collect(),
            actuators: spec.actuators.iter().map(|_| ActuatorState::default()).collect(),
            battery: spec.battery.as_ref().map(|battery| battery.charged_to(spec.charge)),
            pings: [None; 2],
            commanded_at: SimTime::ZERO,
            counters: RobotCounters::default(),
            cycles: Cycles::default(),
            recorder: Recorder::default(),
            spare: Vec::new(),
        }
    }

    /// Somebody puts it somewhere else.
    pub(crate) fn put_down(&mut self, spec: &RobotSpec, pose: Pose) {
        self.motion.pose = pose;
        self.motion.turn_rate_rad_s = 0.0;
        self.motion.acceleration_m_s2 = 0.0;
        spec.drive.halt(&mut self.motion);
        self.contacts.clear();
        self.collided = false;
    }

    /// The cable to its brain is one that can be out.
    pub(crate) fn watch_outages(&mut self, link: &Link, seed: u64, name: &str) {
        self.uplink.watch_outages(link, seed, &format!("{name}/link:up"), Direction::Up);
        self.downlink.watch_outages(link, seed, &format!("{name}/link:down"), Direction::Down);
    }

    /// The cable to its brain has another rate from now on.
    pub(crate) fn begin_bursts(&mut self) {
        self.uplink.begin_burst();
        self.downlink.begin_burst();
    }
}
