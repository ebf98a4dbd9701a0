//! The packets of our sensors.

use super::{Packet, Version};
use crate::encoding::Encoding;
use crate::error::LayoutError;
use crate::layout::Layout;

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

/// Of the strength of a signal: 0 to 4095 (recalled of both specifications).
const SIGNAL_BITS: u8 = 12;

impl Signal {
    /// The place of this component, counted from 0, of the sensor of this name; `None` if the robot has no such packet.
    pub fn of(version: Version, sensor: &str, component: usize) -> Option<Self> {
        let whole = |packet, bits| Self { packet, bit: None, bits };
        let one = |packet, bit| Self { packet, bit: Some(bit), bits: 1 };
        let signal = match (sensor, component) {
            ("bumper_right", 0) => one(Packet::BumpsWheelDrops, 0),
            ("bumper_left", 0) => one(Packet::BumpsWheelDrops, 1),
            ("wall", 0) => whole(Packet::WallSignal, SIGNAL_BITS),
            ("cliff_left", 0) => whole(Packet::CliffLeftSignal, SIGNAL_BITS),
            ("cliff_front_left", 0) => whole(Packet::CliffFrontLeftSignal, SIGNAL_BITS),
            ("cliff_front_right", 0) => whole(Packet::CliffFrontRightSignal, SIGNAL_BITS),
            ("cliff_right", 0) => whole(Packet::CliffRightSignal, SIGNAL_BITS),
            ("battery", 0) => whole(Packet::Voltage, 16),
            ("battery", 1) => whole(Packet::Charge, 16),
            ("encoders", 0) => whole(Packet::EncoderLeft, 16),
            ("encoders", 1) => whole(Packet::EncoderRight, 16),
            ("light_left", 0) => whole(Packet::LightLeftSignal, SIGNAL_BITS),
            ("light_front_left", 0) => whole(Packet::LightFrontLeftSignal, SIGNAL_BITS),
            ("light_center_left", 0) => whole(Packet::LightCenterLeftSignal, SIGNAL_BITS),
            ("light_center_right", 0) => whole(Packet::LightCenterRightSignal, SIGNAL_BITS),
            ("light_front_right", 0) => whole(Packet::LightFrontRightSignal, SIGNAL_BITS),
            ("light_right", 0) => whole(Packet::LightRightSignal, SIGNAL_BITS),
            _ => return None,
        };
        Packet::of(version, signal.packet.id()).map(|_| signal)
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

/// The packets that tell these components, each once, in the order in which they are first met; says how many they are.
pub fn told(signals: &[Option<Signal>], out: &mut [u8]) -> usize {
    let mut len = 0;
    for signal in signals.iter().flatten() {
        let id = signal.packet.id();
        if !out[..len].contains(&id) && len < out.len() {
            out[len] = id;
            len += 1;
        }
    }
    len
}

/// Whether a robot can be driven by this layout, whose components are told so. Owners check once, when they are configured.
///
/// # Errors
/// Names the first thing that is wrong.
pub fn check(layout: &Layout<'_>, signals: &[Option<Signal>]) -> Result<(), LayoutError> {
    if layout.motors.len() != 2 {
        return Err(LayoutError::Motors { found: layout.motors.len() });
    }
    for (encoding, signal) in layout.components.iter().zip(signals) {
        let (found, Some(signal)) = (bits(*encoding), signal) else { continue };
        match found {
            None => return Err(LayoutError::NoCode),
            Some(found) if found != signal.bits => {
                return Err(LayoutError::Bits { nearest: signal.bits, found });
            }
            Some(_) => {}
        }
    }
    Ok(())
}

const fn bits(encoding: Encoding) -> Option<u8> {
    match encoding {
        Encoding::Float64 => None,
        Encoding::Level { bits, .. } | Encoding::Signed { bits, .. } | Encoding::Counter { bits } => {
            Some(bits)
        }
    }
}
