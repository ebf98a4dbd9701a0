//! A control cycle among the events: from the reads whose values a message carries to the command that answers it.

use std::collections::BTreeSet;

use baudbot_sim::SimTime;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::timeline::{Event, What};

/// A control cycle: (1) sensors are read and their values go up, (2) the brain thinks, (3) its command goes down and is
/// obeyed.
#[derive(Debug, PartialEq)]
pub(super) struct Cycle {
    /// The number of the cycle, from 1.
    pub(super) number: u32,
    /// The instant at which the first read begins whose value is in the message.
    pub(super) start: SimTime,
    /// The instant at which it began: when the message was begun, less what the reads took.
    pub(super) begun: SimTime,
    /// The instant at which the command is obeyed that answers it, if one is.
    pub(super) obeyed: Option<SimTime>,
    /// The instant at which the actuators take that up, if they do.
    pub(super) act: Option<SimTime>,
    /// The places of the cycle's events.
    pub(super) events: BTreeSet<usize>,
}

impl Cycle {
    /// The one with this number among a robot's events since the start of the run. Cycles go by the messages that the
    /// microcontroller lays out.
    pub(super) fn find(robot: &RobotSpec, events: &[Event], number: u32) -> Option<Self> {
        let nth = usize::try_from(number.checked_sub(1)?).ok()?;
        let anchors = || events.iter().enumerate().filter(|(_, event)| is_anchor(event.what));
        let (anchor, event) = anchors().nth(nth)?;
        let begin = event.start;
        let previous = nth.checked_sub(1).and_then(|before| anchors().nth(before));
        let after = previous.map_or(0, |(before, _)| before);
        let events_of = BTreeSet::from([anchor]);
        let mut found =
            Self { number, start: begin, begun: begin, obeyed: None, act: None, events: events_of };
        let mut reading_ns = 0;
        // Events are noted in the order in which the microcontroller does its tasks, also those that take no time.
        for (i, read) in events.iter().enumerate().take(anchor).skip(after) {
            if matches!(read.what, What::Acquire { .. }) {
                found.start = found.start.min(read.start);
                reading_ns += read.end.since(read.start);
                found.events.insert(i);
            }
        }
        found.begun = SimTime::from_ns(begin.as_ns().saturating_sub(reading_ns));
        found.follow(robot, events, event, nth);
        Some(found)
    }

    /// The instant from which on it is late, in nanoseconds since the start of the run: the time step must be longer
    /// than all that takes place in it (§3.2.1), unless the scenario states another deadline.
    pub(super) fn late_from_ns(&self, robot: &RobotSpec) -> u64 {
        self.begun.as_ns().saturating_add(robot.deadline.within_ns)
    }

    /// The end of the latest of its events.
    pub(super) fn end(&self, events: &[Event]) -> SimTime {
        let ends = self.events.iter().filter_map(|i| events.get(*i)).map(|event| event.end);
        ends.max().unwrap_or(self.start)
    }

    /// Follows the n-th message, from 0 on, to the brain and the answer to the actuators, as far as they get.
    fn follow(&mut self, robot: &RobotSpec, events: &[Event], frame: &Event, nth: usize) {
        let (start, end) = (frame.start, frame.end);
        self.take(events, |event| event.what == What::Block && (start..=end).contains(&event.start));
        let What::Frame { bytes } = frame.what else { return };
        let Some(up) = self.take_up(events, (start, bytes), nth) else { return };
        let adapter = |event: &Event| event.what == What::Adapter && event.start == up;
        let there = self.take(events, adapter).unwrap_or(up);
        let think = |event: &Event| event.what == What::Think { informed: true } && event.start >= there;
        let Some(thought) = self.take(events, think) else { return };
        let down = |event: &Event| matches!(event.what, What::Down { .. }) && event.start >= thought;
        let Some(down) = self.take(events, down) else { return };
        // A program that asks for readings besides is obeyed before all that was written has come.
        let asks_besides = !robot.firmware.agreement().question().is_empty();
        let least = if asks_besides { thought + 1 } else { down };
        let Some(obeyed) = self.take(events, |event| event.what == What::Obey && event.end >= least) else {
            return;
        };
        self.obeyed = Some(robot.drive.motor.takes_effect(obeyed));
        self.act = self.take(events, |event| event.what == What::Act && event.start >= obeyed);
    }

