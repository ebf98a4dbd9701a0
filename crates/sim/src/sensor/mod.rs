//! Sensors: one file a device, each a question to the frozen scene and a value in answer.

mod accelerometer;
mod battery;
mod camera;
mod compass;
pub mod dialogue;
mod echo;
mod encoder;
mod field;
mod floor;
mod gps;
mod gyroscope;
mod image;
mod infrared;
mod ir_beacons;
mod kind;
mod laser;
mod light;
mod lookup;
mod lowpass;
mod measurement;
mod mount;
pub(crate) mod noise;
mod odometer;
mod optical_flow;
mod own_clock;
mod photoresistor;
pub mod port;
mod set;
mod sky;
mod sonar;
mod strain_gauge;
mod style;
mod touch;
mod voltage;

use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::{Fan, Pose, vectors};
use baudbot_wire::Encoding;
use serde::de::Error;
use serde::{Deserialize, Deserializer};

pub use accelerometer::Accelerometer;
pub use battery::BatteryGauge;
pub use camera::LineCamera;
pub use compass::Compass;
pub use echo::Echo;
pub use encoder::{Encoders, StepCounter};
pub use field::{FieldSensor, Microphone};
pub use floor::FloorSensor;
pub use gps::Gps;
pub use gyroscope::Gyroscope;
pub use image::Camera;
pub use infrared::{Converter, Infrared, InfraredModel};
pub use ir_beacons::IrBeacons;
pub use kind::{Built, Component, Fit, Place};
pub(crate) use kind::{Effect, Memory};
use kind::{Part, Sense};
pub use laser::Laser;
pub(crate) use laser::NOTHING;
pub use light::LightSensor;
pub use lookup::{Lookup, Sheet as LookupSheet};
pub(crate) use measurement::Measurement;
pub use mount::Mount;
pub use noise::{Drift, Dropout, Noise, Spikes};
pub use odometer::Odometer;
pub use optical_flow::OpticalFlow;
pub use own_clock::OwnClock;
pub(crate) use own_clock::{Event, Parts, Running};
pub use photoresistor::Photoresistor;
pub use port::Port;
pub use set::Sensors;
pub(crate) use sonar::is_heard;
pub use sonar::{CrossTalk, Sonar};
pub use strain_gauge::StrainGauge;
pub use style::{Style, Symbol};
pub use touch::{Bumper, Switch, Whisker};
pub use voltage::VoltageRanger;

pub use crate::arena::Height;
use crate::random::Stream;
use crate::schedule::Schedule;
use crate::time::SimTime;
use baudbot_fields::{FieldError, Fields, Path};

/// The model of a sensor: a device, its schedule, and the encoding of its values.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// Unique on its robot.
    pub name: String,
    /// The device.
    pub device: Device,
    /// The noise on its readings.
    pub noise: Noise,
    /// When the microcontroller reads it; without meaning for a sensor with a port of its own.
    pub schedule: Schedule,
    /// The time that a read takes the microcontroller, apart from the device's own.
    pub acquisition_ns: u64,
    /// If it measures at its own pace, whether or not anybody reads it.
    pub own_clock: Option<OwnClock>,
    /// If it has a cable of its own to the laptop, past the microcontroller (Fig. 1.18).
    pub port: Option<Port>,
    /// The encoding of each value; as many as `device.values()`.
    pub encodings: Vec<Encoding>,
}

