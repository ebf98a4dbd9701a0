//! [Particles](crate::localization::particles) as a cognitive process: the places where the robot may be, by a map and
//! its scans. As soon as that is one place, odometry is corrected for the instant of the scan, with all that came
//! after.
//!
//! It needs a process of kind `odometry`. With `everywhere` the start need not be known; it must move to find out.
//! Scans count only after some motion: of a robot that stands the same scan would be counted again and again.

use baudbot_geometry::Pose;
use serde::Deserialize;

use super::map_of;
use crate::Chance;
use crate::estimate::Estimate;
use crate::localization::Map;
use crate::localization::map::VirtualLaser;
use crate::localization::particles::{self, Particles};
use crate::odometry::Odometry;
use crate::parameter::{ParameterError, check_positive};
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
    /// The number of particles.
    #[serde(default = "count")]
    pub particles: usize,
    /// The number of beams of a scan that are compared with the map, about.
    #[serde(default = "beams")]
    pub beams: usize,
    /// The particles begin anywhere in the map, and not at the pose of odometry.
    #[serde(default)]
    pub everywhere: bool,
    /// Odometry is corrected when they are spread no more than this, as a standard deviation in metres.
    #[serde(default = "sure_m")]
    pub sure_m: f64,
    /// A scan counts when the robot has moved so far since the last one, in metres, or has turned by 0.1 rad.
    #[serde(default = "every_m")]
    pub every_m: f64,
}

fn laser_name() -> String {
    "laser".to_owned()
}

fn count() -> usize {
    particles::Parameters::default().particles
}

fn beams() -> usize {
    particles::Parameters::default().beams
}

fn sure_m() -> f64 {
    0.2
}

fn every_m() -> f64 {
    0.1
}

/// A process that corrects odometry.
pub struct Disperse {
    parameters: Parameters,
    map: Map,
    scanner: Scanner,
    chance: Chance,
    particles: Option<Particles>,
    /// The robot's pose has been known.
    has_found: bool,
    /// The instant of the last scan, and the robot's motion since the last one that counted.
    last: Option<(u64, Pose)>,
}

impl Disperse {
    /// A `Disperse` for a robot with this body.
    ///
    /// # Errors
    /// If a parameter is invalid, or the robot has no such laser.
    pub fn new(parameters: Parameters, context: &BuildContext<'_>) -> Result<Self, ParameterError> {
        check_positive([("sure_m", parameters.sure_m), ("every_m", parameters.every_m)])?;
        if !(1..=100_000).contains(&parameters.particles) {
            let found = parameters.particles as f64;
            return Err(ParameterError::range("particles", "from 1 to 100000", found));
        }
        if parameters.beams == 0 {
            return Err(ParameterError::value("beams", "must be at least 1"));
        }
        if parameters.walls_m.is_empty() {
            return Err(ParameterError::value("walls_m", "localization needs walls"));
        }
        let map = map_of(&parameters.walls_m)?;
        let scanner = Scanner::new(context.body, &parameters.laser, parameters.beams)?;
        Ok(Self {
            parameters,
            map,
            scanner,
            chance: context.chance(),
            particles: None,
            has_found: false,
            last: None,
        })
    }

    /// The particles at the beginning, or when it is not known any more how the robot has moved.
    fn disperse(&self, at: &Estimate) -> Particles {
        let Parameters { particles, beams, everywhere, .. } = self.parameters;
        let parameters = particles::Parameters { particles, beams, ..particles::Parameters::default() };
        if everywhere && !self.has_found {
            return Particles::everywhere(&self.map, parameters, self.chance.clone());
        }
        let unsure = Estimate::within(at.world_from_robot, 0.1, 0.1);
        let about = Estimate { covariance: at.covariance + unsure.covariance, ..*at };
        Particles::around(&about, parameters, self.chance.clone())
    }

