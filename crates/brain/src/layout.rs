//! The layout of the messages on a robot's cable.

use alloc::vec;
use alloc::vec::Vec;

use baudbot_wire::create::{self, Signal, Version};
use baudbot_wire::{Encoding, Layout, LayoutError, frame, khepera};

use crate::body::{Body, Protocol, Sensor};

/// The owner of what a [`Layout`] borrows: how each sensor's and each motor's values cross the wire.
#[derive(Clone, Debug, PartialEq)]
pub struct WireLayout {
    components: Vec<Encoding>,
    counts: Vec<u8>,
    /// The places of the sensors on the wire in the body.
    pub(crate) places: Vec<usize>,
    motors: Vec<Encoding>,
    ages: bool,
    /// The place of each component in a Create's packets.
    pub(crate) signals: Vec<Option<Signal>>,
    /// The packets that tell them.
    pub(crate) packets: Vec<u8>,
}

impl WireLayout {
    fn new(body: &Body) -> Self {
        // A brain on board gets its readings without a message, unless they are lines or packets.
        let has_messages = !body.onboard || body.firmware.protocol.is_dialogue();
        let sensors = || body.sensors.iter().enumerate();
        // A Khepera's analog inputs are asked for one by one.
        let is_input = |sensor: &Sensor| {
            body.firmware.protocol == Protocol::Khepera && khepera::input_number(&sensor.name).is_some()
        };
        let on_wire =
            || sensors().filter(|(_, sensor)| has_messages && sensor.is_on_wire() && !is_input(sensor));
        let counts = on_wire().map(|(_, sensor)| u8::try_from(sensor.values()).unwrap_or(u8::MAX));
        let (signals, packets) = match body.firmware.protocol {
            Protocol::Create(version) => told(version, on_wire().map(|(_, sensor)| sensor)),
            Protocol::Framed { .. } | Protocol::Bare { .. } | Protocol::Khepera => (Vec::new(), Vec::new()),
        };
        Self {
            components: on_wire().flat_map(|(_, sensor)| encodings(sensor)).collect(),
            counts: counts.collect(),
            places: on_wire().map(|(place, _)| place).collect(),
            motors: vec![body.motor_encoding; 2 + body.actuators.len()],
            ages: matches!(body.firmware.protocol, Protocol::Framed { ages: true }),
            signals,
            packets,
        }
    }

    /// The layout.
    pub fn borrow(&self) -> Layout<'_> {
        Layout { components: &self.components, counts: &self.counts, motors: &self.motors, ages: self.ages }
    }

    /// Checks that messages of this protocol can be made of it.
    ///
    /// # Errors
    /// If no cable can have such encodings, or the protocol cannot carry them.
    pub fn check(&self, protocol: Protocol) -> Result<(), LayoutError> {
        self.borrow().check()?;
        match protocol {
            Protocol::Framed { .. } | Protocol::Bare { .. } => Ok(()),
            Protocol::Khepera => khepera::check(&self.borrow()),
            Protocol::Create(_) => create::check(&self.borrow(), &self.signals),
        }
    }

    /// The most bytes that a message of readings takes on the wire.
    fn readings_wire_len(&self, protocol: Protocol) -> usize {
        match protocol {
            Protocol::Framed { .. } => frame::encoded_len_max(self.borrow().readings_len_max()),
            Protocol::Bare { .. } => self.borrow().bare_readings_len(),
            Protocol::Khepera => {
                khepera::readings_len_max(&self.borrow()) + khepera::positions_len(&self.borrow())[1]
            }
            Protocol::Create(version) => create::stream_len(version, &self.packets),
        }
    }

    /// The most bytes that a command takes on the wire.
    fn command_wire_len(&self, protocol: Protocol) -> usize {
        match protocol {
            Protocol::Framed { .. } => frame::encoded_len_max(self.borrow().command_len()),
            Protocol::Bare { .. } => self.borrow().bare_command_len(),
            Protocol::Khepera => {
                khepera::command_len_max(&self.borrow()) + khepera::poll(&self.borrow()).len()
            }
            Protocol::Create(_) => create::drive_direct([0.0; 2]).len(),
        }
    }
}

impl Body {
    /// The layout that both ends of the cable have agreed on, to be used with `baudbot-wire`.
    pub fn layout(&self) -> WireLayout {
        WireLayout::new(self)
    }

    /// The time of a command on the wire, in nanoseconds, rounded up; of lines of text the longest, with the poll
    /// behind it; 0 on a cable without a baud rate. An adapter's or a radio's delay is not in it. A brain that
    /// commands more often than that fills the cable's buffer, and its commands come ever later.
    pub fn command_ns(&self) -> u64 {
        self.on_the_wire_ns(self.layout().command_wire_len(self.firmware.protocol))
    }

    /// The time of a message with all readings on the wire, in nanoseconds, rounded up; 0 on a cable without a baud
    /// rate. An adapter's or a radio's delay is not in it.
    pub fn message_ns(&self) -> u64 {
        self.on_the_wire_ns(self.layout().readings_wire_len(self.firmware.protocol))
    }

    fn on_the_wire_ns(&self, bytes: usize) -> u64 {
        let (Some(baud), Some(bits)) = (self.baud, self.bits_per_character) else { return 0 };
        let bits = bytes as u64 * u64::from(bits);
        bits.saturating_mul(1_000_000_000).div_ceil(u64::from(baud.max(1)))
    }
}

/// The places of these sensors' components, and the packets that have them. A sensor of which a part is in no packet
/// has none.
fn told<'a>(version: Version, sensors: impl Iterator<Item = &'a Sensor>) -> (Vec<Option<Signal>>, Vec<u8>) {
    let mut signals = Vec::new();
    for sensor in sensors {
        let own: Vec<_> =
            (0..encodings(sensor).count()).map(|i| Signal::of(version, &sensor.name, i)).collect();
        let whole = own.iter().all(Option::is_some);
        signals.extend(own.into_iter().map(|signal| signal.filter(|_| whole)));
    }
    let mut packets = [0; create::MOST_STREAMED];
    let count = create::told(&signals, &mut packets);
    (signals, packets[..count].to_vec())
}

/// Those of all values of a sensor. No cable has sensors of more than 255 values; one more is enough for the
/// layout's check to find that.
fn encodings(sensor: &Sensor) -> impl Iterator<Item = Encoding> {
    let values = sensor.components.iter().flat_map(|part| core::iter::repeat_n(part.encoding, part.count));
    values.take(usize::from(u8::MAX) + 1)
}
