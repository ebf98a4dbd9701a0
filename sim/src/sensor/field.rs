//! Fields and sounds: scent, temperature, or any scalar that fills the plane; and the loudness of what robots
//! say.

use super::{Measurement, Mount};

/// A sensor of one of the scenario's fields.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldSensor {
    /// Where it sits.
    pub mount: Mount,
    /// Which field, by its place in the surroundings.
    pub field: usize,
}

impl FieldSensor {
    /// The field's value, in its own unit.
    pub(super) fn read(&self, at: &Measurement<'_>) -> f64 {
        let pose = self.mount.world_from_sensor(at);
        at.scene.surroundings.fields[self.field].at(pose.position)
    }
}

/// How loud it is: sounds fall off with the distance, and their loudness adds up. Walls do not muffle them.
#[derive(Clone, Debug, PartialEq)]
pub struct Microphone;

impl Microphone {
    /// The sum of level / d over the other robots' sounds; 1 is a loudspeaker of level 1 at a metre.
    pub(super) fn read(at: &Measurement<'_>) -> f64 {
        let here = at.motion.pose.position;
        let others = at.scene.frozen.sounds.iter().filter(|sound| sound.robot != at.scene.own);
        others.map(|sound| sound.level / (sound.from - here).norm().max(NEAREST_M)).sum()
    }
}

/// A loudspeaker is no point: nearer than this it gets no louder.
const NEAREST_M: f64 = 0.01;
