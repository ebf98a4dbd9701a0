//! Exploration as one behaviour of many: Wahde 2016, §6.1.
//!
//! It goes by the pose that the brain believes: a process of kind `odometry` must be there, and those of kinds `slam` and
//! `laser_localization` correct that. Each time that it is activated it goes on where it was.
//!
//! *Deviations.* As those of [`Explore`](super::Explore). A scan that fitted nowhere into the map is explored by, too.

use baudbot_client::{Body, Signals};

use super::brain::{PARAMETERS, Parameters};
use super::scout::Scout;
use crate::mapping::PlacedScan;
use crate::process::{Moment, MotorBehavior};
use crate::scanner::Scanner;

/// A behaviour that explores.
pub struct ExploreFloor {
    stale_ns: u64,
    scout: Scout,
    scanner: Scanner,
    scan: Option<PlacedScan>,
    /// The newest reading of odometry that it has acted by.
    acted_ns: Option<u64>,
}

impl ExploreFloor {
    /// For a robot with this body, by its first laser.
    ///
    /// # Errors
    /// If a parameter makes no sense, or the robot has no laser of which scans can be made, in words.
    pub fn new(mut parameters: Parameters, body: &Body) -> Result<Self, String> {
        if parameters.slam != 0.0 {
            return Err("slam: a process of kind `slam` beside this one makes the map".to_owned());
        }
        for parameter in PARAMETERS {
            let (found, range) = (*(parameter.field)(&mut parameters), &parameter.range);
            if !range.contains(&found) {
                let (least, most) = (range.start(), range.end());
                return Err(format!("{}: must be from {least} to {most}, is {found}", parameter.name));
            }
        }
        let laser = body.sensors.iter().find(|sensor| sensor.kind == "laser");
        let laser = laser.ok_or_else(|| format!("robot `{}` has no sensor of kind `laser`", body.name))?;
        let no_range = || format!("the data sheet of `{}` does not say how far it sees", laser.name);
        Ok(Self {
            stale_ns: parameters.stale_ns(),
            scanner: Scanner::new(body, &laser.name, usize::MAX)?,
            scout: Scout::new(parameters, body, laser.range_m.ok_or_else(no_range)?),
            scan: None,
            acted_ns: None,
        })
    }

    /// Takes in what has come.
    fn look(&mut self, moment: &Moment<'_>) {
        self.scout.feel(moment.turn);
        self.scanner.hear(moment.turn);
        let Some(odometry) = &moment.beliefs.odometry else { return };
        let Some((at_ns, scan)) = self.scanner.take(odometry) else { return };
        if let Some(estimate) = odometry.at(at_ns) {
            self.scan = Some(PlacedScan { world_from_robot: estimate.world_from_robot, scan });
        }
    }
}

impl MotorBehavior for ExploreFloor {
    fn enter(&mut self, _: &mut Moment<'_>) {
        self.scanner.forget();
        self.scout.interrupt();
        self.acted_ns = None;
    }

    fn step(&mut self, moment: &mut Moment<'_>) -> Option<Signals> {
        self.look(moment);
        let at_ns = moment.turn.at_ns;
        let beliefs = &mut *moment.beliefs;
        let odometry = beliefs.odometry.as_ref();
        let Some(odometry) = odometry.filter(|it| at_ns.saturating_sub(it.at_ns()) <= self.stale_ns) else {
            "does not know where it is".clone_into(&mut beliefs.intention);
            self.scout.interrupt();
            return Some(Signals::default());
        };
        if self.acted_ns.is_some_and(|acted_ns| acted_ns >= odometry.at_ns()) {
            return None;
        }
        self.acted_ns = Some(odometry.at_ns());
        let signals = self.scout.step(at_ns, &odometry.estimate().world_from_robot, self.scan.as_ref());
        beliefs.intention = self.scout.intention();
        beliefs.path = self.scout.path().into_iter().collect();
        Some(signals)
    }
}

#[cfg(test)]
mod tests;
