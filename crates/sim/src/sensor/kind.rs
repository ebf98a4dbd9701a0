//! The properties of a kind of sensor. Each has a file of its own beside this one, which implements [`Sense`], and a
//! line in the list of [`Device`](super::Device).

use alloc::boxed::Box;
use alloc::vec::Vec;

use baudbot_geometry::{Fan, Pose};
use baudbot_wire::Encoding;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::style::Style;
use super::{Measurement, Mount, encoder, gps, lowpass, odometer, optical_flow, strain_gauge, touch};
use crate::battery::Battery;
use crate::random::Stream;
use crate::scene::Ping;
use crate::surroundings::Surroundings;
use baudbot_fields::number::{Number, Positive, Whole};
use baudbot_fields::{FieldError, Path};

/// A kind of sensor: its data sheet, what it remembers, and how it reads.
pub(crate) trait Sense: Sized {
    /// Its name in scenarios.
    const NAME: &'static str;
    /// The place on the robot.
    const PLACE: Place;
    /// The drawing.
    const STYLE: Style = Style::INNER;
    /// The fewest bits of a value on the wire.
    const LEAST_BITS: u64 = 1;
    /// Whether [`Noise`](super::Noise) disturbs its readings. Digital readings are not disturbed: a count is right or lost, a
    /// switch is open or closed.
    const IS_ANALOG: bool = true;
    /// The reason why it cannot measure at its own pace, if it cannot.
    const NO_CLOCK: Option<&str> = None;
    /// Whether its rays may rise or fall.
    const TILTS: bool = false;
    /// The fields of its table, besides those of all sensors and those of its place.
    type Sheet: DeserializeOwned;
    /// The memory between two reads.
    type Memory: Part;

    /// The sensor whose table stands at `path`.
    fn new(sheet: Self::Sheet, path: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError>;

    /// The components of a reading, in order.
    fn components(&self) -> Vec<Component>;

    /// The place and the direction, if they matter.
    fn mount(&self) -> Option<&Mount> {
        None
    }

    /// The range, in metres, if it looks.
    fn range_m(&self) -> Option<f64> {
        None
    }

    /// The rays that it looks along, if it does.
    fn fan(&self) -> Option<&Fan> {
        None
    }

    /// The angle within which it takes light in, whatever shines there, in radians.
    fn acceptance_rad(&self) -> Option<f64> {
        None
    }

    /// The memory before its first read.
    fn remember(&self, _start: &Pose, _stream: &mut Stream) -> Self::Memory {
        Self::Memory::default()
    }

    /// Reads the device; `values` gets one value a component.
    fn read(
        &self,
        at: &Measurement<'_>,
        memory: &mut Self::Memory,
        stream: &mut Stream,
        values: &mut [f64],
    ) -> Effect;

    /// Brings readings that noise took farther back to what the device can tell at all.
    fn bound(&self, _values: &mut [f64]) {}

    /// The value that stands for nothing in range, which noise does not touch.
    fn nothing(&self) -> Option<f64> {
        None
    }

    /// The values that the microcontroller reads from a device that has measured nothing yet.
    fn unmeasured(&self, values: &mut [f64]) {
        values.fill(0.0);
    }

    /// The longest time that the device itself keeps the microcontroller waiting, in nanoseconds.
    fn longest_wait_ns(&self) -> u64 {
        0
    }
}

/// The reason why a device that its reader waits for has no [clock](super::OwnClock).
pub(super) const TIMED_BY_PROCESSOR: &str =
    "the processor itself times this sensor, so it has no clock of its own";

/// The place of a kind's sensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Somewhere in the body, it does not matter where.
    Inside,
    /// Anywhere, with a [`Mount`].
    Mounted,
    /// In the centre, looking somewhere: a part of the rim.
    Rim,
}

/// The robot that a sensor is fitted to.
#[derive(Debug)]
pub struct Fit<'a> {
    /// The place and the direction.
    pub mount: Mount,
    /// Bits of each value on the wire, if the scenario says how many.
    pub bits: Option<u8>,
    /// What feeds its robot.
    pub battery: Option<&'a Battery>,
    /// The surroundings besides shapes.
    pub surroundings: &'a Surroundings,
}

/// A device, how its values cross the wire, and the noise that its own fields ask for.
#[derive(Clone, Debug)]
pub struct Built<D> {
    /// The device.
    pub device: D,
    /// The encoding of each value.
    pub encodings: Vec<Encoding>,
    /// Standard deviation of multiplicative noise.
    pub multiplicative: f64,
    /// Standard deviation of additive noise.
    pub additive: f64,
}

impl<D> Built<D> {
    pub(super) fn new(device: D, encodings: Vec<Encoding>) -> Self {
        Self { device, encodings, multiplicative: 0.0, additive: 0.0 }
    }

    pub(super) fn map<T>(self, into: impl FnOnce(D) -> T) -> Built<T> {
        let Self { device, encodings, multiplicative, additive } = self;
        Built { device: into(device), encodings, multiplicative, additive }
    }
}

