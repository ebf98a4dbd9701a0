//! A step of a brain that gets messages: what has arrived, as the brain sees it.

use alloc::sync::Arc;

use baudbot_brain::{Body, Reading};

use crate::laptop;
use crate::time::SimTime;
use crate::world::{Turn, World};

impl World {
    /// The turn of the brain of messages that steps now: the readings that have arrived, and its robot's data sheet.
    /// `body` is that sheet, made once.
    pub fn turn_of(&self, turn: Turn, body: &Arc<Body>) -> baudbot_brain::Turn {
        let robot = self.robot(turn.robot);
        baudbot_brain::Turn {
            tick: self.tick(),
            at_ns: turn.at.as_ns(),
            readings: robot.readings().iter().map(reading).collect(),
            body: Arc::clone(body),
            has_message: robot.has_heard(),
        }
    }
}

/// `None` if none of the sensor has arrived yet.
fn reading(reading: &laptop::Reading) -> Option<Reading> {
    (!reading.values.is_empty()).then(|| Reading {
        values: reading.values.to_vec(),
        sampled_at_ns: reading.sampled_at.map(SimTime::as_ns),
        sequence: reading.sequence.into(),
        readable: reading.readable,
    })
}
