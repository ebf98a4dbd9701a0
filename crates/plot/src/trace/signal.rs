//! Signals on the pins of a robot's chip: a track each, with slices or with numbers.

use std::io::{self, Write};

use baudbot_sim::SimTime;

use super::packet::{COUNTER, TrackEvent};
use super::writer::{TraceWriter, named};
use crate::timing::{self, LaneId};

impl<W: Write> TraceWriter<W> {
    /// Something is on a signal of a robot's chip, which goes by its place among
    /// [all](baudbot_sim::chip::ChipSpec::signals), from an instant to another. On a signal one follows on the other.
    ///
    /// # Errors
    /// If it cannot be written, or there is no such signal.
    pub fn signal_slice(
        &mut self,
        robot: usize,
        signal: usize,
        (start, end): (SimTime, SimTime),
        name: &str,
    ) -> io::Result<()> {
        if end <= start {
            return Ok(());
        }
        let uuid = self.signal(robot, signal)?;
        self.put_slice((start, end), named(name.to_owned(), "pin", Vec::new()), uuid)
    }

    /// A signal has this number from an instant on.
    ///
    /// # Errors
    /// If it cannot be written, or there is no such signal.
    pub fn signal_value(&mut self, robot: usize, signal: usize, at: SimTime, value: u16) -> io::Result<()> {
        let uuid = self.signal(robot, signal)?;
        let event = TrackEvent { counter_value: Some(value.into()), ..TrackEvent::default() };
        self.put_packet(at, COUNTER, event, uuid)
    }

    /// The track of a signal.
    fn signal(&mut self, robot: usize, signal: usize) -> io::Result<u64> {
        let there_is_none = || {
            let text = format!("robot {robot} has no signal {signal}");
            io::Error::new(io::ErrorKind::InvalidInput, text)
        };
        let this = self.robots.get(robot).ok_or_else(there_is_none)?;
        let place = u16::try_from(signal).map_err(|_| there_is_none())?;
        let lane = LaneId::Signal(place);
        if !this.described.contains_key(&lane) && timing::signal(&this.spec, place).is_none() {
            return Err(there_is_none());
        }
        self.track(robot, lane, 0)
    }
}
