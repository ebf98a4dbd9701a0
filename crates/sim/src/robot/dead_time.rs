//! The delay between the microcontroller and the motors: see [`DelayLine`](crate::motor::DelayLine).

use super::Robot;
use crate::drive::Wheels;
use crate::model::RobotSpec;
use crate::time::SimTime;

impl Robot {
    /// The motor signals in force.
    pub(crate) fn motor_signals(&self) -> Wheels {
        self.parts.delay_line.as_ref().map_or(self.signals, |line| line.signals())
    }

    /// The motor signals at `now` of a robot with a dead time.
    #[cold]
    #[inline(never)]
    pub(crate) fn delay(&mut self, spec: &RobotSpec, now: SimTime) -> Wheels {
        let commanded = (self.commanded_at, spec.drive.motor.takes_effect(self.commanded_at));
        let Some(line) = &mut self.parts.delay_line else { return self.signals };
        line.pass(self.signals, commanded, spec.dead_time_ns, now)
    }
}
