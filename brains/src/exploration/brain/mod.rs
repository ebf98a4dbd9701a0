//! A brain that explores: Wahde 2016, §6.1.
//!
//! It needs a laser range finder and an odometer. As in the notes it believes the odometer; with `slam` each scan corrects
//! that, see [`slam`]. Each new reading of the odometer is a step of its [`Explorer`](super::Explorer).
//!
//! *Deviations.*
//!
//! - A scan goes with the pose that the odometer says for the end of its sweep; what the robot's motion has bent is
//!   [corrected](crate::localization::deskew).
//! - Lasers on a turret are not understood.

use baudbot_brain::{Action, Belief, Body, Brain, Point, Signals, Turn};

use super::Command;
use super::scout::{self, Scout};
use crate::awaited::Awaited;
use crate::beat::REPEAT_NS;
use crate::estimate::Estimate;
use crate::mapping::{Occupancy, PlacedScan};
use crate::navigate::ODOMETER;
use crate::odometry::{self, Odometry};
use crate::pace::Pace;
use crate::scanner::Scanner;
use crate::slam::{self, Slam};

mod parameters;
#[cfg(test)]
mod tests;

pub(crate) use parameters::PARAMETERS;
pub use parameters::Parameters;

/// A brain that explores.
pub struct Explore {
    stale_ns: u64,
    scout: Scout,
    scanner: Scanner,
    /// The last scan.
    scan: Option<PlacedScan>,
    /// Time that a command takes on the wire.
    command_ns: u64,
    wheels: odometry::Parameters,
    /// `None` before the odometer's first pose.
    odometry: Option<Odometry>,
    /// The corrections of the odometer, and its map; `None` if the odometer is believed.
    slam: Option<(Slam, Occupancy)>,
    /// The last signals.
    signals: Signals,
    /// The odometer has had news since.
    has_news: bool,
    pace: Pace,
    now_ns: u64,
}

impl Explore {
    /// A brain at its start for a robot with this body; `None` if it has no laser of which a scan can be made, or
    /// no odometer.
    pub fn new(parameters: Parameters, body: &Body) -> Option<Self> {
        body.sensor(ODOMETER).filter(|sensor| sensor.values() >= 3)?;
        let laser = scout::laser(body)?;
        let scanner = Scanner::new(body, &laser.name, usize::MAX).ok()?;
        let wheels = odometry::Parameters::of(body, ODOMETER)?;
        Some(Self {
            stale_ns: parameters.stale_ns(),
            scout: Scout::new(parameters, body, laser.range_m?),
            scanner,
            scan: None,
            command_ns: body.command_ns(),
            wheels: odometry::Parameters { variance_m2_per_m: WHEELS_M2_PER_M, ..wheels },
            odometry: None,
            slam: slam(&parameters),
            signals: Signals::default(),
            has_news: false,
            pace: Pace::new(body),
            now_ns: 0,
        })
    }

    /// The explorer's last command.
    pub const fn command(&self) -> Command {
        self.scout.command()
    }

    /// Takes in what is new; returns whether the odometer had news.
    fn look(&mut self, turn: &Turn) -> bool {
        if self.odometry.is_none() {
            self.odometry = Odometry::starting(self.wheels, turn, ODOMETER, None);
        }
        let has_news = self.odometry.as_mut().is_some_and(|odometry| odometry.read(turn, ODOMETER));
        self.scanner.hear(turn);
        self.scout.feel(turn);
        self.place_scans();
        has_news
    }

    /// Gives scans their poses, once the odometer knows these.
    fn place_scans(&mut self) {
        let Some(odometry) = &mut self.odometry else { return };
        while let Some((at_ns, scan)) = self.scanner.take(odometry) {
            let Some(mut estimate) = odometry.correctable(at_ns) else { continue };
            if let Some((slam, grid)) = &mut self.slam {
                // A scan that fits nowhere is not used for exploring, either.
                let Some(found) = slam.see(grid, &scan, &estimate) else { continue };
                odometry.correct(at_ns, found);
                estimate = found;
            }
            let Estimate { world_from_robot, .. } = estimate;
            self.scan = Some(PlacedScan::new(world_from_robot, scan));
        }
    }

    fn act(&mut self, turn: &Turn) -> Action {
        let at_ns = turn.at_ns;
        let is_blind = self.is_blind(at_ns);
        // A robot that knows no more where it is stops though no message has come.
        if !self.pace.sends(at_ns, is_blind && self.signals != Signals::default()) {
            return Action::wait();
        }
        self.pace.sent(at_ns);
        let odometry = self.odometry.as_ref().filter(|_| !is_blind);
        self.signals = match odometry {
            None => {
                self.scout.pause();
                Signals::default()
            }
            Some(_) if !std::mem::take(&mut self.has_news) => self.signals,
            Some(odometry) => {
                let here = odometry.estimate().world_from_robot;
                let haste = odometry.haste(self.command_ns);
                let Signals { left, right } = self.scout.step(at_ns, &here, self.scan.as_ref(), haste);
                Signals { left: haste * left, right: haste * right }
            }
        };
        Action::drive(self.signals.left, self.signals.right)
    }

    /// Whether the odometer has been silent for too long.
    fn is_blind(&self, at_ns: u64) -> bool {
        self.odometry.as_ref().is_none_or(|odometry| odometry.is_overdue(at_ns, self.stale_ns))
    }

    /// The sensor that it waits for, if it does.
    fn awaited(&self) -> Option<Awaited> {
        let Some(odometry) = &self.odometry else {
            return Some(Awaited { sensor: ODOMETER.to_owned(), since_ns: 0 });
        };
        if self.is_blind(self.now_ns) {
            return Some(odometry.awaited());
        }
        self.scout.waits_for_scan().then(|| self.scanner.awaited(Some(odometry)))
    }
}

impl Brain for Explore {
    fn step(&mut self, turn: &Turn) -> Action {
        self.now_ns = turn.at_ns;
        self.has_news |= self.look(turn);
        self.pace.hear(turn);
        let action = self.act(turn);
        // The sensors may have become silent by then.
        let latest_ns = turn.at_ns.saturating_add(self.command_ns.max(REPEAT_NS));
        let next_ns = self.pace.next_ns(turn.at_ns, false);
        action.until_message_or(next_ns.clamp(turn.at_ns.saturating_add(1), latest_ns))
    }

    fn belief(&mut self) -> Option<Belief> {
        let path = self.scout.path().iter().map(|to| Point { x_m: to.x, y_m: to.y }).collect();
        let pose = self.odometry.as_ref().map(|odometry| odometry.estimate().shown());
        let map = self.slam.as_ref().map(|(_, grid)| grid.shown());
        let state = self.awaited().map_or_else(|| self.scout.intention(), |awaited| awaited.to_string());
        Some(Belief { state, path, pose, map, ..Belief::default() })
    }
}

fn slam(parameters: &Parameters) -> Option<(Slam, Occupancy)> {
    let slam = (parameters.slam >= 0.5).then(|| Slam::new(slam::Parameters::default()))?;
    let grid = slam.grid();
    Some((slam, grid))
}

/// Variance of a wheel's way by the odometer, in square metres for each metre, if it is corrected.
const WHEELS_M2_PER_M: f64 = 1e-3;
