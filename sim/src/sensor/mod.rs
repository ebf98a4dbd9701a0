//! Sensors: one file a device, each a question to the frozen scene and a value in answer.

mod accelerometer;
mod battery;
mod camera;
mod compass;
mod encoder;
mod field;
mod floor;
mod gps;
mod gyroscope;
mod infrared;
mod laser;
mod light;
mod lookup;
mod lowpass;
mod mount;
pub(crate) mod noise;
mod odometer;
mod own_clock;
mod photoresistor;
mod sonar;
mod touch;
mod voltage;

use alloc::boxed::Box;
use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::{Fan, Pose, Twist, angle, math};
use baudbot_wire::Encoding;
use serde::{Deserialize, Serialize};

pub use accelerometer::Accelerometer;
pub use battery::BatteryGauge;
pub use camera::LineCamera;
pub use compass::Compass;
pub use encoder::{Encoders, StepCounter};
pub use field::{FieldSensor, Microphone};
pub use floor::FloorSensor;
pub use gps::Gps;
pub use gyroscope::Gyroscope;
pub use infrared::{Infrared, InfraredModel};
pub use laser::Laser;
pub(crate) use laser::NOTHING;
pub use light::LightSensor;
pub use lookup::{Lookup, LookupError};
pub use mount::Mount;
pub use noise::{Drift, Dropout, Noise, Spikes};
pub use odometer::Odometer;
pub use own_clock::OwnClock;
pub(crate) use own_clock::{Event, Parts, Running};
pub use photoresistor::Photoresistor;
pub(crate) use sonar::is_heard;
pub use sonar::{CrossTalk, Sonar};
pub use touch::{Bumper, Switch, Whisker};
pub use voltage::VoltageRanger;

use crate::actuator::ActuatorState;
use crate::drive::Motion;
use crate::port::Port;
use crate::random::Stream;
use crate::robot::RobotSpec;
use crate::scene::{Ping, Scene};
use crate::schedule::Schedule;
use crate::time::SimTime;

/// What a sensor is: a device, when it is read, and how its values cross the wire.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// Unique on its robot.
    pub name: String,
    /// The device.
    pub device: Device,
    /// What disturbs its readings.
    pub noise: Noise,
    /// When the microcontroller reads it; without meaning for a sensor with a port of its own.
    pub schedule: Schedule,
    /// How long a read takes of the microcontroller's time, apart from what the device itself keeps it waiting.
    pub acquisition_ns: u64,
    /// If it measures at its own pace, whether or not anybody reads it.
    pub own_clock: Option<OwnClock>,
    /// If it has a cable of its own to the laptop, past the microcontroller (Fig. 1.18).
    pub port: Option<Port>,
    /// How each value crosses the wire; as many as `device.values()`.
    pub encodings: Vec<Encoding>,
}

/// The kinds of sensor that there are.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs, reason = "each variant is its payload's documentation")]
pub enum Device {
    Infrared(Infrared),
    VoltageRanger(VoltageRanger),
    Sonar(Sonar),
    Laser(Laser),
    LineCamera(LineCamera),
    Encoders(Encoders),
    StepCounter(StepCounter),
    Odometer(Odometer),
    Compass(Compass),
    Accelerometer(Accelerometer),
    Gyroscope(Gyroscope),
    Gps(Gps),
    Whisker(Whisker),
    Bumper(Bumper),
    Photoresistor(Photoresistor),
    Light(LightSensor),
    Field(FieldSensor),
    Microphone(Microphone),
    Floor(FloorSensor),
    Battery(BatteryGauge),
}

/// The state that a device keeps between two reads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Memory {
    None,
    Odometer(odometer::Estimate),
    Encoders(encoder::Seen),
    Filter(lowpass::LowPass),
    Accelerometer([lowpass::LowPass; 2]),
    Gps(Box<gps::Wander>),
    Touch(touch::Contact),
}

impl Memory {
    /// Whether a device can remember this that remembered `first` before its first read.
    pub(crate) fn is_sound(&self, first: &Self) -> bool {
        let is_kind = core::mem::discriminant(self) == core::mem::discriminant(first);
        is_kind
            && match self {
                Self::None | Self::Touch(_) => true,
                Self::Odometer(estimate) => estimate.is_sound(),
                Self::Encoders(seen) => seen.is_sound(),
                Self::Filter(filter) => filter.is_sound(),
                Self::Accelerometer(filters) => filters.iter().all(lowpass::LowPass::is_sound),
                Self::Gps(wander) => wander.is_sound(),
            }
    }
}

