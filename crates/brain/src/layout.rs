//! The layout of the messages on a robot's cable.

use alloc::vec;
use alloc::vec::Vec;

use baudbot_wire::{Encoding, WireLayout};

use crate::body::{Body, Sensor};

impl Body {
    /// The sensors of which messages have readings, with their places. A brain on board gets its readings without a message,
    /// unless those are lines or packets.
    pub(crate) fn told_sensors(&self) -> impl Iterator<Item = (usize, &Sensor)> {
        let protocol = self.firmware.protocol;
        let has_messages = !self.onboard || protocol.is_dialogue();
        let is_told = move |sensor: &Sensor| sensor.is_on_wire() && protocol.tells(&sensor.name);
        self.sensors.iter().enumerate().filter(move |(_, sensor)| has_messages && is_told(sensor))
    }

    /// The agreement of both ends of the cable, to be used with `baudbot-wire`.
    pub fn layout(&self) -> WireLayout {
        let sensors: Vec<_> =
            self.told_sensors().map(|(_, sensor)| (&*sensor.name, encodings(sensor))).collect();
        let motors = vec![self.motor_encoding; 2 + self.actuators.len()];
        let sensors = sensors.iter().map(|(name, encodings)| (*name, &encodings[..]));
        WireLayout::new(self.firmware.protocol, sensors, motors)
    }

    /// The time of a command on the wire, in nanoseconds, rounded up; of lines of text the longest, with the poll
    /// behind it; 0 on a cable without a baud rate. An adapter's or a radio's delay is not in it. A brain that
    /// commands more often than that fills the cable's buffer, and its commands come ever later.
    pub fn command_ns(&self) -> u64 {
        let layout = self.layout();
        let agreement = layout.agreement();
        self.on_the_wire_ns(agreement.command_len()[1] + agreement.question().len())
    }

    /// The time of a message with all readings on the wire, in nanoseconds, rounded up; 0 on a cable without a baud
    /// rate. An adapter's or a radio's delay is not in it.
    pub fn message_ns(&self) -> u64 {
        let layout = self.layout();
        let agreement = layout.agreement();
        self.on_the_wire_ns(agreement.readings_len()[1] + agreement.preface().positions[1])
    }

    fn on_the_wire_ns(&self, bytes: usize) -> u64 {
        let (Some(baud), Some(bits)) = (self.baud, self.bits_per_character) else { return 0 };
        let bits = bytes as u64 * u64::from(bits);
        bits.saturating_mul(1_000_000_000).div_ceil(u64::from(baud.max(1)))
    }
}

/// The encodings of all values of a sensor. No cable has sensors of more than 255 values; one more is enough for the
/// layout's check to find that.
fn encodings(sensor: &Sensor) -> Vec<Encoding> {
    let values = sensor.components.iter().flat_map(|part| core::iter::repeat_n(part.encoding, part.count));
    values.take(usize::from(u8::MAX) + 1).collect()
}
