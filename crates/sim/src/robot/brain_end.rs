//! The brain's end of a robot's port: when it thinks, and what it writes.

use baudbot_wire::frame;

use super::Robot;
use crate::drive::Wheels;
use crate::link::{Command, Link, Message};
use crate::model::RobotSpec;
use crate::time::SimTime;
use crate::timeline::What;

/// The bytes or the command that a brain hands to its port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Written<'a> {
    /// Bytes for the microcontroller; may be none.
    Bytes(&'a [u8]),
    /// A command in the firmware's own form. Nothing is written if there are not as many signals as actuators.
    Command {
        /// The command's sequence number, if the protocol has one.
        sequence: u8,
        /// Signals for the wheels.
        wheels: Wheels,
        /// Signals for the other actuators, in their order.
        others: &'a [f64],
    },
}

impl Robot {
    /// The instant at which a brain is done that thinks from `begun` to `until`: on board it waits for the processor
    /// first.
    pub(crate) fn think(&mut self, spec: &RobotSpec, begun: SimTime, until: SimTime) -> SimTime {
        match spec.link {
            Link::Onboard => self.microcontroller.think(begun, until.since(begun)),
            Link::Ideal | Link::Uart(_) | Link::Usb(_) => until,
        }
    }

    /// Hands the brain's output to its port at `at`.
    pub(crate) fn answer(&mut self, spec: &RobotSpec, at: SimTime, written: &Written<'_>) {
        let begun = self.laptop.busy_until;
        let at = self.think(spec, begun, at.max(begun));
        self.laptop.busy_until = at;
        match *written {
            Written::Bytes(bytes) => self.write(spec, at, bytes),
            Written::Command { sequence, wheels, others } => {
                self.command(spec, at, Command { sequence, wheels, others: others.to_vec() });
            }
        }
    }

    /// The brain writes to its port at `at`. What the laptop's driver has no room for is refused.
    pub(crate) fn write(&mut self, spec: &RobotSpec, at: SimTime, bytes: &[u8]) {
        self.lay_down_command(spec);
        if at.as_ns() < spec.processor.bootloader_ns {
            self.downlink.lose_before(&spec.link, at);
        }
        self.laptop.has_stepped = true;
        let room = spec.link.laptop_buffer().saturating_sub(self.downlink.waiting(&spec.link, at));
        let taken = bytes.len().min(room);
        self.downlink.counters.refused_bytes += (bytes.len() - taken) as u64;
        if taken == 0 {
            return;
        }
        let message = Message { cycle: self.note_write(spec, at, taken), ..Message::default() };
        let (_, until) = self.downlink.send_message(&spec.link, at, &bytes[..taken], message);
        self.recorder.note(at, until, What::Down { bytes: taken as u32 });
    }

    /// The brain writes a command, which may go as it is where nothing can happen to its bytes.
    fn command(&mut self, spec: &RobotSpec, at: SimTime, command: Command) {
        let Some(len) = self.microcontroller.len_at_once(spec, &self.downlink, &command) else {
            return self.write(spec, at, spec.firmware.command(&command, &mut [0; frame::MAX_FRAME]));
        };
        self.laptop.has_stepped = true;
        let message = Message { cycle: self.note_write(spec, at, len), ..Message::default() };
        let (_, until) = self.downlink.send_command((at, len), command, message);
        self.recorder.note(at, until, What::Down { bytes: len as u32 });
    }

    /// The instant at which the control cycle began that is answered with so many bytes at `at`.
    fn note_write(&mut self, spec: &RobotSpec, at: SimTime, bytes: usize) -> Option<SimTime> {
        let is_late = self.laptop.answers_tick.is_some();
        let cycle = self.laptop.answer();
        let is_asked = cycle.is_some() || (self.laptop.informed && !is_late);
        if self.writes.note(spec, at, bytes, is_asked) {
            self.cycles.exceptions.writes += 1;
        }
        cycle
    }

    /// A command that is under way as it is becomes bytes.
    pub(crate) fn lay_down_command(&mut self, spec: &RobotSpec) {
        if let Some((at, command)) = self.downlink.take_command(SimTime::NEVER) {
            self.downlink.lay_down(at, spec.firmware.command(&command, &mut [0; frame::MAX_FRAME]));
        }
    }

    /// The brain's step that began at `begun` is over: it has written what it wanted to.
    pub(crate) fn step_over(&mut self, spec: &RobotSpec, begun: SimTime) {
        let informed = self.laptop.informed;
        if core::mem::take(&mut self.laptop.has_stepped) {
            self.recorder.note(begun, self.laptop.busy_until, What::Think { informed });
        }
        if let Some(cycle) = self.laptop.left_unanswered() {
            self.cycles.leave(&spec.deadline, cycle);
        }
    }
}
