//! The meaning of the messages on a robot's cables.

use std::collections::BTreeMap;

use baudbot_sim::cable::{Cable, Listener};
use baudbot_sim::timeline::{Event, What};
use baudbot_sim::{SimTime, World};
use baudbot_wire::meaning::{Direction, Item};

/// Something that was sent on a cable.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Said {
    pub(super) cable: Cable,
    pub(super) direction: Direction,
    /// The instant at which its last byte was at the end of the cable.
    pub(super) at: SimTime,
    /// The end of the message on the wire that its last byte is of, if it is known.
    pub(super) message_until: Option<SimTime>,
    pub(super) text: String,
}

/// Listens to all cables of a robot.
pub(super) struct Listeners {
    robot: usize,
    all: Vec<(Cable, Listener)>,
}

impl Listeners {
    /// Listeners to this robot's cables. Its world is made to keep their bytes.
    pub(super) fn new(world: &mut World, robot: usize) -> Self {
        world.keep_tape(robot, MOST_BYTES);
        let spec = &world.scenario().robots[robot];
        let listener = |cable| Some((cable, Listener::new(spec, cable)?));
        Self { robot, all: Cable::all(spec).filter_map(listener).collect() }
    }

    /// Collects the messages since the last call.
    pub(super) fn look(&mut self, world: &World, said: &mut Vec<Said>) {
        let robot = world.robot(self.robot);
        for (cable, listener) in &mut self.all {
            listener.look(&robot, world.time(), &mut |item: Item<'_>, message_until| {
                let (direction, at) = (item.direction, SimTime::from_ns(item.to_ns));
                said.push(Said { cable: *cable, direction, at, message_until, text: item.text.to_owned() });
            });
        }
    }
}

/// The texts of what was sent in events, by the places of these: each text with the message that its last byte is of.
pub(super) fn meanings(events: &[Event], said: &[Said]) -> BTreeMap<usize, String> {
    let mut by_end = BTreeMap::new();
    for (i, event) in events.iter().enumerate() {
        if let Some((cable, direction)) = of(event.what) {
            by_end.insert((place(cable, direction), event.end), i);
        }
    }
    let mut meanings: BTreeMap<usize, String> = BTreeMap::new();
    for one in said {
        let line = place(one.cable, one.direction);
        let found = match one.message_until {
            Some(until) => by_end.get(&(line, until)).copied(),
            // A byte of no known message is of the one that is on the wire when it comes.
            None => by_end.range((line, one.at)..=(line, SimTime::NEVER)).map(|(_, &i)| i).next(),
        };
        let Some(i) = found.filter(|&i| events[i].start <= one.at) else { continue };
        let meaning = meanings.entry(i).or_default();
        if !meaning.is_empty() {
            meaning.push_str("; ");
        }
        meaning.push_str(&one.text);
    }
    meanings
}

/// The cable that an event is on.
fn of(what: What) -> Option<(Cable, Direction)> {
    match what {
        What::Up { .. } => Some((Cable::Robot, Direction::Up)),
        What::Down { .. } => Some((Cable::Robot, Direction::Down)),
        What::Port { sensor, .. } => Some((Cable::Sensor(sensor.into()), Direction::Up)),
        What::PortDown { sensor, .. } => Some((Cable::Sensor(sensor.into()), Direction::Down)),
        What::Acquire { .. }
        | What::Measure { .. }
        | What::Frame { .. }
        | What::Block
        | What::Adapter
        | What::Think { .. }
        | What::Obey
        | What::Act
        | What::Late
        | What::Missed { .. }
        | What::Lost { .. }
        | What::Fault { .. } => None,
    }
}

/// A key of a direction of a cable.
fn place(cable: Cable, direction: Direction) -> (usize, Direction) {
    match cable {
        Cable::Robot => (0, direction),
        Cable::Sensor(i) => (i + 1, direction),
    }
}

/// Bytes of each direction of a cable that are kept of a tick.
const MOST_BYTES: usize = 1 << 18;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_is_told_with_its_own_message() {
        let ms = |ms: u64| SimTime::from_ns(ms * 1_000_000);
        let event = |start, end, what| Event { start: ms(start), end: ms(end), what };
        let events = [
            event(0, 5, What::Down { bytes: 8 }),
            event(2, 9, What::Up { bytes: 3 }),
            event(5, 5, What::Act),
            event(6, 8, What::PortDown { sensor: 1, bytes: 3 }),
        ];
        let said = |cable, direction, at, until: Option<u64>, text: &str| Said {
            cable,
            direction,
            at: ms(at),
            message_until: until.map(ms),
            text: text.to_owned(),
        };
        let laser = Cable::Sensor(1);
        let said = [
            said(Cable::Robot, Direction::Down, 3, Some(5), "D,5,5: set speed 5 5"),
            said(Cable::Robot, Direction::Down, 5, Some(5), "N: ask proximity"),
            // An adapter holds it.
            said(Cable::Robot, Direction::Up, 20, Some(9), "d: speed set"),
            said(laser, Direction::Down, 7, None, "BM: laser on"),
            said(laser, Direction::Down, 9, None, "of none"),
            said(laser, Direction::Down, 5, None, "of none"),
        ];
        let expected = [
            (0, "D,5,5: set speed 5 5; N: ask proximity".to_owned()),
            (1, "d: speed set".to_owned()),
            (3, "BM: laser on".to_owned()),
        ];
        assert_eq!(meanings(&events, &said), BTreeMap::from(expected));
    }
}