/// The encodings of `values` values that all lie between `min` and `max`.
pub(super) fn levels(bits: Option<u8>, values: usize, min: f64, max: f64) -> Vec<Encoding> {
    alloc::vec![level(bits, min, max); values]
}

/// The encoding of a value between `min` and `max`.
pub(super) fn level(bits: Option<u8>, min: f64, max: f64) -> Encoding {
    bits.map_or(Encoding::Float64, |bits| Encoding::Level { bits, min, max })
}

/// The fewest bits of a counter.
pub(super) const LEAST_COUNTER_BITS: u64 = 8;

/// The encodings of two counters.
pub(super) fn counters(bits: Option<u8>) -> Vec<Encoding> {
    alloc::vec![bits.map_or(Encoding::Float64, |bits| Encoding::Counter { bits }); 2]
}

/// The largest value that a sensor of so many bits can tell, where nothing else says it.
pub(super) fn maximum(
    path: &Path,
    max: Option<Number<Positive>>,
    bits: Option<u8>,
) -> Result<f64, FieldError> {
    match (max, bits) {
        (Some(max), _) => Ok(max.get()),
        (None, None) => Ok(f64::MAX),
        (None, Some(_)) => {
            Err(path.field("max").error("is needed with `bits`: the value of the largest code"))
        }
    }
}

/// How many rays a fan has.
pub(super) type Rays = Number<Whole<1, 10_000, u16>>;

/// The data sheet of a kind that has no fields of its own.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct NoFields {}

/// A part of a reading: what its column in a table is called, with its unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Component {
    /// Empty if the sensor has only this one.
    pub name: &'static str,
    /// SI unit, `1` for a ratio.
    pub unit: &'static str,
    /// The number of its values: 1, or the number of a scan's rays.
    pub count: usize,
}

impl Component {
    pub(super) const fn one(name: &'static str, unit: &'static str) -> Self {
        Self { name, unit, count: 1 }
    }
}

/// The effects of a read besides values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Effect {
    /// The time for which the device keeps the microcontroller waiting, in nanoseconds.
    pub(crate) wait_ns: u64,
    /// A pulse that others hear.
    pub(crate) ping: Option<Ping>,
}

impl Effect {
    /// Nothing besides.
    pub(super) const NONE: Self = Self { wait_ns: 0, ping: None };
}

/// The state that a device keeps between two reads. It is part of the world's state: the order of its variants is the form in
/// which states are saved and hashed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Memory {
    None(()),
    Odometer(odometer::Estimate),
    Encoders(encoder::Seen),
    Filter(lowpass::LowPass),
    Accelerometer([lowpass::LowPass; 2]),
    Gps(Box<gps::Wander>),
    Touch(touch::Contact),
    OpticalFlow(Box<optical_flow::Track>),
    StrainGauge(strain_gauge::Load),
}

impl Memory {
    /// Visits its streams of random numbers.
    pub(crate) fn each_stream(&mut self, visit: &mut impl FnMut(&mut Stream)) {
        match self {
            Self::Gps(wander) => wander.each_stream(visit),
            Self::None(())
            | Self::Odometer(_)
            | Self::Encoders(_)
            | Self::Filter(_)
            | Self::Accelerometer(_)
            | Self::Touch(_)
            | Self::OpticalFlow(_)
            | Self::StrainGauge(_) => {}
        }
    }

    /// Whether a device can remember this that remembered `first` before its first read.
    pub(crate) fn is_sound(&self, first: &Self) -> bool {
        let is_kind = core::mem::discriminant(self) == core::mem::discriminant(first);
        is_kind
            && match self {
                Self::None(()) | Self::Touch(_) => true,
                Self::Odometer(estimate) => estimate.is_sound(),
                Self::Encoders(seen) => seen.is_sound(),
                Self::Filter(filter) => filter.is_sound(),
                Self::Accelerometer(filters) => filters.iter().all(lowpass::LowPass::is_sound),
                Self::Gps(wander) => wander.is_sound(),
                Self::OpticalFlow(track) => track.is_sound(),
                Self::StrainGauge(load) => load.is_sound(),
            }
    }
}

/// The memory of devices of some kind, as a part of [`Memory`].
pub(crate) trait Part: Default + Into<Memory> {
    /// `None` if it is the memory of another kind.
    fn of(memory: &mut Memory) -> Option<&mut Self>;
}

macro_rules! parts {
    ($($variant:ident($part:ty)),* $(,)?) => {$(
        impl From<$part> for Memory {
            fn from(part: $part) -> Self {
                Self::$variant(part)
            }
        }

        impl Part for $part {
            fn of(memory: &mut Memory) -> Option<&mut Self> {
                if let Memory::$variant(part) = memory { Some(part) } else { None }
            }
        }
    )*};
}

parts! {
    None(()),
    Odometer(odometer::Estimate),
    Encoders(encoder::Seen),
    Filter(lowpass::LowPass),
    Accelerometer([lowpass::LowPass; 2]),
    Gps(Box<gps::Wander>),
    Touch(touch::Contact),
    OpticalFlow(Box<optical_flow::Track>),
    StrainGauge(strain_gauge::Load),
}
