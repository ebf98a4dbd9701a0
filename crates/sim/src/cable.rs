//! Cables as a protocol analyser sees them: the bytes that came over one, with their meaning.

use alloc::vec;
use alloc::vec::Vec;

use baudbot_wire::frame::MAX_FRAME;
use baudbot_wire::meaning::{self, Analyser, Direction, Heard, Item};
use baudbot_wire::nmea::MAX_SENTENCE;

pub use crate::link::Cable;
use crate::model::RobotSpec;
use crate::sensor::port::Format;
use crate::time::SimTime;
use crate::view::RobotView;

impl Cable {
    /// The cables of a robot: none to a brain on board, which has no bytes but those of a protocol that it speaks itself.
    pub fn all(spec: &RobotSpec) -> impl Iterator<Item = Self> {
        let own = (!spec.hands_over()).then_some(Self::Robot);
        own.into_iter().chain(spec.sensors.ports().iter().map(|&i| Self::Sensor(i)))
    }
}

/// Listens to one cable, if the world [keeps its bytes](crate::World::keep_tape).
#[derive(Clone, Debug)]
pub struct Listener {
    cable: Cable,
    analyser: Analyser<Vec<u8>>,
    /// The number of bytes that have been looked at, up and down.
    seen: [u64; 2],
    missed_bytes: u64,
    /// The end of the message of the last byte, up and down.
    message_until: [Option<SimTime>; 2],
}

impl Listener {
    /// A listener at this cable that has received nothing; `None` if the robot has no such cable.
    pub fn new(spec: &RobotSpec, cable: Cable) -> Option<Self> {
        Cable::all(spec).find(|other| *other == cable)?;
        let (up, down) = (vec![0; longest_up(spec, cable)], vec![0; MAX_FRAME]);
        let analyser = Analyser::new([up, down]);
        Some(Self { cable, analyser, seen: [0; 2], missed_bytes: 0, message_until: [None; 2] })
    }

    /// Forgets what it has received: the world is at another time.
    pub fn reset(&mut self, spec: &RobotSpec) {
        if let Some(new) = Self::new(spec, self.cable) {
            *self = new;
        }
    }

    /// The number of bytes that came and were gone before they were looked at.
    pub fn missed_bytes(&self) -> u64 {
        self.missed_bytes
    }

    /// Calls `each` for the items that are complete at `now` and were not when it was last called, with the end of the message
    /// on the wire that each is of, if that is known.
    pub fn look(
        &mut self,
        robot: &RobotView<'_>,
        now: SimTime,
        each: &mut impl FnMut(Item<'_>, Option<SimTime>),
    ) {
        let spec = robot.spec();
        let Some(protocol) = protocol(spec, self.cable) else { return };
        let names: Vec<_> = spec.sensors.iter().map(|sensor| sensor.name.as_str()).collect();
        let cable = meaning::Cable { protocol, names: &names };
        let mut fresh = Vec::new();
        for (direction, seen) in [Direction::Up, Direction::Down].into_iter().zip(&mut self.seen) {
            let Some(tape) = robot.tape(self.cable, direction) else { continue };
            // A tape that is shorter than what was seen is a new one.
            let first = if *seen > tape.total() { 0 } else { *seen };
            let (gone, bytes) = tape.since(first);
            self.missed_bytes += gone;
            *seen = tape.total();
            fresh.extend(bytes.map(|taped| (direction, *taped)));
        }
        // A byte down comes before a byte up at the same instant: a question is before its answer.
        fresh.sort_by_key(|(direction, taped)| (taped.at, *direction == Direction::Up));
        for (direction, taped) in fresh {
            let message_until = &mut self.message_until[usize::from(direction == Direction::Down)];
            let before = core::mem::replace(message_until, taped.message_until);
            let at_ns = taped.at.as_ns();
            let heard = Heard { direction, at_ns, byte: taped.byte };
            self.analyser.push(&cable, heard, &mut |item| {
                let until = if item.to_ns == at_ns { taped.message_until } else { before };
                each(item, until);
            });
        }
        let message_until = self.message_until;
        self.analyser.wait(&cable, now.as_ns(), &mut |item| {
            let until = message_until[usize::from(item.direction == Direction::Down)];
            each(item, until);
        });
    }
}

/// The protocol on a cable.
fn protocol(spec: &RobotSpec, cable: Cable) -> Option<meaning::Protocol<'_>> {
    Some(match cable {
        Cable::Robot => spec.firmware.agreement().meaning(),
        Cable::Sensor(i) => match spec.sensors.get(i)?.port.as_ref()?.format {
            Format::Scip(_) => meaning::Protocol::Scip,
            Format::LineImage => meaning::Protocol::LineImage,
            Format::Nmea { .. } => meaning::Protocol::Nmea,
        },
    })
}

/// Bytes of the longest message to the laptop.
fn longest_up(spec: &RobotSpec, cable: Cable) -> usize {
    let Cable::Sensor(i) = cable else { return MAX_FRAME };
    let sensor = &spec.sensors[i];
    let longest = sensor.port.as_ref().map_or(0, |port| port.longest(&sensor.device));
    longest.max(2 * MAX_SENTENCE)
}