    /// Takes the message's way over the wire, which keeps messages in their order: its n-th, if that can be it (some
    /// may have been lost), or else the first that can.
    fn take_up(&mut self, events: &[Event], (start, bytes): (SimTime, u32), nth: usize) -> Option<SimTime> {
        let ups = || events.iter().filter(|event| matches!(event.what, What::Up { .. }));
        let can_be = |event: &Event| event.what == What::Up { bytes } && event.start >= start;
        let own = ups().nth(nth).filter(|up| can_be(up)).copied();
        self.take(events, |event| can_be(event) && own.is_none_or(|own| own == *event))
    }

    /// Takes the first event of a kind, by its begin, as one of its own; when that is over.
    fn take(&mut self, events: &[Event], is_it: impl Fn(&Event) -> bool) -> Option<SimTime> {
        let found = events.iter().enumerate().filter(|(_, event)| is_it(event));
        let (i, event) = found.min_by_key(|(_, event)| event.start)?;
        self.events.insert(i);
        Some(event.end)
    }
}

/// Whether an event is the one by which cycles are counted.
pub(super) fn is_anchor(what: What) -> bool {
    matches!(what, What::Frame { .. })
}

#[cfg(test)]
mod tests {
    use super::super::demo;
    use super::*;

    #[test]
    fn a_cycle_is_followed_from_its_first_read_to_its_act() {
        let (scenario, events) = demo::wander(0, 5);
        let robot = &scenario.robots[0];
        let cycle = Cycle::find(robot, &events, 3).unwrap();
        let kinds: Vec<_> = cycle.events.iter().map(|i| events[*i].what).collect();
        let reads = kinds.iter().filter(|what| matches!(what, What::Acquire { .. })).count();
        assert_eq!((reads, kinds.len()), (5, 11), "{kinds:?}");
        assert_eq!(cycle.start.as_ns(), 40_000_000);
        assert_eq!(cycle.act, Some(cycle.end(&events)));
        assert!(cycle.act.unwrap().since(cycle.start) > 30_000_000, "{cycle:?}");
        assert_eq!((cycle.begun.as_ns(), cycle.late_from_ns(robot)), (40_000_000, 50_000_000));
        assert_eq!(cycle.obeyed.map(SimTime::as_ns), Some(82_700_000));
    }

    #[test]
    fn messages_that_queue_for_the_wire_keep_their_order() {
        let scenario = demo::wander(0, 0).0;
        let event =
            |start, end, what| Event { start: SimTime::from_ns(start), end: SimTime::from_ns(end), what };
        let (frame, up) = (What::Frame { bytes: 9 }, What::Up { bytes: 9 });
        let events = [
            event(0, 1, frame),
            event(2, 3, frame),
            event(4, 5, frame),
            event(1, 10, up),
            event(10, 20, up),
            event(20, 30, up),
        ];
        let cycle = Cycle::find(&scenario.robots[0], &events, 3).unwrap();
        assert_eq!(cycle.events, BTreeSet::from([2, 5]));
    }

    #[test]
    fn a_cycle_without_an_answer_ends_where_it_got_to() {
        let (scenario, events) = demo::wander(0, 3);
        let robot = &scenario.robots[0];
        let silent: Vec<_> =
            events.into_iter().filter(|event| !matches!(event.what, What::Think { .. })).collect();
        let cycle = Cycle::find(robot, &silent, 2).unwrap();
        assert_eq!(cycle.act, None);
        assert!(matches!(silent[*cycle.events.last().unwrap()].what, What::Up { .. }));
        assert_eq!(Cycle::find(robot, &silent, 4), None);
        assert_eq!(Cycle::find(robot, &silent, 0), None);
        assert_eq!(Cycle::find(robot, &[], 1), None);
    }
}
