//! [SLAM](crate::slam) as a cognitive process: each scan is matched with the grid of those before it, and odometry is
//! corrected for the instant at which the scan was taken, with all that came after. The grid is among the brain's beliefs.
//!
//! It needs a process of kind `odometry`. One of `laser_localization` beside it would correct the same odometry by
//! another map.

use serde::Deserialize;

use crate::parameter::ParameterError;
use crate::process::{CognitiveProcess, StepContext};
use crate::registry::BuildContext;
use crate::scanner::Scanner;
use crate::slam::{self, Slam};

/// The making of a map.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Name of the laser.
    #[serde(default = "laser_name")]
    pub laser: String,
    /// Side of the grid's cells, in metres.
    #[serde(default = "cell_m")]
    pub cell_m: f64,
    /// The number of rays that are matched, about.
    #[serde(default = "rays")]
    pub rays: usize,
}

fn laser_name() -> String {
    "laser".to_owned()
}

fn cell_m() -> f64 {
    slam::Parameters::default().cell_m
}

fn rays() -> usize {
    slam::Parameters::default().rays
}

/// A process that makes a map and finds the robot on it.
pub struct MakeMap {
    scanner: Scanner,
    slam: Slam,
}

/// A scan with fewer rays does not determine a pose.
const LEAST_RAYS: usize = 20;

impl MakeMap {
    /// A `MakeMap` for a robot with this body; an error if it has no such laser.
    ///
    /// # Errors
    /// See [`ParameterError`].
    pub fn new(parameters: &Parameters, context: &BuildContext<'_>) -> Result<Self, ParameterError> {
        let &Parameters { ref laser, cell_m, rays } = parameters;
        if !(0.01..=1.0).contains(&cell_m) {
            return Err(ParameterError::range("cell_m", "from 0.01 to 1", cell_m));
        }
        if rays < LEAST_RAYS {
            let problem = format_args!("must be at least {LEAST_RAYS}, is {rays}: fewer match no map");
            return Err(ParameterError::value("rays", problem));
        }
        let laser_rays = context.body.sensor(laser).map_or(LEAST_RAYS, baudbot_brain::Sensor::values);
        if laser_rays < LEAST_RAYS {
            let problem =
                format_args!("`{laser}` has {laser_rays} rays; matching needs {LEAST_RAYS} at least");
            return Err(ParameterError::value("laser", problem));
        }
        let scanner = Scanner::new(context.body, laser, usize::MAX)?;
        let slam = Slam::new(slam::Parameters { cell_m, rays, ..slam::Parameters::default() });
        Ok(Self { scanner, slam })
    }
}

impl CognitiveProcess for MakeMap {
    fn step(&mut self, context: &mut StepContext<'_>) {
        self.scanner.hear(context.turn);
        let Some(odometry) = &mut context.beliefs.odometry else { return };
        while let Some((taken_ns, scan)) = self.scanner.take(odometry) {
            let Some(guess) = odometry.correctable(taken_ns) else { continue };
            let grid = context.beliefs.grid.get_or_insert_with(|| self.slam.grid());
            if let Some(estimate) = self.slam.see(grid, &scan, &guess) {
                odometry.correct(taken_ns, estimate);
                context.beliefs.pose = Some(odometry.estimate());
            }
        }
    }
}
