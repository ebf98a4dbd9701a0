//! The kinds of parts, and which terminals they have.

use serde::{Deserialize, Serialize};

use super::{
    BridgeKind, Channels, Compass, Encoder, HcSr04, Led, Piezo, Ping, RangeFinder, Reflectance, ServoKind,
    Switch, Voltage,
};
use crate::role::{Port, Role};

/// The kind of a part, with its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Kind {
    /// A voltage: an infrared or light sensor, a potentiometer, a battery behind a divider.
    Voltage(Voltage),
    /// A reflectance sensor that discharges a capacitor.
    Reflectance(Reflectance),
    /// A switch: a whisker, a bumper, a button, the output of a comparator.
    Switch(Switch),
    /// An encoder of a wheel.
    Encoder(Encoder),
    /// An ultrasonic range finder on one pin.
    Ping(Ping),
    /// An ultrasonic range finder on two pins.
    HcSr04(HcSr04),
    /// One channel of an H-bridge, with its motor.
    Bridge(BridgeKind),
    /// A servo.
    Servo(ServoKind),
    /// A light-emitting diode.
    Led(Led),
    /// A piezo buzzer.
    Piezo(Piezo),
    /// A compass on the I²C bus.
    Compass(Compass),
    /// An ultrasonic range finder on the I²C bus.
    RangeFinder(RangeFinder),
}

impl Kind {
    /// The terminals; each must be connected. Supply and ground of a part are not among them.
    pub const fn terminals(&self) -> &'static [Role] {
        match self {
            Self::Encoder(Encoder { channels: Channels::Quadrature, .. }) => &[Role::A, Role::B],
            Self::Encoder(Encoder { channels: Channels::Single, .. }) => &[Role::A],
            Self::HcSr04(_) => &[Role::Trigger, Role::Echo],
            Self::Bridge(BridgeKind::L298N { .. }) => &[Role::In1, Role::In2, Role::Enable],
            Self::Bridge(BridgeKind::Tb6612 { .. }) => &[Role::In1, Role::In2, Role::Pwm, Role::Standby],
            Self::Bridge(BridgeKind::Directed { .. }) => &[Role::Pwm, Role::Direction],
            Self::Bridge(BridgeKind::Shield { .. }) => {
                &[Role::Latch, Role::Clock, Role::Data, Role::Enable, Role::Pwm]
            }
            Self::Compass(_) | Self::RangeFinder(_) => &[Role::Sda, Role::Scl],
            Self::Voltage(_)
            | Self::Reflectance(_)
            | Self::Switch(_)
            | Self::Ping(_)
            | Self::Servo(_)
            | Self::Led(_)
            | Self::Piezo(_) => &[Role::Signal],
        }
    }

    /// The electrical port of one of its terminals.
    pub(crate) const fn port(&self, role: Role) -> Port {
        match self {
            Self::Voltage(_) => Port::Analog,
            Self::Reflectance(_) | Self::Switch(_) | Self::Encoder(_) | Self::Ping(_) => Port::Drives,
            Self::HcSr04(_) if matches!(role, Role::Echo) => Port::Drives,
            Self::HcSr04(_) | Self::Bridge(_) | Self::Servo(_) | Self::Led(_) | Self::Piezo(_) => {
                Port::Listens
            }
            Self::Compass(_) | Self::RangeFinder(_) => Port::Bus,
        }
    }

    /// The address on the I²C bus, 7 bits.
    pub(crate) const fn bus_address(&self) -> Option<u8> {
        match self {
            Self::Compass(_) => Some(Compass::ADDRESS),
            Self::RangeFinder(finder) => Some(finder.address),
            Self::Voltage(_)
            | Self::Reflectance(_)
            | Self::Switch(_)
            | Self::Encoder(_)
            | Self::Ping(_)
            | Self::HcSr04(_)
            | Self::Bridge(_)
            | Self::Servo(_)
            | Self::Led(_)
            | Self::Piezo(_) => None,
        }
    }

    /// Whether the part is content with the shape of a timer's signal, and needs no edges.
    pub(crate) const fn takes_shapes(&self) -> bool {
        match self {
            Self::Bridge(_) | Self::Led(_) | Self::Piezo(_) => true,
            Self::Voltage(_)
            | Self::Reflectance(_)
            | Self::Switch(_)
            | Self::Encoder(_)
            | Self::Ping(_)
            | Self::HcSr04(_)
            | Self::Servo(_)
            | Self::Compass(_)
            | Self::RangeFinder(_) => false,
        }
    }
}
