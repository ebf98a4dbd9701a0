//! Signals on the pins of a robot's chip: a track each, with slices or with numbers.

use std::io::{self, Write};

use baudbot_sim::SimTime;

use super::packet::{
    COUNTER, CounterDescriptor, NO_MERGE, SLICE_BEGIN, SLICE_END, TracePacket, TrackDescriptor, TrackEvent,
};
use super::track::MOST;
use super::writer::{TraceWriter, named, packet, process};

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
        let uuid = self.signal(robot, signal, None)?;
        let begin = named(name.to_owned(), "pin", Vec::new());
        self.put_packet(start, TrackEvent { r#type: Some(SLICE_BEGIN), ..begin }, uuid)?;
        self.put_packet(end, TrackEvent { r#type: Some(SLICE_END), ..TrackEvent::default() }, uuid)
    }

    /// A signal has this number from an instant on.
    ///
    /// # Errors
    /// If it cannot be written, or there is no such signal.
    pub fn signal_value(&mut self, robot: usize, signal: usize, at: SimTime, value: u16) -> io::Result<()> {
        let uuid = self.signal(robot, signal, Some(CounterDescriptor {}))?;
        let counter_value = Some(value.into());
        self.put_packet(
            at,
            TrackEvent { r#type: Some(COUNTER), counter_value, ..TrackEvent::default() },
            uuid,
        )
    }

    /// The track of a signal, which is described before it is used.
    fn signal(&mut self, robot: usize, signal: usize, counter: Option<CounterDescriptor>) -> io::Result<u64> {
        let there_is_none = || {
            let text = format!("robot {robot} has no signal {signal}");
            io::Error::new(io::ErrorKind::InvalidInput, text)
        };
        let code = u16::try_from(signal).map(|place| KIND << 16 | u64::from(place));
        let code = code.map_err(|_| there_is_none())?;
        let uuid = process(robot) | code << 8;
        let this = self.robots.get_mut(robot).ok_or_else(there_is_none)?;
        if this.signals.contains(&signal) {
            return Ok(uuid);
        }
        let mut signals = this.spec.chip.iter().flat_map(|chip| chip.signals());
        let name = signals.nth(signal).ok_or_else(there_is_none)?.label();
        this.signals.insert(signal);
        let descriptor = TrackDescriptor {
            uuid: Some(uuid),
            name: Some(name),
            parent_uuid: Some(process(robot)),
            counter,
            sibling_order_rank: i32::try_from(code * MOST as u64).ok(),
            sibling_merge_behavior: Some(NO_MERGE),
            ..TrackDescriptor::default()
        };
        TracePacket { track_descriptor: Some(descriptor), ..packet() }.write(&mut self.out)?;
        Ok(uuid)
    }
}

/// Behind those of all lanes.
const KIND: u64 = 12;
