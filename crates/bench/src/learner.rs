//! Many worlds stepped from one thread, as a learner steps them: the readings and the signals of the motors are arrays
//! with a row a world, and a step is a control cycle of each world.
//!
//! The scenario is `catalogue/scenarios/wander.toml`: a reading of five sensors every two ticks, 19 bytes up its cable of 9600 baud
//! and a command of 8 bytes down. All 27 bytes go over the simulated line. Between two steps each world stands within a
//! tick, where its brain thinks. A world whose run has ended, by a collision, begins again with another seed.

use std::sync::Arc;

use baudbot_scenario::ScenarioError;
use baudbot_sim::{Input, Scenario, World};
use baudbot_wire::{frame, write_command};

use crate::in_process::{Run, Unfit};
use crate::measure::{self, Effort};
use crate::process::Clock;
use crate::scale::Scale;
use crate::scenario::parse;

/// The use that a learner makes of its worlds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Learner {
    /// The learner steps so many of them.
    Cycles { worlds: usize },
    /// The learner takes one of them back to its start, with another seed.
    Resets,
}

impl Learner {
    /// Measures it.
    pub(crate) fn run(self, effort: Effort, progress: impl FnMut(u32)) -> Result<Run, Unfit> {
        let mut worlds = self.worlds()?;
        let probe_ticks = self.probe_ticks();
        self.work(&mut worlds, probe_ticks);
        worlds.check()?;
        let hash = worlds.hash();
        let mut samples = measure::rate(effort, Clock::Processor, progress, |ticks| {
            self.work(&mut worlds, ticks);
            Ok::<_, Unfit>(())
        })?;
        worlds.check()?;
        let units = self.units_a_tick();
        for sample in &mut samples {
            sample.value *= units;
        }
        let notes = vec![format!("{} runs ended and began again", worlds.ended)];
        Ok(Run { samples, probe_ticks, hash, beside: None, notes })
    }

    /// Runs a number of ticks of each world, or resets of one, from the start; the fingerprint of all worlds after
    /// them.
    pub(crate) fn run_ticks(self, ticks: u64) -> Result<u64, Unfit> {
        let mut worlds = self.worlds()?;
        self.work(&mut worlds, ticks);
        Ok(worlds.hash())
    }

    fn worlds(self) -> Result<Worlds, Unfit> {
        let worlds = match self {
            Self::Cycles { worlds } => worlds,
            Self::Resets => RESETS_AMONG,
        };
        Ok(Worlds::new(worlds)?)
    }

    fn work(self, worlds: &mut Worlds, ticks: u64) {
        match self {
            Self::Cycles { .. } => (0..ticks.div_ceil(TICKS_A_CYCLE)).for_each(|_| worlds.cycle()),
            Self::Resets => (0..ticks).for_each(|_| worlds.reset_next()),
        }
    }

    fn probe_ticks(self) -> u64 {
        match self {
            Self::Cycles { worlds } => (2000 / worlds as u64).max(20),
            Self::Resets => 20,
        }
    }

    /// Two numbers of whole cycles, or of resets.
    pub(crate) fn scale(self) -> Scale {
        let (ticks, unit) = match self {
            Self::Cycles { worlds: 1 } => ([2000, 12_000], "control cycle"),
            // So near the start no robot sees a wall yet, which spares a cycle the rays that hit one. What a cycle costs in a
            // long run is counted of one world.
            Self::Cycles { .. } => ([4, 20], "control cycle"),
            // All of worlds that have run.
            Self::Resets => ([100, RESETS_AMONG as u64], "reset"),
        };
        Scale { ticks, units_a_tick: self.units_a_tick(), unit }
    }

    /// Control cycles of all worlds in a tick of each, or resets in one.
    fn units_a_tick(self) -> f64 {
        match self {
            Self::Cycles { worlds } => worlds as f64 / TICKS_A_CYCLE as f64,
            Self::Resets => 1.0,
        }
    }
}

/// Worlds with one robot each, all within a tick in which a reading has come.
struct Worlds {
    all: Vec<World>,
    /// The readings of each robot's sensors.
    readings: Vec<[f64; SENSORS]>,
    /// Signals for each robot's wheels, left and right.
    commands: Vec<[f64; 2]>,
    sequence: u8,
    /// The seed of the next world that begins.
    seed: u64,
    /// The place of the next world that is taken back.
    next: usize,
    /// The number of runs that have ended.
    ended: u64,
    /// Cycles of a world that has never begun again.
    cycles: u64,
}

