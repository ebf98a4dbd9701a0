//! The packets of our sensors.

use super::{Packet, Version};
use crate::encoding::Encoding;

/// The place of a sensor's component: in a packet, or in one bit of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signal {
    /// The packet.
    pub packet: Packet,
    /// The bit, from the least, if it is only one.
    pub bit: Option<u8>,
    /// The number of bits that its encoding must have.
    pub bits: u8,
}

/// The bits of a signal's strength: 0 to 4095 (recalled of both specifications).
const SIGNAL_BITS: u8 = 12;

const fn whole(packet: Packet, bits: u8) -> Signal {
    Signal { packet, bit: None, bits }
}

const fn one(packet: Packet, bit: u8) -> Signal {
    Signal { packet, bit: Some(bit), bits: 1 }
}

/// Names of sensors, their components, and where those stand.
const SIGNALS: [(&str, usize, Signal); 17] = [
    ("bumper_right", 0, one(Packet::BumpsWheelDrops, 0)),
    ("bumper_left", 0, one(Packet::BumpsWheelDrops, 1)),
    ("wall", 0, whole(Packet::WallSignal, SIGNAL_BITS)),
    ("cliff_left", 0, whole(Packet::CliffLeftSignal, SIGNAL_BITS)),
    ("cliff_front_left", 0, whole(Packet::CliffFrontLeftSignal, SIGNAL_BITS)),
    ("cliff_front_right", 0, whole(Packet::CliffFrontRightSignal, SIGNAL_BITS)),
    ("cliff_right", 0, whole(Packet::CliffRightSignal, SIGNAL_BITS)),
    ("battery", 0, whole(Packet::Voltage, 16)),
    ("battery", 1, whole(Packet::Charge, 16)),
    ("encoders", 0, whole(Packet::EncoderLeft, 16)),
    ("encoders", 1, whole(Packet::EncoderRight, 16)),
    ("light_left", 0, whole(Packet::LightLeftSignal, SIGNAL_BITS)),
    ("light_front_left", 0, whole(Packet::LightFrontLeftSignal, SIGNAL_BITS)),
    ("light_center_left", 0, whole(Packet::LightCenterLeftSignal, SIGNAL_BITS)),
    ("light_center_right", 0, whole(Packet::LightCenterRightSignal, SIGNAL_BITS)),
    ("light_front_right", 0, whole(Packet::LightFrontRightSignal, SIGNAL_BITS)),
    ("light_right", 0, whole(Packet::LightRightSignal, SIGNAL_BITS)),
];

impl Signal {
    /// The place of this component, counted from 0, of the sensor of this name; `None` if the robot has no such packet.
    pub fn of(version: Version, sensor: &str, component: usize) -> Option<Self> {
        Self::at(Self::place(version, sensor, component)?)
    }

    /// The place of its row in the table.
    pub(crate) fn place(version: Version, sensor: &str, component: usize) -> Option<u8> {
        let is_it = |(name, own, _): &(&str, usize, Self)| (*name, *own) == (sensor, component);
        let place = SIGNALS.iter().position(is_it)?;
        Packet::of(version, SIGNALS[place].2.packet.id()).map(|_| place as u8)
    }

    /// The one in this place of the table, which is a place of [`Terms`](crate::codec::Terms).
    pub fn at(place: u8) -> Option<Self> {
        SIGNALS.get(usize::from(place)).map(|(_, _, signal)| *signal)
    }

    /// The value that the bits of the packet stand for; `None` if the encoding has no such code.
    pub fn value(self, bits: u16, encoding: Encoding) -> Option<f64> {
        let code = match (self.bit, encoding) {
            (Some(bit), _) => i64::from(bits >> bit & 1),
            (None, Encoding::Counter { .. } | Encoding::Signed { .. }) => i64::from(bits as i16),
            (None, Encoding::Level { .. } | Encoding::Float64) => i64::from(bits),
        };
        encoding.value_of(code)
    }
}

pub(super) const fn bits(encoding: Encoding) -> Option<u8> {
    match encoding {
        Encoding::Float64 => None,
        Encoding::Level { bits, .. } | Encoding::Signed { bits, .. } | Encoding::Counter { bits } => {
            Some(bits)
        }
    }
}
