//! Firmware: the microcontroller's messages on its wire, and their meaning at the laptop's end.

use alloc::vec::Vec;

use baudbot_wire::codec::Pace;
use baudbot_wire::{Agreement, Encoding, Layout, WireLayout, frame};

pub use baudbot_wire::Protocol;

pub(crate) use crate::decoder::{Decoder, Found};
use crate::link::{Command, LEAST_BAUD, Uart};
pub(crate) use crate::registers::{Owed, Refusal, Registers, Say};
use crate::schedule::Schedule;
use crate::time::SECOND_NS;

/// A program of the microcontroller, one of a closed set.
#[derive(Clone, Debug, PartialEq)]
pub struct Firmware {
    /// The form of its messages.
    pub protocol: Protocol,
    /// The rule for when readings are sent.
    pub mode: Mode,
    layout: WireLayout,
}

/// The rule for when readings are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// On a schedule of the microcontroller's; of a Create, while there is a stream.
    Stream(Schedule),
    /// In answer to a command, and to a poll in the framed protocol; in that of the Khepera in answer to a poll
    /// alone. Those that come while an answer waits to be sent share it.
    Poll,
}

impl Firmware {
    /// A firmware that sends the components of `sensors`, each with its name, and takes signals for two motors and the other actuators. Those of a
    /// sensor with more components than a message can count, 255, are in none: a brain on board gets them without. Nor are
    /// those of a Khepera's analog inputs, which are asked for one by one.
    pub fn new(
        protocol: Protocol,
        mode: Mode,
        sensors: &[(&str, &[Encoding])],
        motors: Vec<Encoding>,
    ) -> Self {
        let told = |&(name, encodings): &(&'_ str, &'_ [Encoding])| {
            encodings.len() <= usize::from(u8::MAX) && protocol.tells(name)
        };
        let sensors = sensors.iter().map(|own| (own.0, if told(own) { own.1 } else { &[] }));
        Self { protocol, mode, layout: WireLayout::new(protocol, sensors, motors) }
    }

    /// The layout that encodes and decodes this firmware's messages.
    #[inline]
    pub fn layout(&self) -> Layout<'_> {
        self.layout.borrow()
    }

    /// The agreement of both ends of the cable.
    #[inline]
    pub fn agreement(&self) -> Agreement<'_> {
        self.layout.agreement()
    }

    /// The bytes that it has on the heap.
    pub(crate) fn heap_bytes(&self) -> usize {
        self.layout.heap_bytes()
    }

    /// Whether the firmware sends nothing until it has received something.
    pub(crate) fn is_silent_at_first(&self) -> bool {
        self.mode == Mode::Poll || self.protocol.pace() == Pace::Opened
    }

    /// Bytes on the wire of the longest message with all readings.
    pub fn readings_len_max(&self) -> usize {
        self.agreement().readings_len()[1]
    }

    /// Bytes on the wire of the longest command.
    pub fn command_len_max(&self) -> usize {
        self.agreement().command_len()[1]
    }

    /// The least baud rate of a cable on which its messages are separable: a bare one ends when there is silence for
    /// longer than a character takes.
    pub(crate) fn least_baud(&self, uart: &Uart) -> u64 {
        let Protocol::Bare { gap_ns } = self.protocol else { return LEAST_BAUD };
        let bits_ns = u64::from(uart.bits_per_character) * SECOND_NS;
        let character_ns = gap_ns.saturating_sub(uart.adapter.hold_ns() + 1).max(1);
        bits_ns.div_ceil(character_ns).max(LEAST_BAUD)
    }

    /// The bytes of a command, in `out`; none if it has not a signal for each actuator.
    pub(crate) fn command<'a>(&self, command: &Command, out: &'a mut [u8; frame::MAX_FRAME]) -> &'a [u8] {
        let wheels = [command.wheels.left, command.wheels.right];
        let signals = wheels.into_iter().chain(command.others.iter().copied());
        let len = self.agreement().write_command(command.sequence, signals, out).unwrap_or(0);
        &out[..len]
    }

    /// The encoding of one motor signal.
    pub fn motor_encoding(&self) -> Encoding {
        self.layout().motors[0]
    }

    pub(crate) fn reading_decoder(&self) -> Decoder {
        Decoder::of_readings(&self.agreement())
    }

    pub(crate) fn command_decoder(&self) -> Decoder {
        Decoder::of_commands(&self.agreement())
    }
}
