//! The times of messages, so that the cable is free when a command has to answer the next message.
//!
//! A command that is sent between two messages is still on a slow cable when the second comes. Its answer then goes out
//! late, between that message and the next, and so on for ever: each command answers a message that is nearly a period old.
//! So a brain that has missed a message waits for the next one before it sends.

use baudbot_brain::{Body, Turn};

/// When the microcontroller's messages come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Beat {
    /// They come by themselves, and not when asked for.
    streams: bool,
    /// Time that a command takes on the cable, in nanoseconds.
    command_ns: u64,
    /// When the last one came.
    heard_ns: Option<u64>,
    /// How long after the one before that was.
    interval_ns: Option<u64>,
}

impl Beat {
    /// That of a robot with this body, of which nothing has come.
    pub(crate) fn new(body: &Body) -> Self {
        let (streams, command_ns) = (body.firmware.period_ns.is_some(), body.command_ns());
        Self { streams, command_ns, heard_ns: None, interval_ns: None }
    }

    /// Takes in a turn, and says whether it brought a message of the microcontroller.
    pub(crate) fn hear(&mut self, turn: &Turn) -> bool {
        let mut readings = turn.body.sensors.iter().zip(&turn.readings);
        let is_heard = readings.any(|(sensor, reading)| {
            sensor.is_on_wire() && reading.as_ref().is_some_and(|reading| reading.readable)
        });
        if is_heard {
            self.interval_ns = self.heard_ns.map(|before_ns| turn.at_ns.saturating_sub(before_ns));
            self.heard_ns = Some(turn.at_ns);
        }
        is_heard
    }

    /// When the next message is due, in nanoseconds, if a command that is sent at this instant would still be on the cable
    /// then.
    pub(crate) fn in_the_way_of(&self, at_ns: u64) -> Option<u64> {
        let next_ns = self.heard_ns?.saturating_add(self.interval_ns?);
        let is_in_the_way = next_ns > at_ns && next_ns < at_ns.saturating_add(self.command_ns);
        (self.streams && is_in_the_way).then_some(next_ns)
    }
}