impl Worlds {
    fn new(worlds: usize) -> Result<Self, ScenarioError> {
        let scenario = parse(SCENARIO)?;
        let mut all = Self {
            all: (0..worlds as u64).map(|i| begun(&scenario, i)).collect(),
            readings: vec![[0.0; SENSORS]; worlds],
            commands: vec![[0.0; 2]; worlds],
            sequence: 0,
            seed: worlds as u64,
            next: 0,
            ended: 0,
            cycles: 0,
        };
        (0..worlds).for_each(|i| all.listen(i));
        Ok(all)
    }

    /// Every world from a reading to the next one.
    fn cycle(&mut self) {
        steer(&self.readings, &mut self.commands);
        let (mut payload, mut framed) = ([0; frame::MAX_PAYLOAD], [0; frame::MAX_FRAME]);
        for i in 0..self.all.len() {
            let world = &mut self.all[i];
            let layout = world.scenario().robots[0].firmware.layout();
            // Neither can fail: a scenario is read only if its messages fit their frames.
            let len = write_command(&layout, self.sequence, self.commands[i], &mut payload).unwrap_or(0);
            let len = frame::encode(&payload[..len], &mut framed).unwrap_or(0);
            let at = world.turns().first().map_or_else(|| world.time(), |turn| turn.at);
            world.finish(&[Input { robot: 0, at, bytes: &framed[..len] }]);
            self.listen(i);
        }
        self.sequence = self.sequence.wrapping_add(1);
        self.cycles += 1;
    }

    /// On to the tick in which the next reading comes.
    fn listen(&mut self, i: usize) {
        loop {
            let world = &mut self.all[i];
            if world.ending().is_some() {
                self.ended += 1;
                self.reset(i);
                continue;
            }
            world.begin();
            let readings = world.robot(0).readings();
            if readings.iter().any(|reading| reading.readable) {
                for (value, reading) in self.readings[i].iter_mut().zip(readings) {
                    *value = reading.values.first().copied().unwrap_or(0.0);
                }
                return;
            }
            world.finish(&[]);
        }
    }

    /// Takes a world back to its start, with another seed.
    fn reset(&mut self, i: usize) {
        self.all[i] = begun(self.all[i].scenario(), self.seed);
        self.seed += 1;
    }

    fn reset_next(&mut self) {
        self.reset(self.next);
        self.next = (self.next + 1) % self.all.len();
    }

    /// The fingerprints of all worlds in one.
    fn hash(&self) -> u64 {
        self.all.iter().fold(0, |all, world| all.rotate_left(1) ^ world.hash())
    }

    /// Whether each world that has never begun again went through two ticks a cycle, with 27 bytes in each, and whether
    /// robots drive without running into things all the time.
    fn check(&self) -> Result<(), Unfit> {
        let wrong = |what: String| Err(Unfit::NotReal(what));
        for (i, world) in self.all.iter().enumerate().filter(|(i, world)| world.scenario().seed == *i as u64)
        {
            let robot = world.robot(0);
            let ticks = TICKS_A_CYCLE * self.cycles;
            // The first reading comes in the third tick.
            if world.tick().abs_diff(ticks) > TICKS_A_CYCLE {
                return wrong(format!("world {i} had {} ticks in {} cycles", world.tick(), self.cycles));
            }
            let bytes = [robot.uplink().bytes, robot.downlink().bytes];
            let expected = BYTES.map(|bytes| bytes * self.cycles);
            if (0..2).any(|way| bytes[way].abs_diff(expected[way]) > 2 * BYTES[way]) {
                return wrong(format!("world {i} carried {bytes:?} bytes, not {expected:?}"));
            }
            if robot.commands().abs_diff(self.cycles) > 2 {
                return wrong(format!("world {i} obeyed {} of {} commands", robot.commands(), self.cycles));
            }
        }
        let ways_m: f64 = self.all.iter().map(|world| world.robot(0).counters().distance_m).sum();
        let times_s: f64 = self.all.iter().map(|world| world.time().as_seconds()).sum();
        if self.cycles > 0 && (ways_m.is_nan() || ways_m < SLOWEST_M_S * times_s) {
            return wrong(format!("robots drove {ways_m} m in {times_s} s"));
        }
        if self.ended * LEAST_CYCLES > self.cycles * self.all.len() as u64 {
            return wrong(format!("{} runs ended in {} cycles of each world", self.ended, self.cycles));
        }
        Ok(())
    }
}

