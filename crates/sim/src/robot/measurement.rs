//! The measurement of a robot's sensors.

use super::{OptionalParts, Tick};
use crate::actuator::ActuatorState;
use crate::drive::Motion;
use crate::model::RobotSpec;
use crate::sensor::Measurement;
use crate::time::SimTime;

/// The measurement of a sensor at `now`.
pub(super) fn measurement<'a>(
    spec: &'a RobotSpec,
    tick: &Tick<'a>,
    now: SimTime,
    (motion, actuators, parts): (&'a Motion, &'a [ActuatorState], &'a OptionalParts),
) -> Measurement<'a> {
    Measurement {
        scene: tick.scene,
        drive: &spec.drive,
        motion,
        actuators,
        battery: spec.battery.as_ref().zip(parts.battery.as_ref()),
        impulses_n_s: parts.impulses_n_s.unwrap_or_default(),
        noise: tick.noise,
        now,
        near: None,
        tick_start: tick.start,
        tick_end: tick.end,
    }
}
