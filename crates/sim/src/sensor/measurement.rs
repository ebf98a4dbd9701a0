//! What devices measure.

use baudbot_geometry::Twist;

use crate::actuator::ActuatorState;
use crate::battery::{Battery, BatteryState};
use crate::drive::{Drive, Motion};
use crate::scene::{InSector, Scene};
use crate::time::SimTime;

/// The world as a device measures it: the frozen scene, and the robot's own body and motion.
#[derive(Clone, Copy)]
pub(crate) struct Measurement<'a> {
    pub(crate) scene: &'a Scene<'a>,
    pub(crate) drive: &'a Drive,
    pub(crate) motion: &'a Motion,
    pub(crate) actuators: &'a [ActuatorState],
    /// The robot's battery, if that can run out, and its charge.
    pub(crate) battery: Option<(&'a Battery, &'a BatteryState)>,
    /// The impulses of all contacts so far on the robot's front and on its back, in N s, if a sensor feels them.
    pub(crate) impulses_n_s: [f64; 2],
    pub(crate) noise: bool,
    pub(crate) now: SimTime,
    /// The shapes that the sensor's rays may meet, if they are known.
    pub(crate) near: Option<InSector<'a>>,
    /// The tick: from here …
    pub(crate) tick_start: SimTime,
    /// … to here, with the scene as it is at its start.
    pub(crate) tick_end: SimTime,
}

impl Measurement<'_> {
    /// The robot's motion over ground, whatever its wheels do.
    pub(super) fn over_ground(&self) -> Twist {
        self.scene.surroundings.over_ground(self.drive, self.motion)
    }
}
