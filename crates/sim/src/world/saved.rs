//! A world's state by value: bytes from which the same world is made again, in another process, too.
//!
//! The bytes are those that [`World::hash`] is the fingerprint of. They are a matter of this version of this crate: what is
//! part of the state, and in which order, changes from one to the next. A program that keeps them must also keep the hash and
//! the [source](crate::scenario::Source) of the scenario.

use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;

use thiserror::Error;

use super::intervention::Altered;
use super::{Ending, State, Turn, World};
use crate::actuator::ActuatorState;
use crate::collision::{Collision, Partner};
use crate::link::Direction;
use crate::model::RobotSpec;
use crate::movable::MovableState;
use crate::robot::{Robot, RobotCounters};
use crate::scenario::Scenario;
use crate::scene::Ping;
use crate::sound;
use crate::time::SimTime;

/// A reason why a state is not one of this scenario's world. Bytes of another version are found out by this, or by
/// their hash.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SavedError {
    /// The bytes are no state.
    #[error("is not the state of a world of this version: {0}")]
    Unreadable(postcard::Error),
    /// The bytes are a state of another world.
    #[error("is the state of a world with other {0}")]
    Other(&'static str),
    /// The hash is another. The right one is not in the error: a deliberate change of a state need not be helped.
    #[error("is damaged, or of another version: its fingerprint is not the one stored with it")]
    Hash,
    /// Something is in it that no run of this scenario comes to.
    #[error("is one that no run reaches: its {0} is impossible")]
    Unsound(&'static str),
}

impl World {
    /// The state by value. It has all that makes the future; the robots' timelines, which are of the past, are left out.
    pub fn save(&self) -> Vec<u8> {
        // The serialisation cannot fail, as with the hash.
        let saved = if self.trails.is_empty() {
            postcard::to_allocvec(&(&self.state, &self.altered))
        } else {
            postcard::to_allocvec(&(&self.state, &self.altered, &self.trails))
        };
        saved.expect("the state's types serialise")
    }

    /// The world of this scenario in a state that was saved, of which [`hash`](Self::hash) was `hash`.
    ///
    /// # Errors
    /// An error with the reason why the bytes are not that.
    pub fn load(scenario: Arc<Scenario>, saved: &[u8], hash: u64) -> Result<Self, SavedError> {
        let (state, rest): ((State, Altered), _) =
            postcard::take_from_bytes(saved).map_err(SavedError::Unreadable)?;
        let (state, altered) = state;
        let mut world = Self::new(scenario);
        let rest = if world.trails.is_empty() { rest } else { world.load_trails(rest)? };
        if !rest.is_empty() {
            return Err(SavedError::Other("parts"));
        }
        if state.tick > LAST_NS / world.scenario.step_ns.max(1) {
            return Err(SavedError::Unsound("tick"));
        }
        world.state.tick = state.tick;
        if !world.alter_again(altered) {
            return Err(SavedError::Other("cables"));
        }
        world.check(&state)?;
        let timelines = world.state.robots.iter_mut().map(|robot| core::mem::take(&mut robot.recorder));
        let timelines: Vec<_> = timelines.collect();
        world.state = state;
        for (robot, recorder) in world.state.robots.iter_mut().zip(timelines) {
            robot.recorder = recorder;
        }
        if world.hash() == hash { Ok(world) } else { Err(SavedError::Hash) }
    }

    /// Takes over trails that were saved; the bytes behind them are left.
    fn load_trails<'a>(&mut self, saved: &'a [u8]) -> Result<&'a [u8], SavedError> {
        let (trails, rest) = postcard::take_from_bytes(saved).map_err(SavedError::Unreadable)?;
        sound(self.scenario.has_trails(&trails), "trails")?;
        self.trails = trails;
        Ok(rest)
    }

    /// Whether this world, which is at its start, may come to that state: there is of everything as much as in this one,
    /// so that nothing is looked for that is not there, and all that can be added to has room.
    fn check(&self, other: &State) -> Result<(), SavedError> {
        let State { robots, movers, movables, score, .. } = &self.state;
        same(robots.len() == other.robots.len(), "robots")?;
        same(movers.len() == other.movers.len(), "movers")?;
        same(movables.len() == other.movables.len(), "movables")?;
        same(score.may_become(&other.score, self.scenario.rules.floor.as_ref()), "zones or floors")?;
        let movers = self.scenario.movers.iter().zip(&other.movers);
        sound(movers.into_iter().all(|(mover, state)| mover.may_be(state)), "movers")?;
        sound(other.movables.iter().all(MovableState::is_sound), "movables")?;
        let known = |turn: &Turn| turn.robot < robots.len() && turn.at <= self.tick_end();
        let in_order = other.turns.windows(2).all(|pair| pair[0].robot < pair[1].robot);
        sound(in_order && other.turns.iter().all(known), "turns")?;
        let has_robot = |name: &String| self.scenario.robots.iter().any(|spec| spec.name == *name);
        sound(other.collisions.iter().all(|collision| has_robot(&collision.robot)), "collisions")?;
        let ending = other.ending.as_ref().is_none_or(|ending| match ending {
            Ending::Collision(Collision { robot, .. })
            | Ending::GoalReached(robot)
            | Ending::BatteryEmpty(robot)
            | Ending::DeadlineMissed(robot) => has_robot(robot),
            Ending::TimeIsOver | Ending::Collisions(_) => true,
            Ending::AllGoals | Ending::Covered | Ending::Sensed => true,
        });
        sound(ending, "ending")?;
        self.check_robots(&other.robots)
    }

    fn check_robots(&self, others: &[Robot]) -> Result<(), SavedError> {
        let is_robot = |i: usize| i < self.state.robots.len();
        let robots = self.scenario.robots.iter().zip(self.state.robots.iter().zip(others));
        robots.into_iter().try_for_each(|(spec, (own, other))| {
            own.check(spec, other, self.time())?;
            let contacts = other.contacts.iter().all(|partner| match partner {
                Partner::Robot(i) => is_robot(*i),
                Partner::Shape(_) => true,
            });
            let pulse = |ping: &Ping| is_robot(ping.robot) && sound::numbers([ping.from.x, ping.from.y]);
            sound(contacts, "contacts")?;
            sound(other.pings.iter().flatten().all(pulse), "pulses")
        })
    }
}

