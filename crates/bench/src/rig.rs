//! A world and what steers its robots, in one process, as fast as it goes.

use baudbot_sim::drive::Wheels;
use baudbot_sim::{Answer, Scenario, World, Written};

use crate::driver::Driver;

/// A world whose robots drive by what they sense.
pub struct Rig {
    world: World,
    drivers: Vec<Driver>,
    sequence: u8,
    /// The commands of a tick.
    commands: Vec<Answer<'static>>,
    /// The threads that the world steps its robots in, if there are several.
    threads: Option<rayon::ThreadPool>,
}

impl Rig {
    /// A world at its start, which keeps no timelines.
    pub fn new(scenario: Scenario) -> Self {
        let drivers = scenario.robots.iter().map(Driver::for_robot).collect();
        let mut world = World::new(scenario.into());
        world.keep_timeline(0);
        Self { world, drivers, sequence: 0, commands: Vec::new(), threads: None }
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

    /// Runs a number of ticks.
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
        self.world.finish_answers(&self.commands);
    }

    /// The command that answers each turn.
    fn think(&mut self) {
        self.commands.clear();
        for turn in self.world.turns() {
            if self.drivers[turn.robot] == Driver::Chip {
                continue;
            }
            let [left, right] = self.drivers[turn.robot].steer(self.world.robot(turn.robot).readings());
            let wheels = Wheels { left, right };
            let written = Written::Command { sequence: self.sequence, wheels, others: &[] };
            self.commands.push(Answer { robot: turn.robot, at: turn.at, written });
        }
        self.sequence = self.sequence.wrapping_add(1);
    }
}

/// The threads that cannot be had.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("--threads {0}: {1}")]
pub struct NoThreads(usize, String);
