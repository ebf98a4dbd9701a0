//! The state of the robot that the microcontroller needs and no sensor has.

use crate::battery::BatteryState;
use crate::drive::{Motion, Wheels};

/// The motion and the supply of a robot.
#[derive(Clone, Copy)]
pub(crate) struct Condition<'a> {
    pub(crate) motion: &'a Motion,
    /// In force.
    pub(crate) signals: Wheels,
    pub(crate) battery: Option<&'a BatteryState>,
}

impl Condition<'_> {
    /// Whether more goes into its battery than out of it.
    pub(super) fn charges(&self) -> bool {
        self.battery.is_some_and(|battery| battery.current_a < 0.0)
    }
}
