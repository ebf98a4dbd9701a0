//! The measurement of a robot's sensors.

use super::Tick;
use crate::actuator::ActuatorState;
use crate::battery::BatteryState;
use crate::drive::Motion;
use crate::model::RobotSpec;
use crate::sensor::Measurement;
use crate::time::SimTime;

/// The measurement of a sensor at `now`.
pub(super) fn measurement<'a>(
    spec: &'a RobotSpec,
    tick: &Tick<'a>,
    now: SimTime,
    (motion, actuators, battery): (&'a Motion, &'a [ActuatorState], Option<&'a BatteryState>),
) -> Measurement<'a> {
    Measurement {
        scene: tick.scene,
        drive: &spec.drive,
        motion,
        actuators,
        battery: spec.battery.as_ref().zip(battery),
        noise: tick.noise,
        now,
        near: None,
        tick_start: tick.start,
        tick_end: tick.end,
    }
}
