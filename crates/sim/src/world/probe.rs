//! Debuggers at the chips of robots.

use alloc::sync::Arc;

use super::World;
use crate::chip::Probe;

impl World {
    /// Puts a robot's chip under a debugger from now on, which makes the world stand while it holds the chip. Clones of
    /// the world have none. Answers whether the robot has a chip with a [program](crate::chip).
    pub fn probe(&mut self, robot: usize, probe: Arc<dyn Probe>) -> bool {
        let chip = self.state.robots.get_mut(robot).and_then(|robot| robot.parts.chip.as_mut());
        chip.is_some_and(|chip| {
            chip.put_on(probe);
            true
        })
    }
}
