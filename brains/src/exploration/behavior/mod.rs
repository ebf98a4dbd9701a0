//! Exploration as one behaviour of many: Wahde 2016, §6.1.
//!
//! It goes by the pose that the brain believes: a process of kind `odometry` must be there, and those of kinds `slam` and
//! `laser_localization` correct that. Each time that it is activated it goes on with what it knows, from where it is then.
//!
//! *Deviations.* As those of a [robot that explores by itself](super::brain). A scan that fitted nowhere into the map is
//! explored by, too.

use baudbot_brain::{Body, Signals};

use super::brain::{PARAMETERS, Parameters};
use super::scout::{self, Scout};
use crate::mapping::PlacedScan;
use crate::odometry::Odometry;
use crate::parameter::ParameterError;
use crate::process::{MotorBehavior, StepContext};
use crate::scanner::Scanner;

/// A behaviour that explores.
pub struct ExploreFloor {
    stale_ns: u64,
    scout: Scout,
    scanner: Scanner,
    scan: Option<PlacedScan>,
    /// The instant of odometry's newest reading, and that of its arrival.
    heard_ns: Option<(u64, u64)>,
    /// The behaviour has just been activated, and the motors still have the signals of another.
    is_new: bool,
}

impl ExploreFloor {
    /// An `ExploreFloor` for a robot with this body, by its first laser that sits on that.
    ///
    /// # Errors
    /// If a parameter is invalid, or the robot has no laser of which scans can be made.
    pub fn new(mut parameters: Parameters, body: &Body) -> Result<Self, ParameterError> {
        if parameters.slam != 0.0 {
            let problem = "a process of kind `slam` beside this one makes the map";
            return Err(ParameterError::value("slam", problem));
        }
        for parameter in PARAMETERS {
            let (found, range) = (*(parameter.field)(&mut parameters), &parameter.range);
            if !range.contains(&found) {
                let (least, most) = (range.start(), range.end());
                let allowed = format_args!("from {least} to {most}");
                return Err(ParameterError::range(parameter.name, allowed, found));
            }
        }
        let no_laser = || {
            let problem = format!(
                "robot `{}` has no sensor of kind `laser` with level rays that sits on its body",
                body.name
            );
            ParameterError::Other(problem)
        };
        let laser = scout::laser(body).ok_or_else(no_laser)?;
        let no_range = || {
            let problem = format!("the data sheet of `{}` does not have its range", laser.name);
            ParameterError::Other(problem)
        };
        Ok(Self {
            stale_ns: parameters.stale_ns(),
            scanner: Scanner::new(body, &laser.name, usize::MAX)?,
            scout: Scout::new(parameters, body, laser.range_m.ok_or_else(no_range)?),
            scan: None,
            heard_ns: None,
            is_new: true,
        })
    }

    /// Takes in what has come.
    fn look(&mut self, context: &StepContext<'_>) {
        self.scout.feel(context.turn);
        self.scanner.hear(context.turn);
        let Some(odometry) = &context.beliefs.odometry else { return };
        while let Some((at_ns, scan)) = self.scanner.take(odometry) {
            if let Some(estimate) = odometry.at(at_ns) {
                self.scan = Some(PlacedScan::new(estimate.world_from_robot, scan));
            }
        }
    }
}

impl MotorBehavior for ExploreFloor {
    fn enter(&mut self, _: &mut StepContext<'_>) {
        self.scanner.forget();
        self.scout.interrupt();
        (self.scan, self.is_new) = (None, true);
    }

    fn step(&mut self, context: &mut StepContext<'_>) -> Option<Signals> {
        self.look(context);
        let at_ns = context.turn.at_ns;
        let beliefs = &mut *context.beliefs;
        let known_ns = beliefs.odometry.as_ref().map(Odometry::at_ns);
        let has_news =
            known_ns.is_some_and(|known_ns| self.heard_ns.is_none_or(|(old_ns, _)| known_ns > old_ns));
        if let Some(known_ns) = known_ns.filter(|_| has_news) {
            self.heard_ns = Some((known_ns, at_ns));
        }
        let patience_ns = beliefs.odometry.as_ref().map_or(0, Odometry::patience_ns);
        let stale_ns = self.stale_ns.max(patience_ns);
        let is_fresh = |(_, heard_ns): (u64, u64)| at_ns.saturating_sub(heard_ns) <= stale_ns;
        let Some(odometry) = beliefs.odometry.as_ref().filter(|_| self.heard_ns.is_some_and(is_fresh)) else {
            "does not know where it is".clone_into(&mut beliefs.intention);
            beliefs.path.clear();
            self.scout.pause();
            return Some(Signals::default());
        };
        if !has_news {
            return std::mem::take(&mut self.is_new).then(Signals::default);
        }
        self.is_new = false;
        let here = odometry.estimate().world_from_robot;
        // The time of a command on the cable is not known here. It is a small part of the delay.
        let signals = self.scout.step(at_ns, &here, self.scan.as_ref(), odometry.haste(0));
        beliefs.intention = self.scout.intention();
        if self.scout.waits_for_scan() {
            beliefs.awaited.get_or_insert_with(|| self.scanner.awaited(beliefs.odometry.as_ref()));
        }
        beliefs.path = self.scout.path().into_iter().collect();
        Some(signals)
    }

    fn goes_by_pose(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests;
