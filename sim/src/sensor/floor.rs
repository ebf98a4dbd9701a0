//! Floor sensor: how bright the floor is under it.

use super::{Measurement, Mount};

/// What a floor sensor is.
#[derive(Clone, Debug, PartialEq)]
pub struct FloorSensor {
    /// Where it sits.
    pub mount: Mount,
}

impl FloorSensor {
    /// Reflectance in [0, 1], 1 for white.
    pub(super) fn read(&self, at: &Measurement<'_>) -> f64 {
        at.scene.surroundings.floor_at(self.mount.world_from_sensor(at).position)
    }
}
