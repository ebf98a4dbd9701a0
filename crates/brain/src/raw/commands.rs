//! The way from signals to the bytes of a cable.

use alloc::vec;
use alloc::vec::Vec;

use baudbot_wire::{LayoutError, WireLayout, frame};

use crate::action::Signals;
use crate::body::Body;

/// Turns signals into the bytes of commands.
#[derive(Clone, Debug)]
pub struct RawCommands {
    layout: WireLayout,
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
        layout.agreement().check()?;
        Ok(Self { layout, sequence: 0, others: vec![0.0; body.actuators.len()] })
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
        let signals = [signals.left, signals.right].into_iter().chain(self.others.iter().copied());
        // Cannot fail: the layout was checked and gets a value for each of its motors.
        written(|out| self.layout.agreement().write_command(sequence, signals, out).unwrap_or(0))
    }

    /// The sequence number of the next command, whose signals for the actuators besides the wheels are [`others`](Self::others)
    /// from now on. For a brain in the process of its world, which hands its commands over without bytes.
    pub fn next_command(&mut self, others: &[f64]) -> u8 {
        for (last, &new) in self.others.iter_mut().zip(others) {
            *last = new;
        }
        self.layout.agreement().protocol.count(&mut self.sequence)
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

    /// The bytes of a request for readings; `None` in the bare protocol, which has none. A Create gets the command to
    /// stream again, and stands.
    pub fn poll(&mut self) -> Option<Vec<u8>> {
        let agreement = self.layout.agreement();
        let bytes = written(|out| agreement.write_poll(&mut self.sequence, out).unwrap_or(0));
        Some(bytes).filter(|bytes| !bytes.is_empty())
    }

    /// The bytes of a brain without an action in this turn: none, but that a Create must once be sent the presence of a
    /// program.
    pub fn wait(&mut self) -> Vec<u8> {
        let opens = self.layout.agreement().protocol.is_to_be_opened(self.sequence);
        if opens { self.poll().unwrap_or_default() } else { Vec::new() }
    }
}

/// The bytes that `write` puts into a buffer for the longest message.
fn written(write: impl FnOnce(&mut [u8]) -> usize) -> Vec<u8> {
    let mut bytes = [0; frame::MAX_FRAME];
    let len = write(&mut bytes);
    bytes[..len].to_vec()
}
