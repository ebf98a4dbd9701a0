//! The start of a microcontroller, and its restart.

use super::{Microcontroller, Order};
use crate::drive::Wheels;
use crate::firmware::Mode;
use crate::link::Line;
use crate::model::RobotSpec;
use crate::time::SimTime;

impl Microcontroller {
    /// Begins anew at `now`, apart from what the sensors hold: nothing is to be said or obeyed any more, and the actuators get
    /// no signal. The bootloader waits as `spec` says.
    pub(crate) fn reset(&mut self, spec: &RobotSpec, now: SimTime) {
        self.free_at = now.max(SimTime::from_ns(spec.processor.bootloader_ns));
        if spec.firmware.mode == Mode::Poll {
            self.frame.next = SimTime::NEVER;
        }
        self.decoder = spec.firmware.command_decoder();
        self.orders.clear();
        let others = spec.actuators.iter().map(|_| 0.0).collect();
        self.orders.push_back(Order { at: now, signals: Wheels::default(), others });
    }
}

/// Bytes that came while the bootloader waited are lost; returns whether the receiver is empty then.
#[cold]
#[inline(never)]
pub(super) fn missed_start(spec: &RobotSpec, now: SimTime, downlink: &mut Line) -> bool {
    downlink.lose_before(&spec.link, SimTime::from_ns(spec.processor.bootloader_ns));
    downlink.arrival(&spec.link) > now
}
