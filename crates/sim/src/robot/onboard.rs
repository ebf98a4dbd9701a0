//! A brain on board (Fig. 1.19): it is the microcontroller's program, and reads its sensors where they are read.
//!
//! There is no cable, so nothing is framed and no byte is sent: what would be in a message of the firmware's is handed
//! over as it is, to the resolution that it would have there. So a brain on board may have sensors of any number of
//! values. Its commands come as bytes all the same, since that is how all brains speak to this program.

use crate::link::Link;
use crate::model::RobotSpec;
use crate::robot::Robot;
use crate::time::SimTime;

impl RobotSpec {
    /// Whether readings are handed over without a message. The lines of a Khepera and the packets of a Create
    /// are part of what a brain sees, so one on board gets them too.
    pub fn hands_over(&self) -> bool {
        matches!(self.link, Link::Onboard) && !self.firmware.protocol.is_dialogue()
    }
}

impl Robot {
    /// The brain on board gets what is readable.
    pub(super) fn tell(&mut self, spec: &RobotSpec, now: SimTime) {
        let begun = self.microcontroller.tell(spec, now, &mut self.laptop);
        self.cycles.open(begun);
    }
}