macro_rules! devices {
    ($($kind:ident($device:ident)),* $(,)?) => {
        /// A device of one of the kinds that there are.
        #[derive(Clone, Debug, PartialEq)]
        #[allow(missing_docs, reason = "each variant is its payload's documentation")]
        pub enum Device {
            $($kind($device)),*
        }

        /// The kinds of sensor that there are.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        #[allow(missing_docs, reason = "each is documented as a device")]
        pub enum SensorKind {
            $($kind),*
        }

        impl SensorKind {
            /// All kinds.
            pub const ALL: [Self; Self::NAMES.len()] = [$(Self::$kind),*];

            /// The names of all kinds.
            pub const NAMES: [&str; [$($device::NAME),*].len()] = [$($device::NAME),*];

            /// The name in scenarios.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$kind => $device::NAME),*
                }
            }

            /// The place of this kind's sensors.
            pub fn place(self) -> Place {
                match self {
                    $(Self::$kind => $device::PLACE),*
                }
            }

            /// Whether the rays of this kind's sensors may rise or fall.
            pub fn tilts(self) -> bool {
                match self {
                    $(Self::$kind => $device::TILTS),*
                }
            }

            /// The fewest bits that a value of this kind's sensors may have on the wire.
            pub fn least_bits(self) -> u64 {
                match self {
                    $(Self::$kind => $device::LEAST_BITS),*
                }
            }

            /// The drawing of this kind's sensors.
            pub fn style(self) -> Style {
                match self {
                    $(Self::$kind => $device::STYLE),*
                }
            }

            /// The kind as brains know it.
            #[cfg(feature = "brain")]
            pub(crate) fn for_brains(self) -> baudbot_brain::SensorKind {
                match self {
                    $(Self::$kind => baudbot_brain::SensorKind::$kind),*
                }
            }

            /// A JSON Schema of the fields of its table, besides those of all sensors and those of its place.
            #[cfg(feature = "schema")]
            pub fn schema(self, generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
                match self {
                    $(Self::$kind => generator.subschema_for::<<$device as Sense>::Sheet>()),*
                }
            }

            /// The sensor of this kind whose table stands at `path`.
            ///
            /// # Errors
            /// Names the field that is wrong, and how.
            pub fn build(self, fields: impl Fields, path: &Path, fit: Fit<'_>) -> Result<Built<Device>, FieldError> {
                match self {
                    $(Self::$kind => Ok($device::new(fields.read(path)?, path, fit)?.map(Device::$kind))),*
                }
            }
        }

        impl Device {
            /// Its kind.
            pub fn sensor_kind(&self) -> SensorKind {
                match self {
                    $(Self::$kind(_) => SensorKind::$kind),*
                }
            }

            /// The components of a reading, in order.
            pub fn components(&self) -> Vec<Component> {
                match self {
                    $(Self::$kind(device) => device.components()),*
                }
            }

            /// The place and the direction, if they matter.
            pub fn mount(&self) -> Option<&Mount> {
                match self {
                    $(Self::$kind(device) => device.mount()),*
                }
            }

            /// The range, in metres, if it looks.
            pub fn range_m(&self) -> Option<f64> {
                match self {
                    $(Self::$kind(device) => device.range_m()),*
                }
            }

            /// The rays that it looks along, if it does.
            pub fn fan(&self) -> Option<&Fan> {
                match self {
                    $(Self::$kind(device) => device.fan()),*
                }
            }

            /// The angle within which it takes light in, whatever shines there, in radians; none of what measures no light.
            pub fn acceptance_rad(&self) -> Option<f64> {
                match self {
                    $(Self::$kind(device) => device.acceptance_rad()),*
                }
            }

            /// The longest time that the device itself keeps the microcontroller waiting, in nanoseconds.
            pub fn longest_wait_ns(&self) -> u64 {
                match self {
                    $(Self::$kind(device) => device.longest_wait_ns()),*
                }
            }

            /// Whether its readings are disturbed by [`Noise`].
            pub fn is_analog(&self) -> bool {
                match self {
                    $(Self::$kind(_) => $device::IS_ANALOG),*
                }
            }

            /// The reason why it cannot measure at its own pace, if it cannot.
            pub fn no_clock(&self) -> Option<&'static str> {
                match self {
                    $(Self::$kind(_) => $device::NO_CLOCK),*
                }
            }

            /// The memory of the device before its first read.
            pub(crate) fn remember(&self, start: &Pose, stream: &mut Stream) -> Memory {
                match self {
                    $(Self::$kind(device) => device.remember(start, stream).into()),*
                }
            }

            /// Reads the device; `values` gets one value a component.
            ///
            /// # Panics
            /// If the memory is that of another kind: a device is made with its memory, and a state that is loaded is
            /// [checked](Memory::is_sound).
            pub(crate) fn read(
                &self,
                at: &Measurement<'_>,
                memory: &mut Memory,
                stream: &mut Stream,
                values: &mut [f64],
            ) -> Effect {
                match self {
                    $(Self::$kind(device) => device.read(at, own(memory), stream, values)),*
                }
            }

            /// Brings readings that noise took farther back to what the device can tell at all.
            pub(crate) fn bound(&self, values: &mut [f64]) {
                match self {
                    $(Self::$kind(device) => device.bound(values)),*
                }
            }

            /// The value that stands for nothing in range, which noise does not touch.
            fn nothing(&self) -> Option<f64> {
                match self {
                    $(Self::$kind(device) => device.nothing()),*
                }
            }

            /// The values that the microcontroller reads from a device that has measured nothing yet.
            pub(crate) fn unmeasured(&self, values: &mut [f64]) {
                match self {
                    $(Self::$kind(device) => device.unmeasured(values)),*
                }
            }
        }
    };
}

devices! {
    Infrared(Infrared),
    VoltageRanger(VoltageRanger),
    Sonar(Sonar),
    Laser(Laser),
    LineCamera(LineCamera),
    Camera(Camera),
    Encoders(Encoders),
    StepCounter(StepCounter),
    Odometer(Odometer),
    OpticalFlow(OpticalFlow),
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
    StrainGauge(StrainGauge),
    IrBeacons(IrBeacons),
}

/// The memory as that of the device that it was made for.
fn own<P: Part>(memory: &mut Memory) -> &mut P {
    P::of(memory).expect("a device is made with its memory")
}

impl Device {
    /// The scenario's name for its kind.
    pub fn kind(&self) -> &'static str {
        self.sensor_kind().name()
    }

    /// The number of values of a reading.
    pub fn values(&self) -> usize {
        self.components().iter().map(|component| component.count).sum()
    }
}

impl<'de> Deserialize<'de> for SensorKind {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        let found = Self::ALL.into_iter().find(|kind| kind.name() == name);
        found.ok_or_else(|| D::Error::unknown_variant(&name, &Self::NAMES))
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
            // An infinite distance stays so whatever noise does to it, but for a dropout.
            let nothing = self.device.nothing();
            if let Some(nothing) = nothing {
                vectors::each(values, move |value| if value == nothing { f64::INFINITY } else { value });
            }
            self.noise.disturb(state, now, values, stream);
            if let Some(nothing) = nothing {
                vectors::each(values, move |value| if value.is_finite() { value } else { nothing });
            }
        }
        self.device.bound(values);
    }

    /// Whether the microcontroller reads it.
    pub fn is_on_wire(&self) -> bool {
        self.port.is_none()
    }
}
