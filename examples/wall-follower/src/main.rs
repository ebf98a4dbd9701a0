//! The program: attaches the brain to its robot, and drives until the run is over.

use std::process::ExitCode;

use baudbot_brains::program;
use wall_follower::Follow;

fn main() -> ExitCode {
    program::brain("wall-follower", |_body, given| {
        let Follow { speed, gain, wanted } = Follow::default();
        Ok(Follow {
            speed: given.number("speed", speed),
            gain: given.number("gain", gain),
            wanted: given.number("wanted", wanted),
        })
    })
}
