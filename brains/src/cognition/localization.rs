//! *Laser localization* as a cognitive process: every few seconds a scan is matched with a map, and odometry is corrected for
//! the instant at which the scan was taken, with all that came after (Section 6.3.1).
//!
//! *Deviation*: in the notes it is a motor behaviour, which stops the robot to scan. Here a robot stops if `stop` names a
//! behaviour that stands still: its Γ is raised until the scan is there. Otherwise scans are taken in motion.

use serde::Deserialize;

use super::map_of;
use crate::Chance;
use crate::estimate::Estimate;
use crate::localization::laser::{self, Shrink};
use crate::localization::{Map, refine};
use crate::parameter::ParameterError;
use crate::process::{CognitiveProcess, StepContext};
use crate::registry::BuildContext;
use crate::scan::Scan;
use crate::scanner::Scanner;

/// Parameters: the laser, the map and the search.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Walls of the map, `[x, y, x, y]` in metres.
    pub walls_m: Vec<[f64; 4]>,
    /// Name of the laser.
    #[serde(default = "laser_name")]
    pub laser: String,
    /// Time from one match to the next, in seconds.
    #[serde(default = "every_s")]
    pub every_s: f64,
    /// The search for a match.
    #[serde(default)]
    pub method: Method,
    /// The most rays that are matched.
    #[serde(default = "rays")]
    pub rays: usize,
    /// Poses that the notes' search tries at most: N.
    #[serde(default = "iterations")]
    pub iterations: usize,
    /// Name of a behaviour that stands still, which is to be active while the scan is taken.
    pub stop: Option<String>,
}

/// The search for a match.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// The notes' search: at random around the odometry's pose, Eq. (6.8).
    Search,
    /// A search by least squares on the rays, robustly.
    #[default]
    Refine,
}

fn laser_name() -> String {
    "laser".to_owned()
}

fn every_s() -> f64 {
    5.0
}

fn rays() -> usize {
    171
}

fn iterations() -> usize {
    300
}

/// A process that corrects odometry.
pub struct Localize {
    parameters: Parameters,
    map: Map,
    scanner: Scanner,
    chance: Chance,
    next_ns: u64,
    /// Since when it wants the robot to stand.
    stopped_ns: Option<u64>,
}

impl Localize {
    /// A `Localize` for a robot with this body; an error if it has no such laser.
    ///
    /// # Errors
    /// See [`ParameterError`].
    pub fn new(parameters: &Parameters, context: &BuildContext<'_>) -> Result<Self, ParameterError> {
        let Parameters { laser, every_s, rays, .. } = parameters;
        let scanner = Scanner::new(context.body, laser, *rays)?;
        if !(0.0..=1e6).contains(every_s) {
            return Err(ParameterError::range("every_s", "from 0 to 1000000", *every_s));
        }
        if !(1..=100_000).contains(&parameters.iterations) {
            let found = parameters.iterations as f64;
            return Err(ParameterError::range("iterations", "from 1 to 100000", found));
        }
        if let Some(stop) = &parameters.stop {
            context.check_raised("stop", stop)?;
        }
        let map = map_of(&parameters.walls_m)?;
        let (parameters, chance) = (parameters.clone(), context.chance());
        Ok(Self { parameters, map, scanner, chance, next_ns: 0, stopped_ns: None })
    }

    /// The scan that has just come, if one has, and when it was taken. Of a robot that is to stand for it, only one that
    /// began when it stood.
    fn scan(&mut self, context: &StepContext<'_>) -> Option<(u64, Scan)> {
        self.scanner.hear(context.turn);
        if self.parameters.stop.is_some() {
            self.scanner.forget_before(self.stopped_ns? + SETTLE_NS);
        }
        self.scanner.take(context.beliefs.odometry.as_ref()?)
    }

    /// The robot's pose at this scan, by the map, if that gives one.
    fn locate(&mut self, scan: &Scan, guess: Estimate) -> Option<Estimate> {
        match self.parameters.method {
            Method::Search => {
                let iterations = self.parameters.iterations;
                let search =
                    laser::Parameters { iterations, shrink: Some(Shrink::default()), ..Default::default() };
                let found =
                    laser::localize(&self.map, scan, &guess.world_from_robot, &search, &mut self.chance);
                (found.error < GOOD_ERROR).then(|| Estimate::within(found.world_from_robot, 0.02, 0.01))
            }
            Method::Refine => {
                let unsure = Estimate::within(guess.world_from_robot, 0.05, 0.05);
                let guess = Estimate { covariance: guess.covariance + unsure.covariance, ..guess };
                let found = refine::refine(&self.map, scan, &guess, &Default::default(), &mut self.chance);
                (found.fit > GOOD_FIT).then_some(found.estimate)
            }
        }
    }
}

impl CognitiveProcess for Localize {
    fn step(&mut self, context: &mut StepContext<'_>) {
        let at_ns = context.turn.at_ns;
        if at_ns < self.next_ns || context.beliefs.odometry.is_none() {
            return;
        }
        if let Some(stop) = &self.parameters.stop {
            let stopped_ns = *self.stopped_ns.get_or_insert(at_ns);
            let gives_up = at_ns.saturating_sub(stopped_ns) > GIVE_UP_NS;
            context.set_gamma(stop, if gives_up { 0.0 } else { STOP_GAMMA });
            if gives_up {
                self.stopped_ns = None;
                self.next_ns = at_ns + (self.parameters.every_s.max(1.0) * 1e9) as u64;
                return;
            }
        }
        let Some((taken_ns, scan)) = self.scan(context) else {
            if at_ns.saturating_sub(self.next_ns) > OVERDUE_NS {
                let beliefs = &mut *context.beliefs;
                beliefs.awaited.get_or_insert_with(|| self.scanner.awaited(beliefs.odometry.as_ref()));
            }
            return;
        };
        let guess = context.beliefs.odometry.as_ref().and_then(|odometry| odometry.correctable(taken_ns));
        let Some(guess) = guess else { return };
        let found = self.locate(&scan, guess);
        if let (Some(estimate), Some(odometry)) = (found, &mut context.beliefs.odometry) {
            odometry.correct(taken_ns, estimate);
            context.beliefs.pose = Some(odometry.estimate());
        }
        // A robot that has not found itself tries again with the next scan.
        let pause_s = if found.is_some() { self.parameters.every_s } else { 0.0 };
        self.next_ns = at_ns + (pause_s * 1e9) as u64;
        if pause_s > 0.0 {
            self.scanner.forget();
        }
        if let Some(stop) = self.parameters.stop.as_ref().filter(|_| found.is_some()) {
            context.set_gamma(stop, 0.0);
            self.stopped_ns = None;
        }
    }

    fn leave(&mut self, _: &mut StepContext<'_>) {
        self.stopped_ns = None;
    }
}

/// The wait for a scan after which the process reports it, in nanoseconds.
const OVERDUE_NS: u64 = 2_000_000_000;
/// So long a robot takes to stand still, in nanoseconds.
const SETTLE_NS: u64 = 500_000_000;
/// A robot that stands does not find itself any better after this, in nanoseconds.
const GIVE_UP_NS: u64 = 5_000_000_000;
/// Γ of the behaviour that is to stand still.
const STOP_GAMMA: f64 = 10.0;
/// A matching error (6.8) that is greater is none of this map's.
const GOOD_ERROR: f64 = 0.1;
/// A part of the rays that is less is none of this map's.
const GOOD_FIT: f64 = 0.5;