/// A part of a reading: what its column in a table is called, with its unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Component {
    /// Empty if the sensor has only this one.
    pub name: &'static str,
    /// SI unit, `1` for a ratio.
    pub unit: &'static str,
    /// How many values it has: 1, or as many as a scan has rays.
    pub count: usize,
}

impl Component {
    const fn one(name: &'static str, unit: &'static str) -> Self {
        Self { name, unit, count: 1 }
    }
}

/// What a device measures with: the frozen scene, and the robot's own body and motion.
#[derive(Clone, Copy)]
pub(crate) struct Measurement<'a> {
    pub(crate) scene: &'a Scene<'a>,
    pub(crate) robot: &'a RobotSpec,
    pub(crate) motion: &'a Motion,
    pub(crate) actuators: &'a [ActuatorState],
    pub(crate) battery: Option<&'a crate::battery::BatteryState>,
    pub(crate) noise: bool,
    pub(crate) now: SimTime,
    /// The tick: from here …
    pub(crate) tick_start: SimTime,
    /// … to here, with the scene as it is at its start.
    pub(crate) tick_end: SimTime,
}

impl Measurement<'_> {
    /// The robot's motion over ground, whatever its wheels do.
    fn over_ground(&self) -> Twist {
        self.scene.surroundings.over_ground(&self.robot.drive, self.motion)
    }
}

/// What reading a device does besides giving values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Effect {
    /// How long the device keeps the microcontroller waiting, in nanoseconds.
    pub(crate) wait_ns: u64,
    /// A pulse that others hear.
    pub(crate) ping: Option<Ping>,
}

