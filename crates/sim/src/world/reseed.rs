//! Other random numbers from an instant on: the same past with another future.

use super::World;
use crate::random::Stream;
use crate::robot::Robot;

impl World {
    /// Lets all noise go on with other random numbers from the next tick on. They follow from this seed and from what each stream was,
    /// so that streams stay independent of each other, and two worlds that were the same before differ by chance alone.
    pub fn reseed(&mut self, seed: u64) {
        let mut renew = |stream: &mut Stream| stream.reseed(seed);
        self.state.robots.iter_mut().for_each(|robot| robot.each_stream(&mut renew));
        self.state.movers.iter_mut().for_each(|mover| renew(&mut mover.stream));
    }
}

impl Robot {
    /// Visits all streams of random numbers.
    fn each_stream(&mut self, visit: &mut impl FnMut(&mut Stream)) {
        visit(&mut self.motor_noise.stream);
        for channel in self.microcontroller.channels_mut() {
            visit(&mut channel.stream);
            channel.memory.each_stream(visit);
        }
        self.uplink.each_stream(visit);
        self.downlink.each_stream(visit);
        self.ports.iter_mut().for_each(|port| port.line.each_stream(visit));
        let dialogues = self.parts.dialogues.iter_mut().flatten().flatten();
        dialogues.for_each(|dialogue| dialogue.down.each_stream(visit));
    }
}
