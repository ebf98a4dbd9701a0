//! A program in simulated time at the laptop's end of a robot's cables: it acts within a tick, whenever a byte has come.
//!
//! What it does is an input like that of a brain: the same bytes at the same instants make the same run, whether the timeline stops
//! at each byte that arrives, so that the program can act, or, in a replay, only where the program has written.

use alloc::vec::Vec;

use super::{Robot, Tick};
use crate::link::{Cable, Line, Link};
use crate::model::{PortUse, RobotSpec};
use crate::time::SimTime;

impl Robot {
    /// Whether something has come that its brain waits for.
    #[inline(always)]
    pub(super) fn has_news(&self, spec: &RobotSpec) -> bool {
        match spec.port_use {
            PortUse::Closed | PortUse::Open => self.laptop.has_message,
            PortUse::Simulated => self.has_arrived(),
        }
    }

    /// Out of line: it is asked for each byte, and hardly any robot has such a program.
    #[cold]
    #[inline(never)]
    fn has_arrived(&self) -> bool {
        !self.laptop.arrived.is_empty() || self.ports.iter().any(|port| !port.arrived.is_empty())
    }

    /// Bytes that the program has not taken are of no use to it any more.
    pub(super) fn forget_arrived(&mut self) {
        self.laptop.arrived.clear();
        self.ports.iter_mut().for_each(|port| port.arrived.clear());
    }

    /// The bytes that have arrived on a cable since they were last asked for.
    pub(crate) fn arrived_mut(&mut self, spec: &RobotSpec, cable: Cable) -> Option<&mut Vec<u8>> {
        match cable {
            Cable::Robot => Some(&mut self.laptop.arrived),
            Cable::Sensor(i) => {
                let k = spec.sensors.ports().iter().position(|&other| other == i)?;
                Some(&mut self.ports.get_mut(k)?.arrived)
            }
        }
    }

    /// The program writes at this instant, of which all else has happened. What it has been told by then is what it answers.
    pub(crate) fn write_within(
        &mut self,
        spec: &RobotSpec,
        tick: u64,
        write: (Cable, SimTime),
        bytes: &[u8],
    ) -> bool {
        let (cable, at) = write;
        match cable {
            Cable::Robot => {
                if self.laptop.has_message {
                    self.laptop.hand_over(tick, at);
                    self.counters.turns += 1;
                }
                self.write(spec, at, bytes);
                true
            }
            Cable::Sensor(i) => {
                let is_there = self.write_port(spec, i, at, bytes);
                self.send_written(spec, at);
                is_there
            }
        }
    }

    /// The line on which what is written to a cable goes, with the cable's link as it is now.
    pub(crate) fn down<'a>(&'a self, spec: &'a RobotSpec, cable: Cable) -> Option<(&'a Link, &'a Line)> {
        match cable {
            Cable::Robot => Some((&spec.link, &self.downlink)),
            Cable::Sensor(i) => {
                let k = spec.sensors.ports().iter().position(|&other| other == i)?;
                let dialogue = self.dialogue(k)?;
                Some((dialogue.cable(spec.sensors.get(i)?.port.as_ref()?), &dialogue.down))
            }
        }
    }

    /// The tick's timeline up to this instant and all that happens at it.
    pub(crate) fn advance_to(&mut self, spec: &RobotSpec, tick: &Tick<'_>, at: SimTime) {
        self.advance(spec, tick, (at + 1).min(tick.end), None);
    }
}
