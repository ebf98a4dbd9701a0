//! The lengths of the method, which follow the body.

use crate::exploration::frontiers;
use crate::exploration::placement::{self, Placement};

/// The lengths of the method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// D, Δ, `γ_min` and d.
    pub placement: Placement,
    /// The greatest distance of a target that is gone to directly, L, in metres: at most the laser's range.
    pub sight_m: f64,
    /// The parameters of the map.
    pub map: frontiers::Parameters,
}

impl Default for Parameters {
    /// The `Parameters` of a robot of 0.4 m.
    fn default() -> Self {
        Self::of_body(0.2)
    }
}

impl Parameters {
    /// The `Parameters` of a robot with this radius, in metres. Rooms do not become smaller with the robot, so that
    /// nodes are half a metre away at least.
    #[must_use]
    pub fn of_body(radius_m: f64) -> Self {
        let map = frontiers::Parameters::of_body(radius_m);
        let distance_m = (DISTANCE * radius_m).max(LEAST_DISTANCE_M);
        let width_rad = placement::width_rad(map.least_width_m(), distance_m);
        let (margin_m, separation_m) = (0.6 * distance_m, 0.95 * distance_m);
        let placement = Placement { distance_m, margin_m, width_rad, separation_m };
        Self { placement, sight_m: 3.0 * distance_m, map }
    }

    /// A node is reached within this distance, a, in metres.
    pub(super) fn reach_m(&self) -> f64 {
        REACH * self.map.radius_m
    }

    /// Half the width that a direct way must have, in metres: the robot's radius and a little more.
    pub(super) fn half_width_m(&self) -> f64 {
        (1.0 + ROOM) * self.map.radius_m
    }
}

/// The distance at which nodes are placed, D, in radii of the body, as are all lengths here that are not in metres.
const DISTANCE: f64 = 5.0;
/// The least such distance, in metres.
const LEAST_DISTANCE_M: f64 = 0.5;
/// A node is reached within this distance.
const REACH: f64 = 0.5;
/// Room beside the robot on a direct way.
const ROOM: f64 = 0.25;
