//! A world and what steers its robots, in one thread, as fast as it goes.

use std::ops::Range;

use baudbot_sim::{Input, Scenario, SimTime, World};
use baudbot_wire::{frame, write_command};

use crate::driver::Driver;

/// A world whose robots drive by what they sense.
pub struct Rig {
    world: World,
    drivers: Vec<Driver>,
    sequence: u8,
    /// The bytes of all commands of a tick, one after the other, and whose they are and when they are sent.
    bytes: Vec<u8>,
    commands: Vec<(usize, SimTime, Range<usize>)>,
}

impl Rig {
    /// A world at its start, which keeps no timelines.
    pub fn new(scenario: Scenario) -> Self {
        let drivers = scenario.robots().iter().map(Driver::for_robot).collect();
        let mut world = World::new(scenario.into());
        world.keep_timeline(0);
        Self { world, drivers, sequence: 0, bytes: Vec::new(), commands: Vec::new() }
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Steps the robots in so many threads from now on.
    ///
    /// # Errors
    /// If this build cannot.
    pub fn set_threads(&mut self, threads: usize) -> Result<(), NoThreads> {
        // The seam for `baudbot-sim` with its feature `rayon`: one call, which the bits of no result depend on.
        if threads == 1 { Ok(()) } else { Err(NoThreads(threads)) }
    }

    /// So many ticks.
    pub fn run(&mut self, ticks: u64) {
        for _ in 0..ticks {
            self.tick();
        }
    }

    /// First half of a tick, a command for each turn, second half.
    pub fn tick(&mut self) {
        self.world.begin();
        self.think();
        let input = |(robot, at, range): &(usize, SimTime, Range<usize>)| Input {
            robot: *robot,
            at: *at,
            bytes: &self.bytes[range.clone()],
        };
        let inputs: Vec<_> = self.commands.iter().map(input).collect();
        self.world.finish(&inputs);
    }

    /// The command that answers each turn, framed as any brain's are.
    fn think(&mut self) {
        self.bytes.clear();
        self.commands.clear();
        let robots = self.world.scenario().robots();
        let (mut payload, mut framed) = ([0; frame::MAX_PAYLOAD], [0; frame::MAX_FRAME]);
        for turn in self.world.turns() {
            let signals = self.drivers[turn.robot].steer(self.world.robot(turn.robot).readings());
            let layout = robots[turn.robot].firmware.layout();
            // Neither can fail: a scenario is read only if its messages fit their frames.
            let len = write_command(&layout, self.sequence, signals, &mut payload).unwrap_or(0);
            let len = frame::encode(&payload[..len], &mut framed).unwrap_or(0);
            let begin = self.bytes.len();
            self.bytes.extend_from_slice(&framed[..len]);
            self.commands.push((turn.robot, turn.at, begin..self.bytes.len()));
        }
        self.sequence = self.sequence.wrapping_add(1);
    }
}

/// There is one thread for a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("--threads {0}: this build steps a world in one thread; leave --threads out")]
pub struct NoThreads(usize);