/// A world of this scenario at its start, with this seed and without timelines.
fn begun(scenario: &Scenario, seed: u64) -> World {
    let mut world = World::new(Arc::new(Scenario { seed, ..scenario.clone() }));
    world.keep_timeline(0);
    world
}

/// A policy without memory, row by row: on, more slowly the nearer something is, and to the left, on the spot, before what
/// is too near.
fn steer(readings: &[[f64; SENSORS]], commands: &mut [[f64; 2]]) {
    for (reading, command) in readings.iter().zip(commands) {
        let nearest = reading.iter().copied().fold(0.0, f64::max);
        let way = 1.0 - nearest / TOO_NEAR;
        *command = if way > 0.0 { [0.15 + 0.35 * way; 2] } else { [-0.5, 0.5] };
    }
}

const SCENARIO: &str = include_str!("../../../catalogue/scenarios/wander.toml");

/// Five infra-red sensors that look ahead.
const SENSORS: usize = 5;

/// A frame every 20 ms, in steps of 10 ms.
const TICKS_A_CYCLE: u64 = 2;

/// A frame of readings up, a command down.
const BYTES: [u64; 2] = [19, 8];

/// A wall squarely ahead is 0.41 m away (`brains/src/avoid/parameters.rs`).
const TOO_NEAR: f64 = 0.28;

/// Worlds of which one after the other is taken back.
const RESETS_AMONG: usize = 1024;

/// Robots that turn at times are slower than their 0.39 m/s.
const SLOWEST_M_S: f64 = 0.02;

/// A run ends by a collision, and not sooner than after so many cycles in the mean.
const LEAST_CYCLES: u64 = 1000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn worlds_are_real_and_the_same_as_ever() {
        for (learner, hash) in [
            (Learner::Cycles { worlds: 1 }, 0x11a4_639c_3134_7040),
            (Learner::Cycles { worlds: 1024 }, 0x3673_775a_f4e1_cfe6),
            (Learner::Resets, 0xb7ea_01ec_5ce4_a4b8),
        ] {
            let mut worlds = learner.worlds().unwrap();
            learner.work(&mut worlds, learner.probe_ticks());
            worlds.check().unwrap_or_else(|error| panic!("{learner:?}: {error}"));
            assert_eq!(worlds.hash(), hash, "{learner:?}: {:x}", worlds.hash());
        }
    }

    #[test]
    fn a_world_among_others_is_what_it_is_alone() {
        let [alone, among] = [1, 3].map(|worlds| {
            let mut worlds = Worlds::new(worlds).unwrap();
            (0..50).for_each(|_| worlds.cycle());
            (worlds.all[0].hash(), worlds.readings[0])
        });
        assert_eq!(alone, among);
        assert!(alone.1.iter().any(|&reading| reading > 0.0), "{:?}", alone.1);
    }

    #[test]
    fn a_reset_world_is_a_new_one_with_the_next_seed() {
        let mut worlds = Worlds::new(2).unwrap();
        (0..10).for_each(|_| worlds.cycle());
        let other = worlds.all[1].hash();
        worlds.reset_next();
        assert_eq!(worlds.all[0].hash(), begun(&parse(SCENARIO).unwrap(), 2).hash());
        assert_eq!(worlds.all[1].hash(), other);
    }

    #[test]
    fn a_run_that_has_ended_begins_again() {
        let mut worlds = Worlds::new(1).unwrap();
        // Into the wall, with full speed.
        for _ in 0..1000 {
            worlds.readings[0] = [0.0; SENSORS];
            worlds.cycle();
        }
        assert!(worlds.ended > 0 && worlds.all[0].scenario().seed == worlds.ended, "{}", worlds.ended);
        assert!(worlds.check().is_err(), "a run that ends all the time is no workload");
    }
}
