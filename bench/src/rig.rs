//! A world and what steers its robots, in one process, as fast as it goes.

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
    /// The threads that the world steps its robots in, if there are several.
    threads: Option<rayon::ThreadPool>,
}

impl Rig {
    /// A world at its start, which keeps no timelines.
    pub fn new(scenario: Scenario) -> Self {
        let drivers = scenario.robots.iter().map(Driver::for_robot).collect();
        let mut world = World::new(scenario.into());
        world.keep_timeline(0);
        Self { world, drivers, sequence: 0, bytes: Vec::new(), commands: Vec::new(), threads: None }
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Steps the robots in so many threads from now on.
    ///
    /// # Errors
    /// If there cannot be as many.
    pub fn set_threads(&mut self, threads: usize) -> Result<(), NoThreads> {
        let pool = || rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let no_threads = |error: rayon::ThreadPoolBuildError| NoThreads(threads, error.to_string());
        self.threads = if threads > 1 { Some(pool().map_err(no_threads)?) } else { None };
        self.world.set_parallel(threads > 1);
        Ok(())
    }

    /// So many ticks.
    pub fn run(&mut self, ticks: u64) {
        match self.threads.take() {
            Some(threads) => {
                threads.install(|| (0..ticks).for_each(|_| self.tick()));
                self.threads = Some(threads);
            }
            None => (0..ticks).for_each(|_| self.tick()),
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
        let robots = &self.world.scenario().robots;
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

/// So many threads cannot be had.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("--threads {0}: {1}")]
pub struct NoThreads(usize, String);
