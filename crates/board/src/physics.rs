//! The feelings of the parts of a board.

use serde::{Deserialize, Serialize};

/// A part of a wiring: its place in the order in which parts were given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct PartId(pub(crate) u16);

impl PartId {
    /// The place of the part in the order in which parts were given, from 0.
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

/// A wheel that turns uniformly within a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wheel {
    /// The angle at the step's start, in radians, not wrapped.
    pub angle_rad: f64,
    /// The rate throughout the step, in radians per second.
    pub rate_rad_s: f64,
}

/// The physical quantities around a board, each asked for by part and instant.
///
/// Instants are nanoseconds since the board was made. What is asked within a call of
/// [`run_until`](crate::Board::run_until) lies within its step; echoes alone are asked for up to a millisecond ahead.
/// Each function has a default: nothing is there.
pub trait Physics {
    /// The voltage of a sensor, a battery or a potentiometer, in volts. It is multiplied by the part's ratio and then
    /// clipped to the supply.
    fn volts(&mut self, part: PartId, at_ns: u64) -> f64 {
        let _ = (part, at_ns);
        0.0
    }

    /// The time that a reflectance sensor takes to discharge its capacitor, in nanoseconds.
    fn discharge_ns(&mut self, part: PartId, at_ns: u64) -> u64 {
        let _ = (part, at_ns);
        u64::MAX
    }

    /// Whether a switch is pressed in the step that begins now.
    fn is_pressed(&mut self, part: PartId, at_ns: u64) -> bool {
        let _ = (part, at_ns);
        false
    }

    /// The wheel of an encoder in the step that begins now.
    fn wheel(&mut self, part: PartId, at_ns: u64) -> Wheel {
        let _ = (part, at_ns);
        Wheel::default()
    }

    /// The time of a sound that an ultrasonic sensor sends now to the first echo and back, in nanoseconds. None:
    /// there is no echo.
    fn echo_ns(&mut self, part: PartId, at_ns: u64) -> Option<u64> {
        let _ = (part, at_ns);
        None
    }

    /// The magnetic field along the axes of a compass, in gauss.
    fn gauss(&mut self, part: PartId, at_ns: u64) -> [f64; 3] {
        let _ = (part, at_ns);
        [0.0; 3]
    }

    /// The temperature of the chip, in °C.
    fn celsius(&mut self, at_ns: u64) -> f64 {
        let _ = at_ns;
        25.0
    }
}

impl<P: Physics + ?Sized> Physics for &mut P {
    fn volts(&mut self, part: PartId, at_ns: u64) -> f64 {
        (**self).volts(part, at_ns)
    }

    fn discharge_ns(&mut self, part: PartId, at_ns: u64) -> u64 {
        (**self).discharge_ns(part, at_ns)
    }

    fn is_pressed(&mut self, part: PartId, at_ns: u64) -> bool {
        (**self).is_pressed(part, at_ns)
    }

    fn wheel(&mut self, part: PartId, at_ns: u64) -> Wheel {
        (**self).wheel(part, at_ns)
    }

    fn echo_ns(&mut self, part: PartId, at_ns: u64) -> Option<u64> {
        (**self).echo_ns(part, at_ns)
    }

    fn gauss(&mut self, part: PartId, at_ns: u64) -> [f64; 3] {
        (**self).gauss(part, at_ns)
    }

    fn celsius(&mut self, at_ns: u64) -> f64 {
        (**self).celsius(at_ns)
    }
}
