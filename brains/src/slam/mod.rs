//! Simultaneous localization and mapping: where a robot is on a map that it makes itself as it goes.
//!
//! Each scan is matched with the [occupancy grid](crate::mapping::occupancy) of the scans before it, beginning where
//! odometry says the robot is, and then added to the grid at the pose that was found, as S. Kohlbrecher, O. von Stryk, J. Meyer and
//! U. Klingauf do in *A flexible and scalable SLAM system with full 3D motion estimation*, SSRR 2011. [`matching`] is how.
//!
//! | of a scan's rays that met something | what is done |
//! |---|---|
//! | too few end where the map knows anything | the odometry is believed, and the scan is added: a new place |
//! | most end where the map has something | the match is believed, and the scan is added |
//! | many end where the map has nothing | the scan is rejected: it changes neither pose nor map |
//!
//! *Deviations.* The notes mention SLAM and leave it out (Wahde 2016, §6.1). Kohlbrecher's match goes by the slope of the
//! grid's probabilities, which is good to a cell; here cells know where in them rays have ended. A scan is added only
//! after `step_m` or `step_rad`, since each one that is added moves the map by a part of its error.
//!
//! *Limits.* The past is not corrected, and no loop is closed: after a long round through unknown rooms the error of the pose
//! is the sum of the errors of all matches on the way.

pub mod matching;

#[cfg(test)]
mod tests;

use baudbot_geometry::{Pose, angle};

use crate::estimate::Estimate;
use crate::mapping::{Occupancy, PlacedScan};
use crate::scan::Scan;
use matching::Match;

/// The matching of scans, and the distance between those that are added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Side of the grid's cells, in metres.
    pub cell_m: f64,
    /// The number of rays that are matched, about. All of them are added.
    pub rays: usize,
    /// A scan is added when the robot has moved so far since the last one, in metres, ...
    pub step_m: f64,
    /// ... or has turned by so much, in radians.
    pub step_rad: f64,
    /// A scan is rejected if fewer of its rays than this part end where the map has something.
    pub least_fit: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { cell_m: 0.05, rays: 171, step_m: 0.1, step_rad: 0.1, least_fit: 0.6 }
    }
}

/// The grid is not in it: it is everybody's, see [`Beliefs::grid`](crate::process::Beliefs::grid).
#[derive(Clone, Debug, PartialEq)]
pub struct Slam {
    parameters: Parameters,
    /// The pose at the last scan that was added.
    added: Option<Pose>,
}

impl Slam {
    /// A `Slam` at its start.
    #[must_use]
    pub fn new(parameters: Parameters) -> Self {
        Self { parameters, added: None }
    }

    /// A grid of which nothing is known, to begin with.
    #[must_use]
    pub fn grid(&self) -> Occupancy {
        Occupancy::new(self.parameters.cell_m)
    }

    /// The robot's pose at this scan, if the guess was that of its odometry; `None` if the scan is rejected, or the
    /// grid would become too large. The echoes go into the grid.
    pub fn see(&mut self, grid: &mut Occupancy, scan: &Scan, guess: &Estimate) -> Option<Estimate> {
        let thin = scan.thinned(self.parameters.rays);
        let estimate = match matching::find(grid, &thin, guess, self.parameters.least_fit) {
            Match::Found(estimate) => estimate,
            Match::New => *guess,
            Match::Poor => return None,
        };
        let world_from_robot = estimate.world_from_robot;
        if self.has_moved(&world_from_robot) {
            let is_added = grid.add(&PlacedScan::new(world_from_robot, scan.clone()));
            self.added = Some(world_from_robot).filter(|_| is_added);
            self.added?;
        }
        Some(estimate)
    }

    fn has_moved(&self, here: &Pose) -> bool {
        self.added.is_none_or(|last| {
            let turned_rad = angle::difference(here.heading, last.heading).abs();
            let moved_m = (here.position - last.position).norm();
            moved_m >= self.parameters.step_m || turned_rad >= self.parameters.step_rad
        })
    }
}