    /// Holds a scan against the map; where they all are, if that is one place.
    fn see(&mut self, odometry: &Odometry, taken_ns: u64, scan: &Scan) -> Option<Estimate> {
        let now = odometry.correctable(taken_ns)?;
        let before = self.last.and_then(|(last_ns, moved)| Some((odometry.at(last_ns)?, moved)));
        let particles = match (self.particles.take(), before) {
            (Some(mut particles), Some((then, moved))) => {
                let then_from_now = then.world_from_robot.inverse().compose(&now.world_from_robot);
                let moved = moved.compose(&then_from_now);
                let turned = moved.heading.abs() > TURN_RAD;
                if moved.position.coords.norm() < self.parameters.every_m && !turned {
                    self.last = Some((taken_ns, moved));
                    self.particles = Some(particles);
                    return None;
                }
                particles.advance(&moved);
                particles
            }
            // The last scan is so old that the robot's motion since then is unknown.
            _ => self.disperse(&now),
        };
        let particles = self.particles.insert(particles);
        particles.see(&self.map, scan);
        self.last = Some((taken_ns, Pose::new(0.0, 0.0, 0.0)));
        let estimate = particles.estimate();
        let is_one = estimate.position_sd_m() <= self.parameters.sure_m
            && particles.share(&estimate) >= MOST
            && fit(&self.map, scan, &estimate.world_from_robot) >= GOOD_FIT;
        self.has_found |= is_one;
        is_one.then_some(estimate)
    }
}

/// The fraction of a scan's beams that end at the distance in the map from this pose.
fn fit(map: &Map, scan: &Scan, world_from_robot: &Pose) -> f64 {
    let laser = VirtualLaser::like(scan);
    let mut virtual_m = vec![0.0; laser.rays()];
    laser.look(map, world_from_robot, &mut virtual_m);
    let beams = scan.distances_m.iter().zip(&virtual_m).filter(|(measured, _)| !measured.is_nan());
    let off_m =
        beams.map(|(measured, expected)| (measured.min(scan.range_m) - expected.min(scan.range_m)).abs());
    let (good, all) = off_m.fold((0, 0), |(good, all), off_m| (good + usize::from(off_m < GOOD_M), all + 1));
    if all == 0 { 0.0 } else { f64::from(good as u32) / f64::from(all) }
}

impl CognitiveProcess for Disperse {
    fn step(&mut self, context: &mut StepContext<'_>) {
        self.scanner.hear(context.turn);
        let Some(odometry) = &mut context.beliefs.odometry else { return };
        while let Some((taken_ns, scan)) = self.scanner.take(odometry) {
            if let Some(estimate) = self.see(odometry, taken_ns, &scan) {
                odometry.correct(taken_ns, estimate);
                context.beliefs.pose = Some(odometry.estimate());
            }
        }
    }

    /// Events while the process was inactive are unknown to it.
    fn enter(&mut self, _: &mut StepContext<'_>) {
        self.scanner.forget();
        self.last = None;
    }
}

/// A scan counts after a turn by so much, in radians.
const TURN_RAD: f64 = 0.1;
/// So much of all weight must be where the estimate is.
const MOST: f64 = 0.8;
/// A beam fits the map within so much, in metres.
const GOOD_M: f64 = 0.2;
/// A part of the beams that is less is none of this map's.
const GOOD_FIT: f64 = 0.5;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_body::body;

    fn refused(toml: &str) -> String {
        let body = body(&[("laser", "laser", 0.0)]);
        let context = BuildContext { name: "particles", body: &body, seed: 1, motors: &[], by_utility: true };
        let walls = "walls_m = [[0.0, 0.0, 4.0, 0.0], [4.0, 0.0, 4.0, 3.0]]\n";
        let parameters =
            toml::from_str(&format!("{walls}{toml}")).map_err(|error| error.message().to_owned());
        let made = parameters
            .and_then(|parameters| Disperse::new(parameters, &context).map_err(|error| error.to_string()));
        made.err().unwrap_or_default()
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        assert_eq!(refused(""), "");
        assert_eq!(refused("particles = 0"), "particles: must be from 1 to 100000, is 0");
        let empty = toml::from_str("walls_m = []").unwrap();
        let body = body(&[("laser", "laser", 0.0)]);
        let context = BuildContext { name: "particles", body: &body, seed: 1, motors: &[], by_utility: true };
        assert!(
            Disperse::new(empty, &context)
                .is_err_and(|error| error.to_string().starts_with("walls_m: localization needs walls"))
        );
        assert_eq!(refused("beams = 0"), "beams: must be at least 1");
        assert_eq!(refused("sure_m = 0"), "sure_m: must be positive, is 0");
        assert_eq!(refused("laser = \"urg\""), "laser: robot `alice` has no laser called `urg`");
        assert!(refused("partikel = 1").contains("unknown field `partikel`"));
    }
}
