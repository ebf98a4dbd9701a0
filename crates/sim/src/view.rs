//! Views of a robot: the truth for observers, and the readings that its brain may have.

use baudbot_geometry::{Circle, Point, Pose};
use baudbot_wire::meaning::Direction;

use crate::actuator::ActuatorState;
use crate::arena::Look;
use crate::battery::{Battery, BatteryState};
use crate::chip::{Board, Warning};
use crate::drive::{Motion, Wheels};
use crate::freshness::Freshness;
use crate::heard::Heard;
use crate::laptop::Reading;
use crate::link::{Cable, LineCounters, Tape};
use crate::model::RobotSpec;
use crate::movable::{Body, Form, Movable, MovableState};
use crate::mover::{Mover, MoverState};
use crate::robot::{Cycles, Robot, RobotCounters};
use crate::time::SimTime;
use crate::timeline::Timeline;

/// A look at one robot.
#[derive(Clone, Copy, Debug)]
pub struct RobotView<'a> {
    spec: &'a RobotSpec,
    state: &'a Robot,
}

/// The deeds and values of a sensor.
#[derive(Clone, Copy, Debug)]
pub struct SensorView<'a> {
    /// The last sample, before quantisation, one value a component; empty before the first.
    pub sample: &'a [f64],
    /// The instant at which it was taken.
    pub sampled_at: SimTime,
    /// Samples taken so far.
    pub samples: u64,
    /// Samples that fell due while the microcontroller was busy, and were left out.
    pub missed: u64,
    /// The freshness of its readings for the brain.
    pub freshness: &'a Freshness,
}

impl<'a> RobotView<'a> {
    pub(crate) fn new(spec: &'a RobotSpec, state: &'a Robot) -> Self {
        Self { spec, state }
    }