impl Device {
    /// What the scenario calls this kind.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Infrared(_) => "ir",
            Self::VoltageRanger(_) => "ir-voltage",
            Self::Sonar(_) => "sonar",
            Self::Laser(_) => "laser",
            Self::LineCamera(_) => "line-camera",
            Self::Encoders(_) => "encoders",
            Self::StepCounter(_) => "steps",
            Self::Odometer(_) => "odometer",
            Self::Compass(_) => "compass",
            Self::Accelerometer(_) => "accelerometer",
            Self::Gyroscope(_) => "gyroscope",
            Self::Gps(_) => "gps",
            Self::Whisker(_) => "whisker",
            Self::Bumper(_) => "bumper",
            Self::Photoresistor(_) => "photoresistor",
            Self::Light(_) => "light",
            Self::Field(_) => "field",
            Self::Microphone(_) => "microphone",
            Self::Floor(_) => "floor",
            Self::Battery(_) => "battery",
        }
    }

    /// The components of a reading, in order.
    pub fn components(&self) -> Vec<Component> {
        let one = Component::one;
        match self {
            Self::Infrared(_) | Self::Floor(_) | Self::Field(_) | Self::Microphone(_) => {
                alloc::vec![one("", "1")]
            }
            Self::VoltageRanger(_) => alloc::vec![one("", "V")],
            Self::Sonar(_) => alloc::vec![one("", "m")],
            Self::Laser(laser) => alloc::vec![Component { name: "", unit: "m", count: laser.rays() }],
            Self::LineCamera(camera) => {
                let many = |name, unit| Component { name, unit, count: camera.columns() };
                alloc::vec![many("red", "1"), many("green", "1"), many("blue", "1"), many("depth_m", "m")]
            }
            Self::Encoders(_) => alloc::vec![one("left", "count"), one("right", "count")],
            Self::StepCounter(_) => alloc::vec![one("left", "count"), one("right", "count")],
            Self::Odometer(_) => {
                alloc::vec![one("x_m", "m"), one("y_m", "m"), one("heading_rad", "rad")]
            }
            Self::Compass(_) => alloc::vec![one("", "rad")],
            Self::Accelerometer(_) => {
                alloc::vec![one("forward_m_s2", "m/s^2"), one("left_m_s2", "m/s^2")]
            }
            Self::Gyroscope(_) => alloc::vec![one("", "rad/s")],
            Self::Gps(_) => {
                alloc::vec![
                    one("latitude_deg", "deg"),
                    one("longitude_deg", "deg"),
                    one("fix", "1"),
                    one("speed_m_s", "m/s"),
                    one("course_rad", "rad"),
                ]
            }
            Self::Whisker(_) | Self::Bumper(_) => alloc::vec![one("", "1")],
            Self::Photoresistor(_) => alloc::vec![one("", "count")],
            Self::Light(_) => alloc::vec![one("", "lx")],
            Self::Battery(_) => alloc::vec![one("voltage_v", "V"), one("charge", "1")],
        }
    }

    /// How many values a reading has.
    pub fn values(&self) -> usize {
        self.components().iter().map(|component| component.count).sum()
    }

    /// Where it sits and which way it looks, if that matters.
    pub fn mount(&self) -> Option<&Mount> {
        match self {
            Self::Infrared(device) => Some(&device.mount),
            Self::VoltageRanger(device) => Some(&device.mount),
            Self::Sonar(device) => Some(&device.mount),
            Self::Laser(device) => Some(&device.mount),
            Self::LineCamera(device) => Some(&device.mount),
            Self::Whisker(device) => Some(&device.mount),
            Self::Photoresistor(device) => Some(&device.light.mount),
            Self::Light(device) => Some(&device.mount),
            Self::Field(device) => Some(&device.mount),
            Self::Floor(device) => Some(&device.mount),
            Self::Bumper(device) => Some(&device.mount),
            _ => None,
        }
    }

    /// How far it looks, in metres, if it looks.
    pub fn range_m(&self) -> Option<f64> {
        match self {
            Self::Infrared(device) => Some(device.range_m),
            Self::VoltageRanger(device) => Some(device.range_m),
            Self::Sonar(device) => Some(device.max_m),
            Self::Laser(device) => Some(device.range_m),
            Self::LineCamera(device) => Some(device.range_m),
            Self::Whisker(device) => Some(device.length_m),
            _ => None,
        }
    }

    /// The rays that it looks along, if it does.
    pub fn fan(&self) -> Option<&Fan> {
        match self {
            Self::Infrared(device) => Some(&device.fan),
            Self::VoltageRanger(device) => Some(&device.fan),
            Self::Sonar(device) => Some(&device.fan),
            Self::Laser(device) => Some(&device.fan),
            Self::LineCamera(device) => Some(&device.fan),
            Self::Bumper(device) => Some(&device.fan),
            _ => None,
        }
    }

    /// What the device knows before its first read. An odometer is calibrated: it starts at the true pose.
    pub(crate) fn remember(&self, start: &Pose, stream: &mut Stream) -> Memory {
        match self {
            Self::Odometer(_) => Memory::Odometer(odometer::Estimate::calibrated(start)),
            Self::Encoders(_) => Memory::Encoders(encoder::Seen::default()),
            Self::Gyroscope(_) | Self::Light(_) | Self::Photoresistor(_) => {
                Memory::Filter(lowpass::LowPass::default())
            }
            Self::Accelerometer(_) => Memory::Accelerometer(Default::default()),
            Self::Gps(gps) => Memory::Gps(Box::new(gps.start(stream))),
            Self::Whisker(_) | Self::Bumper(_) => Memory::Touch(touch::Contact::default()),
            _ => Memory::None,
        }
    }

    /// Reads the device; `values` gets one value a component.
    pub(crate) fn read(
        &self,
        at: &Measurement<'_>,
        memory: &mut Memory,
        stream: &mut Stream,
        values: &mut [f64],
    ) -> Effect {
        match (self, memory) {
            (Self::Infrared(device), _) => values[0] = device.read(at, stream),
            (Self::VoltageRanger(device), _) => values[0] = device.read(at),
            (Self::Sonar(device), _) => return device.read(at, stream, values),
            (Self::Laser(device), _) => device.read(at, 0..values.len(), at.now, values),
            (Self::LineCamera(device), _) => device.read(at, values),
            (Self::Encoders(device), Memory::Encoders(seen)) => {
                values.copy_from_slice(&device.read(at, seen, stream));
            }
            (Self::StepCounter(_), _) => values.copy_from_slice(&StepCounter::read(at)),
            (Self::Odometer(device), Memory::Odometer(estimate)) => {
                values.copy_from_slice(&device.read(at, estimate, stream));
            }
            (Self::Compass(device), _) => values[0] = device.read(at),
            (Self::Accelerometer(device), Memory::Accelerometer(filters)) => {
                values.copy_from_slice(&device.read(at, filters));
            }
            (Self::Gyroscope(device), Memory::Filter(filter)) => values[0] = device.read(at, filter),
            (Self::Gps(device), Memory::Gps(wander)) => {
                values.copy_from_slice(&device.read(at, wander, stream));
            }
            (Self::Whisker(device), Memory::Touch(contact)) => {
                values[0] = device.read(at, contact, stream);
            }
            (Self::Bumper(device), Memory::Touch(contact)) => {
                values[0] = device.read(at, contact, stream);
            }
            (Self::Photoresistor(device), Memory::Filter(filter)) => {
                return device.read(at, filter, values);
            }
            (Self::Light(device), Memory::Filter(filter)) => values[0] = device.read(at, filter),
            (Self::Field(device), _) => values[0] = device.read(at),
            (Self::Microphone(_), _) => values[0] = Microphone::read(at),
            (Self::Floor(device), _) => values[0] = device.read(at),
            (Self::Battery(_), _) => values.copy_from_slice(&BatteryGauge::read(at)),
            (_, _) => unreachable!("a device is created with its memory"),
        }
        Effect::default()
    }

    /// What the device can say at all: readings that noise took farther are brought back.
    pub(crate) fn bound(&self, values: &mut [f64]) {
        match self {
            Self::Infrared(_) | Self::Floor(_) => values[0] = values[0].clamp(0.0, 1.0),
            Self::Compass(_) => values[0] = angle::wrap(values[0]),
            Self::VoltageRanger(device) => values[0] = values[0].clamp(0.0, device.supply_v),
            Self::Sonar(device) => values[0] = values[0].clamp(device.min_m, device.max_m),
            Self::Laser(device) => device.bound(values),
            Self::LineCamera(device) => device.bound(values),
            Self::Accelerometer(device) => {
                values.iter_mut().for_each(|v| *v = v.clamp(-device.range_m_s2, device.range_m_s2));
            }
            Self::Gyroscope(device) => {
                values[0] = values[0].clamp(-device.range_rad_s, device.range_rad_s);
            }
            Self::Light(device) => values[0] = values[0].clamp(0.0, device.range_lux),
            Self::Photoresistor(device) => {
                values[0] = math::round(values[0]).clamp(0.0, f64::from(device.max_counts));
            }
            Self::Microphone(_) => values[0] = values[0].max(0.0),
            Self::Battery(_) => {
                values[0] = values[0].max(0.0);
                values[1] = values[1].clamp(0.0, 1.0);
            }
            _ => {}
        }
    }

    /// The value that stands for nothing in range, which noise does not touch.
    fn nothing(&self) -> Option<f64> {
        match self {
            Self::Laser(_) | Self::LineCamera(_) => Some(NOTHING),
            Self::Sonar(sonar) => Some(sonar.max_m),
            _ => None,
        }
    }

    /// What the microcontroller reads from a device that has measured nothing yet.
    pub(crate) fn unmeasured(&self, values: &mut [f64]) {
        values.fill(match self {
            Self::Laser(_) => NOTHING,
            Self::Whisker(Whisker { switch, .. }) | Self::Bumper(Bumper { switch, .. }) => {
                f64::from(u8::from(switch.active_low))
            }
            _ => 0.0,
        });
        if let Self::LineCamera(camera) = self {
            values[3 * camera.columns()..].fill(NOTHING);
        }
    }

    /// The longest time that the device itself keeps the microcontroller waiting, in nanoseconds.
    pub fn longest_wait_ns(&self) -> u64 {
        match self {
            Self::Sonar(sonar) => sonar.holdoff_ns + sonar.timeout_ns,
            Self::Photoresistor(device) => u64::from(device.max_counts) * device.unit_ns,
            _ => 0,
        }
    }

    /// Whether its readings are disturbed by [`Noise`]. Digital readings are not: a count is right or lost,
    /// a switch is open or closed.
    pub fn is_analog(&self) -> bool {
        !matches!(
            self,
            Self::Encoders(_)
                | Self::StepCounter(_)
                | Self::Odometer(_)
                | Self::Gps(_)
                | Self::Whisker(_)
                | Self::Bumper(_)
        )
    }
}

impl Sensor {
    /// Takes a reading through what disturbs it, and back to what the device can say.
    pub(crate) fn disturb(
        &self,
        noisy: bool,
        state: &mut noise::NoiseState,
        now: SimTime,
        values: &mut [f64],
        stream: &mut Stream,
    ) {
        if noisy && matches!(values, [value] if value.to_bits() == 0) && self.noise.leaves_0(stream) {
            // Nothing is near.
        } else if noisy && !self.noise.is_none() {
            // What is infinitely far stays so whatever noise does to it, but for a dropout.
            let nothing = self.device.nothing();
            if let Some(nothing) = nothing {
                let far = |value: f64| if value == nothing { f64::INFINITY } else { value };
                values.iter_mut().for_each(|value| *value = far(*value));
            }
            self.noise.disturb(state, now, values, stream);
            if let Some(nothing) = nothing {
                let back = |value: f64| if value.is_finite() { value } else { nothing };
                values.iter_mut().for_each(|value| *value = back(*value));
            }
        }
        self.device.bound(values);
    }

    /// Whether the microcontroller reads it.
    pub fn is_on_wire(&self) -> bool {
        self.port.is_none()
    }
}