impl Robot {
    /// Whether this robot, which is at its start, may come to that state by `now`.
    fn check(&self, spec: &RobotSpec, other: &Self, now: SimTime) -> Result<(), SavedError> {
        same(self.ports.len() == other.ports.len(), "sensor cables")?;
        same(self.actuators.len() == other.actuators.len(), "actuators")?;
        let (parts, others) = (&self.parts, &other.parts);
        same(parts.battery.is_some() == others.battery.is_some(), "batteries")?;
        same(parts.delay_line.is_some() == others.delay_line.is_some(), "dead times")?;
        same(parts.chip.is_some() == others.chip.is_some(), "chips")?;
        same(parts.currents_a.is_some() == others.currents_a.is_some(), "windings")?;
        sound(others.currents_a.as_ref().is_none_or(sound::wheels), "windings")?;
        same(parts.impulses_n_s.is_some() == others.impulses_n_s.is_some(), "strain gauges")?;
        sound(sound::numbers(others.impulses_n_s.into_iter().flatten()), "contacts")?;
        let chips = parts.chip.as_ref().zip(others.chip.as_ref());
        sound(chips.is_none_or(|(own, other)| own.may_become(other, &spec.link, now)), "chip")?;
        let sensors = spec.sensors.len();
        same(other.microcontroller.channels().len() == sensors, "sensors")?;
        same(other.laptop.readings.len() == sensors, "sensors")?;
        sound(other.motion.is_sound() && sound::wheels(&other.signals), "motion")?;
        sound(other.motor_noise.is_sound(), "motors")?;
        sound(self.microcontroller.may_become(spec, &other.microcontroller, now), "microcontroller")?;
        sound(self.laptop.may_become(spec, &other.laptop), "readings")?;
        let up = other.uplink.is_sound(&spec.link, (Direction::Up, now), sensors);
        let down = other.downlink.is_sound(&spec.link, (Direction::Down, now), sensors);
        sound(up && down, "cable")?;
        // Work that was due before has been done, or there would be years to make up for.
        sound(other.microcontroller.next(&spec.link, &other.downlink).0 >= now, "schedule")?;
        sound(other.ports_are_sound(spec, now), "sensor cables")?;
        sound(other.actuators.iter().all(ActuatorState::is_sound), "actuators")?;
        let battery = spec.battery.as_ref().zip(others.battery.as_ref());
        sound(battery.is_none_or(|(battery, state)| state.is_sound(battery)), "battery")?;
        let line = others.delay_line.as_ref();
        sound(line.is_none_or(|line| line.is_sound(spec.dead_time_ns, now)), "dead time")?;
        let RobotCounters { collisions, distance_m, turns } = other.counters;
        sound(sound::numbers([distance_m]) && [collisions, turns].into_iter().all(sound::count), "counters")?;
        sound(other.cycles.are_sound(), "control cycles")
    }
}

fn same(is_same: bool, what: &'static str) -> Result<(), SavedError> {
    if is_same { Ok(()) } else { Err(SavedError::Other(what)) }
}

fn sound(is_sound: bool, what: &'static str) -> Result<(), SavedError> {
    if is_sound { Ok(()) } else { Err(SavedError::Unsound(what)) }
}

/// No run is as long: there is room for instants behind it.
const LAST_NS: u64 = u64::MAX / 4;
