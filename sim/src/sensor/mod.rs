//! Sensors: one file a device, each a question to the frozen scene and a value in answer.

mod compass;
mod encoder;
mod infrared;
mod noise;
mod odometer;

use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::Pose;
use baudbot_wire::Encoding;
use serde::{Deserialize, Serialize};

pub use compass::Compass;
pub use encoder::Encoders;
pub use infrared::{Infrared, Mount};
pub use odometer::Odometer;

use crate::drive::{Drive, Motion};
use crate::random::Stream;
use crate::scene::Scene;
use crate::schedule::Schedule;

/// What a sensor is: a device, when it is read, and how its values cross the wire.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// Unique on its robot.
    pub name: String,
    /// The device.
    pub device: Device,
    /// When the microcontroller reads it.
    pub schedule: Schedule,
    /// How long a read takes of the microcontroller's time.
    pub acquisition_ns: u64,
    /// How each component crosses the wire; as many as `device.components()`.
    pub encodings: Vec<Encoding>,
}

/// The kinds of sensor that there are.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs, reason = "each variant is its payload's documentation")]
pub enum Device {
    Infrared(Infrared),
    Encoders(Encoders),
    Odometer(Odometer),
    Compass(Compass),
}

/// The state that a device keeps between two reads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Memory {
    None,
    Odometer(odometer::Estimate),
}

/// A component of a reading: what its column in a table is called, with its unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Component {
    /// Empty if the sensor has only this one.
    pub name: &'static str,
    /// SI unit, `1` for a ratio.
    pub unit: &'static str,
}

/// What a device measures with: the frozen scene, and the robot's own body and motion.
pub(crate) struct Measurement<'a> {
    pub(crate) scene: &'a Scene<'a>,
    pub(crate) drive: &'a Drive,
    pub(crate) motion: &'a Motion,
    pub(crate) noise: bool,
}

impl Device {
    /// What the scenario calls this kind.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Infrared(_) => "ir",
            Self::Encoders(_) => "encoders",
            Self::Odometer(_) => "odometer",
            Self::Compass(_) => "compass",
        }
    }

    /// The components of a reading, in order.
    pub fn components(&self) -> &'static [Component] {
        match self {
            Self::Infrared(_) => &[Component { name: "", unit: "1" }],
            Self::Compass(_) => &[Component { name: "", unit: "rad" }],
            Self::Encoders(_) => {
                &[Component { name: "left", unit: "count" }, Component { name: "right", unit: "count" }]
            }
            Self::Odometer(_) => &[
                Component { name: "x_m", unit: "m" },
                Component { name: "y_m", unit: "m" },
                Component { name: "heading_rad", unit: "rad" },
            ],
        }
    }

    /// What the device knows before its first read. An odometer is calibrated: it starts at the true pose.
    pub(crate) fn remember(&self, start: &Pose) -> Memory {
        match self {
            Self::Odometer(_) => Memory::Odometer(odometer::Estimate::calibrated(start)),
            Self::Infrared(_) | Self::Encoders(_) | Self::Compass(_) => Memory::None,
        }
    }

    /// Reads the device; `values` gets one value a component.
    pub(crate) fn read(
        &self,
        at: &Measurement<'_>,
        memory: &mut Memory,
        stream: &mut Stream,
        values: &mut [f64],
    ) {
        match (self, memory) {
            (Self::Infrared(infrared), _) => values[0] = infrared.read(at, stream),
            (Self::Encoders(encoders), _) => values.copy_from_slice(&encoders.read(at)),
            (Self::Compass(compass), _) => values[0] = compass.read(at, stream),
            (Self::Odometer(odometer), Memory::Odometer(estimate)) => {
                values.copy_from_slice(&odometer.read(at, estimate, stream));
            }
            (Self::Odometer(_), Memory::None) => unreachable!("an odometer is created with its estimate"),
        }
    }
}
