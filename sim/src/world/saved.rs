//! A world's state by value: bytes from which the same world is made again, in another process, too.
//!
//! The bytes are those that [`World::hash`] is the fingerprint of. They are a matter of this version of this crate: what is
//! part of the state, and in which order, changes from one to the next. Who keeps them keeps the hash, too, and the
//! [source](crate::scenario::Source) of the scenario.

use alloc::sync::Arc;
use alloc::vec::Vec;

use thiserror::Error;

use super::{State, World};
use crate::intervention::Altered;
use crate::robot::{Robot, RobotSpec};
use crate::scenario::Scenario;

/// Why a state is not one of this scenario's world. Bytes of another version are found out by this, or by their hash.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SavedError {
    /// The bytes are no state.
    #[error("is no state of a world of this version: {0}")]
    Unreadable(postcard::Error),
    /// They are a state of another world.
    #[error("is the state of a world with other {0}")]
    Other(&'static str),
    /// The hash is another.
    #[error(
        "is damaged, or of another version: its fingerprint is {found:016x}, and should be {wanted:016x}"
    )]
    Hash {
        /// Of the world that the bytes are.
        found: u64,
        /// As it was when they were saved.
        wanted: u64,
    },
}

impl World {
    /// The state by value. It has all that makes the future; the robots' timelines, which are of the past, are left out.
    pub fn save(&self) -> Vec<u8> {
        // As with the hash: all of the state's types serialise.
        postcard::to_allocvec(&(&self.state, &self.altered)).expect("the state's types serialise")
    }

    /// The world of this scenario in a state that was saved, of which [`hash`](Self::hash) was `hash`.
    ///
    /// # Errors
    /// Says why the bytes are not that.
    pub fn load(scenario: Arc<Scenario>, saved: &[u8], hash: u64) -> Result<Self, SavedError> {
        let (state, rest): ((State, Altered), _) =
            postcard::take_from_bytes(saved).map_err(SavedError::Unreadable)?;
        let (state, altered) = state;
        if !rest.is_empty() {
            return Err(SavedError::Other("parts"));
        }
        let mut world = Self::new(scenario);
        world.check_form(&state)?;
        let timelines = world.state.robots.iter_mut().map(|robot| core::mem::take(&mut robot.recorder));
        let timelines: Vec<_> = timelines.collect();
        world.state = state;
        for (robot, recorder) in world.state.robots.iter_mut().zip(timelines) {
            robot.recorder = recorder;
        }
        world.alter_again(altered).map_err(|_| SavedError::Other("cables"))?;
        let found = world.hash();
        if found == hash { Ok(world) } else { Err(SavedError::Hash { found, wanted: hash }) }
    }

    /// Whether there is of everything as much as in this world, so that nothing is looked for that is not there.
    fn check_form(&self, other: &State) -> Result<(), SavedError> {
        let State { robots, movers, movables, score, turns, .. } = &self.state;
        let same = |is_same: bool, what| if is_same { Ok(()) } else { Err(SavedError::Other(what)) };
        same(robots.len() == other.robots.len(), "robots")?;
        same(movers.len() == other.movers.len(), "movers")?;
        same(movables.len() == other.movables.len(), "movables")?;
        same(score.has_form_of(&other.score), "zones or floors")?;
        let known = other.turns.iter().all(|turn| turn.robot < robots.len());
        same(known && turns.is_empty(), "turns")?;
        let specs = self.scenario.robots().iter();
        let robots = specs.zip(robots.iter().zip(&other.robots));
        robots.into_iter().try_for_each(|(spec, (robot, other))| check_robot(spec, robot, other))
    }
}

fn check_robot(spec: &RobotSpec, robot: &Robot, other: &Robot) -> Result<(), SavedError> {
    let same = |is_same: bool, what| if is_same { Ok(()) } else { Err(SavedError::Other(what)) };
    same(robot.ports.len() == other.ports.len(), "sensor cables")?;
    same(robot.actuators.len() == other.actuators.len(), "actuators")?;
    same(robot.battery.is_some() == other.battery.is_some(), "batteries")?;
    let sensors = spec.sensors.len();
    let laptop = &other.laptop;
    let counts = [laptop.readings.len(), laptop.freshness.len(), other.microcontroller.channels().len()];
    same(counts == [sensors; 3], "sensors")?;
    let fits = |values: usize, i: usize| values == 0 || values <= spec.sensors[i].encodings.len();
    let readings = laptop.readings.iter().enumerate().all(|(i, reading)| fits(reading.values.len(), i));
    let channels = other.microcontroller.channels().iter().enumerate();
    let samples = channels.into_iter().all(|(i, channel)| fits(channel.values.len(), i));
    same(readings && samples, "values of sensors")
}
