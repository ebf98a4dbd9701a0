//! From signals to the bytes of a cable.

use alloc::vec;
use alloc::vec::Vec;

use baudbot_wire::create::{Opening, drive_direct};
use baudbot_wire::{LayoutError, frame, khepera, poll, write_command, write_values};

use crate::action::Signals;
use crate::body::{Body, Protocol};
use crate::layout::WireLayout;

/// Turns signals into the bytes of commands.
#[derive(Clone, Debug)]
pub struct RawCommands {
    layout: WireLayout,
    protocol: Protocol,
    sequence: u8,
    /// The last signals of the actuators besides the wheels.
    others: Vec<f64>,
}

impl RawCommands {
    /// An encoder for the robot with this body.
    ///
    /// # Errors
    /// If the body's encodings are such as no cable can have; those of an attached robot never are.
    pub fn new(body: &Body) -> Result<Self, LayoutError> {
        let layout = body.layout();
        layout.check(body.firmware.protocol)?;
        let others = vec![0.0; body.actuators.len()];
        Ok(Self { layout, protocol: body.firmware.protocol, sequence: 0, others })
    }

    /// The bytes of a command, with a poll behind it where a command does not ask for readings; the actuators besides
    /// the wheels get what was last sent to them, at first 0.
    pub fn command(&mut self, signals: Signals) -> Vec<u8> {
        self.command_with(signals, &[])
    }

    /// The bytes of a command with signals for the actuators besides the wheels, in the order of
    /// [`Body::actuators`]. Those beyond the end of `others` get what was last sent to them, at first 0.
    pub fn command_with(&mut self, signals: Signals, others: &[f64]) -> Vec<u8> {
        let sequence = self.next_command(others);
        let wheels = [signals.left, signals.right];
        let signals = [signals.left, signals.right].into_iter().chain(self.others.iter().copied());
        let (layout, mut bytes) = (self.layout.borrow(), [0; frame::MAX_PAYLOAD]);
        // None can fail: the layout was checked and gets a value for each of its motors.
        match self.protocol {
            Protocol::Bare { .. } => {
                let len = write_values(layout.motors, signals, &mut bytes).unwrap_or(0);
                bytes[..len].to_vec()
            }
            Protocol::Khepera => {
                let len = khepera::write_exchange(&layout, signals, &mut bytes).unwrap_or(0);
                bytes[..len].to_vec()
            }
            Protocol::Create(_) => {
                let opening = if sequence == 0 { self.opening() } else { Vec::new() };
                [&opening[..], &drive_direct(wheels)].concat()
            }
            Protocol::Framed { .. } => {
                let len = write_command(&layout, sequence, signals, &mut bytes).unwrap_or(0);
                framed(&bytes[..len])
            }
        }
    }

    /// The sequence number of the next command, whose signals for the actuators besides the wheels are [`others`](Self::others)
    /// from now on. For a brain in the process of its world, which hands its commands over without bytes.
    pub fn next_command(&mut self, others: &[f64]) -> u8 {
        for (last, &new) in self.others.iter_mut().zip(others) {
            *last = new;
        }
        match self.protocol {
            Protocol::Framed { .. } => self.next_sequence(),
            Protocol::Create(_) => self.next_behind_opening(),
            // Their commands have no number.
            Protocol::Bare { .. } | Protocol::Khepera => 0,
        }
    }

    /// The last signals of the actuators besides the wheels, in the order of [`Body::actuators`].
    pub fn others(&self) -> &[f64] {
        &self.others
    }

    /// The number of the next command, as far as the protocol has any.
    pub fn sequence(&self) -> u8 {
        self.sequence
    }

    /// Goes on where another encoder for the same robot was: at its [`sequence`](Self::sequence) and with its
    /// [`others`](Self::others).
    pub fn go_on(&mut self, sequence: u8, others: &[f64]) {
        self.sequence = sequence;
        for (last, &other) in self.others.iter_mut().zip(others) {
            *last = other;
        }
    }

    /// The bytes of a request for readings; `None` in the bare protocol, which has none. A Create is told again to stream, and
    /// stands.
    pub fn poll(&mut self) -> Option<Vec<u8>> {
        match self.protocol {
            Protocol::Bare { .. } => None,
            Protocol::Framed { .. } => Some(framed(&poll(self.next_sequence()))),
            Protocol::Khepera => Some(khepera::poll(&self.layout.borrow()).to_vec()),
            Protocol::Create(_) => {
                self.next_behind_opening();
                Some(self.opening())
            }
        }
    }

    /// The bytes of a brain that wants nothing in this turn: none, but that a Create must be told once that a program is there.
    pub fn wait(&mut self) -> Vec<u8> {
        match self.protocol {
            Protocol::Create(_) if self.sequence == 0 => {
                self.next_behind_opening();
                self.opening()
            }
            Protocol::Create(_) | Protocol::Framed { .. } | Protocol::Bare { .. } | Protocol::Khepera => {
                Vec::new()
            }
        }
    }

    /// The bytes that a Create gets before anything else.
    fn opening(&self) -> Vec<u8> {
        let opening = Opening { ids: &self.layout.packets };
        let mut bytes = vec![0; opening.size()];
        opening.write(&mut bytes);
        bytes
    }

    /// Only the first command of a Create, which has an opening before it, is number 0.
    fn next_behind_opening(&mut self) -> u8 {
        let sequence = self.sequence;
        self.sequence = sequence.checked_add(1).unwrap_or(1);
        sequence
    }

    fn next_sequence(&mut self) -> u8 {
        let sequence = self.sequence;
        self.sequence = sequence.wrapping_add(1);
        sequence
    }
}

fn framed(payload: &[u8]) -> Vec<u8> {
    let mut bytes = [0; frame::MAX_FRAME];
    // Cannot fail: no payload is longer than the layout's check permits.
    let len = frame::encode(payload, &mut bytes).unwrap_or(0);
    bytes[..len].to_vec()
}
