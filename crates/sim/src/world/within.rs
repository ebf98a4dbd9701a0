//! Programs in simulated time, which act within a tick: what they hear, and what they write.

use alloc::vec::Vec;

use super::World;
use crate::link::{Cable, Line, Link};
use crate::model::{PortUse, RobotSpec};
use crate::robot::{Robot, Tick};
use crate::time::SimTime;

impl World {
    /// Runs the timeline of a robot, whose ports are those of a [program in simulated time](PortUse::Simulated), within the tick that
    /// is [begun](Self::begin), up to `until` and all that happens at it, and not beyond the tick, or up to the first instant at which
    /// bytes for the program have come, which is the answer. Bytes that have come before are to be [taken](Self::take_arrived)
    /// first.
    pub fn hear(&mut self, robot: usize, until: SimTime) -> Option<SimTime> {
        let from = self.time();
        self.within(robot, |robot, spec, tick| {
            robot.advance(spec, tick, (until + 1).min(tick.end), Some(from))
        })?
    }

    /// Takes the bytes that have come for such a program on a cable since the last call in this tick, and puts them behind those in
    /// `into`. Bytes that are not taken by the tick's end are lost to it.
    pub fn take_arrived(&mut self, robot: usize, cable: Cable, into: &mut Vec<u8>) {
        let Self { scenario, state, .. } = self;
        let Some((spec, robot)) = scenario.robots.get(robot).zip(state.robots.get_mut(robot)) else { return };
        if let Some(arrived) = robot.arrived_mut(spec, cable) {
            into.append(arrived);
        }
    }

    /// Such a program writes bytes to a cable at this instant within the tick: they are on it from then on. Nothing may have been
    /// heard or written at a later instant before; if it was, or the tick has not come so far, they are taken for written at the nearest
    /// instant that is possible.
    ///
    /// Answers whether there is such a program and such a cable, the tick is begun, and the run has not ended.
    pub fn write_within(&mut self, robot: usize, cable: Cable, at: SimTime, bytes: &[u8]) -> bool {
        let number = self.tick();
        self.within(robot, |robot, spec, tick| {
            let at = at.max(tick.start).min(SimTime::from_ns(tick.end.as_ns() - 1));
            robot.advance_to(spec, tick, at);
            robot.write_within(spec, number, (cable, at), bytes)
        })
        .unwrap_or(false)
    }

    /// The instant at which all that was written to a cable has left the laptop, as far as that is known now; `None` if there is no
    /// such cable.
    pub fn sent_at(&self, robot: usize, cable: Cable) -> Option<SimTime> {
        self.down(robot, cable).map(|(link, line)| line.free_at(link))
    }

    /// Bytes that the laptop's driver still holds of those that were written to a cable, and the room that there is for more.
    pub fn unsent(&self, robot: usize, cable: Cable, now: SimTime) -> Option<(usize, usize)> {
        let (link, line) = self.down(robot, cable)?;
        let waiting = line.waiting(link, now);
        Some((waiting, link.laptop_buffer().saturating_sub(waiting)))
    }

    fn down(&self, robot: usize, cable: Cable) -> Option<(&Link, &Line)> {
        let (spec, state) = self.scenario.robots.get(robot).zip(self.state.robots.get(robot))?;
        state.down(spec, cable)
    }

    /// Something that happens to a robot within the tick, if its ports are a program's.
    fn within<T>(
        &mut self,
        own: usize,
        act: impl FnOnce(&mut Robot, &RobotSpec, &Tick<'_>) -> T,
    ) -> Option<T> {
        if !self.state.begun || self.state.ending.is_some() {
            return None;
        }
        let (start, end) = (self.time(), self.tick_end());
        let frozen = self.seen.take().unwrap_or_else(|| alloc::boxed::Box::new(self.frozen()));
        let Self { scenario, state, trails, .. } = self;
        let (scenario, trails) = (&**scenario, &*trails);
        let found = scenario.robots.get(own).zip(state.robots.get_mut(own));
        let found = found.filter(|(spec, _)| spec.port_use == PortUse::Simulated);
        let result = found.map(|(spec, robot)| {
            let scene = scenario.scene(&frozen, trails, own);
            let tick = Tick { scene: &scene, noise: scenario.noise, start, end, substeps: scenario.substeps };
            act(robot, spec, &tick)
        });
        self.seen = Some(frozen);
        result
    }
}
