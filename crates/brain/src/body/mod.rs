//! A robot's data sheet: all that a brain knows of its robot's body.

mod kind;

use alloc::string::String;
use alloc::vec::Vec;

use baudbot_wire::{Encoding, Protocol};

use crate::action::Action;

pub use kind::{ActuatorKind, MotorKind, PortFormat, SensorKind};

/// The data sheet of a robot, which does not change during a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// The robot's name in its world.
    pub name: String,
    /// Radius of its disc, in metres.
    pub radius_m: f64,
    /// Half the distance between its wheels, in metres.
    pub half_track_m: f64,
    /// Radius of its wheels, in metres.
    pub wheel_radius_m: f64,
    /// Largest size of a motor signal; `None` if there is no limit.
    pub signal_limit: Option<f64>,
    /// The encoding of a motor signal on the wire.
    pub motor_encoding: Encoding,
    /// The motors of the wheels.
    pub motor_kind: MotorKind,
    /// Actuators besides the wheels, in the order of [`Action::others`].
    pub actuators: Vec<Actuator>,
    /// The sensors that the microcontroller reads, in the order of the wire; then those with a port of their own.
    pub sensors: Vec<Sensor>,
    /// The firmware of the microcontroller.
    pub firmware: Firmware,
    /// Bits a second of the cable; `None` if it has no baud rate: if it is ideal, or USB.
    pub baud: Option<u32>,
    /// Bits a character; `None` where there is no baud rate.
    pub bits_per_character: Option<u32>,
    /// There is no cable: the brain is the microcontroller's program, and its thinking takes that processor's
    /// time.
    pub onboard: bool,
    /// Operations of a brain's program that the microcontroller does a second, if that is known.
    pub operations_per_s: Option<f64>,
    /// Memory for the variables of a brain's program, in bytes, if that is known.
    pub ram_bytes: Option<u64>,
}

/// The data sheet of an actuator besides the wheels. It takes one signal, in [-1, 1].
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    /// The name of the actuator, unique among the robot's actuators.
    pub name: String,
    /// The kind of the actuator: the effect of its signal.
    pub kind: ActuatorKind,
    /// Least and greatest angle of a turret, in radians. It turns to the angle that is the signal times the end
    /// farther from 0, and no farther than either end.
    pub range_rad: Option<[f64; 2]>,
}

/// The data sheet of a sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// The name of the sensor, unique on its robot.
    pub name: String,
    /// The kind of the sensor: the quantity that it measures, and the principle.
    pub kind: SensorKind,
    /// The parts of a reading, in order.
    pub components: Vec<Component>,
    /// Time between two samples, in nanoseconds.
    pub period_ns: u64,
    /// Instant of the first sample, in nanoseconds.
    pub phase_ns: u64,
    /// The sensor's place and direction, if they matter.
    pub mount: Option<Mount>,
    /// Range in metres, if it has one.
    pub range_m: Option<f64>,
    /// Counts a turn of the wheel, if it counts.
    pub counts_per_turn: Option<u32>,
    /// Counts a metre of way over the floor, if it counts that.
    pub counts_per_m: Option<f64>,
    /// A cable of its own to the laptop, past the microcontroller, if it has one.
    pub port: Option<Port>,
    /// The angle from the first of the rays that it looks along to the last, in radians, if it looks along rays; 0 if that
    /// is one ray.
    pub opening_rad: Option<f64>,
    /// The turn of a laser's mirror.
    pub sweep: Option<Sweep>,
    /// Pixels in a row of an image, if it is a camera.
    pub columns: Option<u32>,
}

/// The sweep of a laser range finder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sweep {
    /// Time from the first ray of a scan to the last, in nanoseconds.
    pub duration_ns: u64,
    /// The first ray is the one farthest to the left, and not the one farthest to the right.
    pub clockwise: bool,
}

/// A sensor's own cable to the laptop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Port {
    /// The format of its messages.
    pub format: PortFormat,
    /// Bytes of one message.
    pub message_bytes: u64,
    /// Bits a second; `None` if the cable is ideal.
    pub baud: Option<u32>,
    /// Bits a character; `None` if the cable is ideal.
    pub bits_per_character: Option<u32>,
}

/// A part of a reading: one value, or as many as a scan has rays.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// The name of the component; empty if the sensor has only this one.
    pub name: String,
    /// SI unit; `1` for a ratio.
    pub unit: String,
    /// The encoding of each value on the wire; without meaning for a sensor with a port of its own.
    pub encoding: Encoding,
    /// The number of its values; at least 1.
    pub count: usize,
}

/// Robot from sensor; on a turret, turret from sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mount {
    /// The distance forwards of the robot's centre, in metres.
    pub x_m: f64,
    /// The distance to the left of the robot's centre, in metres.
    pub y_m: f64,
    /// Counter-clockwise of the robot's heading, in radians.
    pub heading_rad: f64,
    /// The actuator that turns it about the robot's centre, by its place in [`Body::actuators`].
    pub turret: Option<usize>,
    /// The angle by which its rays rise above the floor's plane, in radians; `None` if they are level.
    pub elevation_rad: Option<f64>,
}

/// The firmware of a microcontroller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Firmware {
    /// The form of its messages.
    pub protocol: Protocol,
    /// Nanoseconds between two messages of readings; `None` if it answers only when asked.
    pub period_ns: Option<u64>,
}

impl Mount {
    /// Whether what it looks along stays at one place of the robot's plane: it is on no turret, and its rays are level.
    pub fn is_fixed_and_level(&self) -> bool {
        self.turret.is_none() && self.elevation_rad.is_none()
    }
}

impl Sensor {
    /// The number of values of a reading.
    pub fn values(&self) -> usize {
        self.components.iter().fold(0, |sum, component| sum.saturating_add(component.count))
    }

    /// Whether the microcontroller reads it and sends its readings.
    pub fn is_on_wire(&self) -> bool {
        self.port.is_none()
    }
}

impl Body {
    /// The place of the actuator of this name in [`actuators`](Self::actuators) and in [`Action::others`].
    pub fn actuator_index(&self, name: &str) -> Option<usize> {
        self.actuators.iter().position(|actuator| actuator.name == name)
    }

    /// The sensor of this name.
    pub fn sensor(&self, name: &str) -> Option<&Sensor> {
        self.sensors.iter().find(|sensor| sensor.name == name)
    }

    /// The place of the sensor of this name in [`sensors`](Self::sensors) and in
    /// [`Turn::readings`](crate::Turn::readings).
    pub fn sensor_index(&self, name: &str) -> Option<usize> {
        self.sensors.iter().position(|sensor| sensor.name == name)
    }

    /// The action of a brain that wants readings and no motion: a firmware that talks of its own accord is waited for,
    /// one that answers only when asked is asked. The bare protocol has no other question than a command, so there the
    /// motors get a signal of 0.
    pub fn request(&self) -> Action {
        match self.firmware {
            Firmware { period_ns: Some(_), .. } => Action::wait(),
            Firmware { protocol, .. } if protocol.has_poll() => Action::poll(),
            Firmware { .. } => Action::drive(0.0, 0.0),
        }
    }
}