    /// The description of the robot.
    pub fn spec(&self) -> &'a RobotSpec {
        self.spec
    }

    /// The truth about its motion: for observers, never for its brain.
    pub fn motion(&self) -> &'a Motion {
        &self.state.motion
    }

    /// The motor signals in force in the last step.
    pub fn signals(&self) -> Wheels {
        self.state.motor_signals()
    }

    /// The robot's actuators besides the wheels.
    pub fn actuators(&self) -> &'a [ActuatorState] {
        &self.state.actuators
    }

    /// The robot's battery, and the charge of that, if it can run out.
    pub fn battery(&self) -> Option<(&'a Battery, &'a BatteryState)> {
        self.spec.battery.as_ref().zip(self.state.parts.battery.as_ref())
    }

    /// The currents in the windings of its DC motors, in A, if these have an inductance.
    pub fn currents_a(&self) -> Option<&'a Wheels> {
        self.state.parts.currents_a.as_ref()
    }

    /// For the brain: the bytes that arrived since its last step on the cable of a sensor's own, by the sensor's
    /// place.
    pub fn unread_of_ports(&self) -> impl Iterator<Item = (usize, &'a [u8])> {
        self.spec.sensors.ports().iter().zip(&self.state.ports).map(|(&i, port)| (i, port.unread.as_slice()))
    }

    /// The line of a sensor's own cable, by the sensor's place.
    pub fn port(&self, sensor: usize) -> Option<&'a LineCounters> {
        let place = self.spec.sensors.ports().iter().position(|&i| i == sensor)?;
        Some(&self.state.ports[place].line.counters)
    }

    /// The board of a robot whose microcontroller runs a program of the user's own.
    pub fn board(&self) -> Option<&'a Board> {
        self.state.parts.chip.as_ref().map(|chip| chip.board())
    }

    /// The acts of that program or the wiring that are hardly meant, each with its first instant.
    pub fn board_warnings(&self) -> impl Iterator<Item = (SimTime, &'a Warning)> {
        let chip = self.state.parts.chip.as_deref();
        chip.into_iter().flat_map(|chip| {
            chip.board().warnings().iter().map(|warning| (chip.world(warning.first_ns), warning))
        })
    }

    /// Whether it ran into something in the last tick.
    pub fn collided(&self) -> bool {
        self.state.collided
    }

    /// The bytes for the brain that arrived at its port since its last step.
    pub fn unread(&self) -> &'a [u8] {
        &self.state.laptop.unread
    }

    /// The instant at which each of the [unread](Self::unread) bytes arrived, if [the port is
    /// open](crate::Intervention::OpenPort) for a program; else nothing.
    pub fn unread_instants(&self) -> &'a [SimTime] {
        &self.state.laptop.instants
    }

    /// The same of the cables of sensors' own, in the order of [`unread_of_ports`](Self::unread_of_ports).
    pub fn instants_of_ports(&self) -> impl Iterator<Item = &'a [SimTime]> {
        self.state.ports.iter().map(|port| port.instants.as_slice())
    }

    /// Whether a message of the microcontroller's readings has come since the brain's last step: with new readings, or without.
    pub fn has_heard(&self) -> bool {
        self.state.laptop.has_heard(self.spec)
    }

    /// For the brain: the last reading of each sensor that arrived, in the order of the wire.
    pub fn readings(&self) -> &'a [Reading] {
        &self.state.laptop.readings
    }

    /// The truth about the last reading of a sensor that has come: for observers, never for its brain.
    pub fn heard(&self, sensor: usize) -> Heard {
        self.state.laptop.truth.of(sensor)
    }

    /// Each sensor's truth, in the order of the wire.
    pub fn sensors(&self) -> impl ExactSizeIterator<Item = SensorView<'a>> {
        let freshness = &self.state.laptop.freshness;
        self.state.microcontroller.channels().iter().enumerate().map(|(i, channel)| SensorView {
            sample: &channel.values,
            sampled_at: channel.sampled_at,
            samples: channel.samples,
            missed: channel.missed(),
            freshness: &freshness[i],
        })
    }

    /// The largest age, in nanoseconds, at which a reading was readable so far, of any sensor.
    pub fn longest_age_ns(&self) -> Option<u64> {
        self.state.laptop.freshness.iter().filter_map(|freshness| freshness.ages.max_ns()).max()
    }

    /// The numbers of the robot's run so far.
    pub fn counters(&self) -> &'a RobotCounters {
        &self.state.counters
    }

    /// The time for which something has kept it from moving, in nanoseconds, if robots slide along obstacles.
    pub fn stood_in_contact_ns(&self) -> u64 {
        self.state.parts.standing_ns.unwrap_or_default()
    }

    /// Commands that its microcontroller obeyed.
    pub fn commands(&self) -> u64 {
        self.state.microcontroller.commands
    }

    /// Frames of readings that fell due while the microcontroller was busy, and were left out.
    pub fn frames_missed(&self) -> u64 {
        self.state.microcontroller.frames_missed()
    }

    /// The control cycles.
    pub fn cycles(&self) -> &'a Cycles {
        &self.state.cycles
    }

    /// The robot's latest events.
    pub fn timeline(&self) -> &'a Timeline {
        &self.state.recorder.timeline
    }

    /// The last bytes that came over one of its cables this way, if the world [keeps](crate::World::keep_tape) them and there is
    /// such a cable. Nothing goes down to a device that speaks by itself.
    pub fn tape(&self, cable: Cable, direction: Direction) -> Option<&'a Tape> {
        let Robot { uplink, downlink, ports, .. } = self.state;
        let line = match (cable, direction) {
            (Cable::Robot, Direction::Up) => uplink,
            (Cable::Robot, Direction::Down) => downlink,
            (Cable::Sensor(i), direction) => {
                let k = self.spec.sensors.ports().iter().position(|&other| other == i)?;
                match direction {
                    Direction::Up => &ports.get(k)?.line,
                    Direction::Down => &self.state.dialogue(k)?.down,
                }
            }
        };
        line.tape()
    }

    /// The line from the microcontroller to the laptop.
    pub fn uplink(&self) -> &'a LineCounters {
        &self.state.uplink.counters
    }

    /// Bytes that wait for the wire or are on it: to the laptop, and to the microcontroller.
    pub fn under_way(&self) -> [u64; 2] {
        [&self.state.uplink, &self.state.downlink].map(|line| line.under_way())
    }

    /// The line from the laptop to the microcontroller.
    pub fn downlink(&self) -> &'a LineCounters {
        &self.state.downlink.counters
    }
}

/// A look at something that moves by itself or is pushed.
#[derive(Clone, Debug)]
pub struct ThingView<'a> {
    /// The name of the thing.
    pub name: &'a str,
    /// The pose, world from thing.
    pub pose: Pose,
    /// The thing's outline in the world.
    pub outline: Outline,
    /// The height of the thing and its colour.
    pub look: Look,
    /// Time that something was in its way, in nanoseconds; 0 for what is pushed.
    pub blocked_ns: u64,
}

/// The outline of a thing in the world.
#[derive(Clone, Debug, PartialEq)]
pub enum Outline {
    /// A disc.
    Disc(Circle),
    /// Corners in order.
    Polygon(alloc::vec::Vec<Point>),
}

impl Outline {
    fn of(form: &Form<'_>, pose: &Pose) -> Self {
        match form.at(pose) {
            Body::Disc(disc) => Self::Disc(disc),
            Body::Polygon(points) => Self::Polygon(points),
        }
    }
}

impl<'a> ThingView<'a> {
    pub(crate) fn of_mover((mover, state): (&'a Mover, &MoverState)) -> Self {
        let outline = Outline::of(&mover.form(), &state.pose);
        Self { name: &mover.name, pose: state.pose, outline, look: mover.look, blocked_ns: state.blocked_ns }
    }

    pub(crate) fn of_movable((movable, state): (&'a Movable, &MovableState)) -> Self {
        let outline = Outline::of(&movable.shape.form(), &state.pose);
        Self { name: &movable.name, pose: state.pose, outline, look: movable.look, blocked_ns: 0 }
    }
}
