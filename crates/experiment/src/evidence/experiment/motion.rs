//! Motion after a command.

use std::f64::consts::TAU;

use baudbot_run::{BareWorld, LockstepWorld};
use baudbot_sim::World;
use baudbot_sim::motor::Motors;
use serde::Deserialize;

use super::{ExperimentError, lab};
use crate::evidence::at::At;

/// A robot that is commanded to turn on the spot.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TurnStep {
    /// The preset of the robot.
    pub preset: String,
    /// The signal of the right wheel; the left one has its opposite.
    pub signal: f64,
    /// Number of specimens.
    pub specimens: u64,
}

/// The instants of a turn that are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Instant {
    /// The turn has begun: 2 % of the final rate.
    Begin,
    /// The turn has 1 − 1/e of the final rate.
    TimeConstant,
}

/// A robot that drives from a standstill.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Speed {
    /// The preset of the robot.
    pub preset: String,
    /// The full speed, in the units that the points are in.
    pub full: f64,
    /// Time after which the distance is taken, in seconds.
    pub seconds: f64,
}

/// Steps of a stepper motor.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepRate {
    /// The preset of the robot.
    pub preset: String,
}

impl TurnStep {
    /// Times from the write of the command until the robot reaches the instant `name`, in milliseconds.
    pub(super) fn run(&self, name: &str) -> Result<Vec<f64>, ExperimentError> {
        let share = match instant(name)? {
            Instant::Begin => 0.02,
            Instant::TimeConstant => 1.0 - (-1.0_f64).exp(),
        };
        let worlds = lab::specimens(&empty(&self.preset, 1.0), self.specimens)?;
        Ok(worlds.filter_map(|world| self.time_to(world, share)).collect())
    }

    fn time_to(&self, world: World, share: f64) -> Option<f64> {
        let mut world = run(world, 1.0, None);
        let start = world.time();
        let mut rates = Vec::new();
        for _ in 0..2000 {
            tick(&mut world, rates.is_empty().then_some([-self.signal, self.signal]));
            let ms = world.time().since(start) as f64 * 1e-6;
            rates.push((ms, world.robot(0).motion().turn_rate_rad_s));
        }
        let last = rates.last()?.1;
        rates.into_iter().find(|(_, rate)| *rate >= share * last).map(|(ms, _)| ms)
    }
}

fn instant(name: &str) -> Result<Instant, ExperimentError> {
    match name {
        "begins to turn" => Ok(Instant::Begin),
        "has 63 % of its rate" => Ok(Instant::TimeConstant),
        other => Err(ExperimentError::At {
            expected: "`begins to turn` or `has 63 % of its rate`",
            at: At::Name(other.into()),
        }),
    }
}

impl Speed {
    /// The mean speed in mm/s at a command in the robot's own unit.
    pub(super) fn run(&self, command: f64) -> Result<Vec<f64>, ExperimentError> {
        let signal = command / self.full;
        let worlds = lab::specimens(&empty(&self.preset, 10.0), 1)?;
        let speed = |world| {
            let world = run(world, self.seconds, Some([signal; 2]));
            world.robot(0).counters().distance_m / self.seconds * 1e3
        };
        Ok(worlds.map(speed).collect())
    }
}

impl StepRate {
    /// Steps a second of a wheel at this commanded rate.
    pub(super) fn run(&self, rate: f64) -> Result<Vec<f64>, ExperimentError> {
        let mut rates = Vec::new();
        for world in lab::specimens(&empty(&self.preset, 10.0), 1)? {
            let Motors::Stepper(stepper) = &world.robot(0).spec().drive.motor else { continue };
            let (steps_per_turn, full) = (stepper.steps_per_turn, stepper.full_rate_steps_s);
            let world = run(world, 2.0, Some([rate / full; 2]));
            rates.push(world.robot(0).motion().wheel_speed_rad_s.left / TAU * steps_per_turn);
        }
        Ok(rates)
    }
}

fn empty(preset: &str, step_ms: f64) -> String {
    format!("step_ms = {step_ms:?}\n[[robots]]\nname = \"robot\"\npreset = \"{preset}\"\n")
}

/// A tick, in whose turn the brain writes a command, if there is one.
fn tick(world: &mut BareWorld, signals: Option<[f64; 2]>) {
    world.begin();
    if let Some((&turn, signals)) = world.turns().first().zip(signals) {
        lab::command(world, turn, signals);
    }
    world.finish();
}

/// A world after so many seconds, with a command in each tick.
fn run(world: World, seconds: f64, signals: Option<[f64; 2]>) -> BareWorld {
    let mut world = BareWorld::new(world);
    let end_ns = (seconds * 1e9) as u64 + world.time().as_ns();
    while world.time().as_ns() < end_ns {
        tick(&mut world, signals);
    }
    world
}
