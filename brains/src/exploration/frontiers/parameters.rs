//! The lengths of the method, which follow the body.

use crate::exploration::left_out::least_width_m;

/// The lengths of the method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Side of a cell, in metres.
    pub cell_m: f64,
    /// The robot's radius, in metres.
    pub radius_m: f64,
    /// The distance from which dark cells are viewed, in metres, as long as that is possible.
    pub view_m: f64,
    /// The number of times that the findings of proximity are all forgotten.
    pub attempts: usize,
}

impl Default for Parameters {
    /// The `Parameters` of a robot of 0.4 m.
    fn default() -> Self {
        Self::of_body(0.2)
    }
}

impl Parameters {
    /// The `Parameters` of a robot with this radius, in metres.
    #[must_use]
    pub fn of_body(radius_m: f64) -> Self {
        Self { cell_m: CELL * radius_m, radius_m, view_m: VIEW * radius_m, attempts: 2 }
    }

    /// Half the width that a path must have, in metres: the robot's radius and a little more.
    #[must_use]
    pub fn half_width_m(&self) -> f64 {
        (1.0 + ROOM) * self.radius_m
    }

    /// The width, in metres, below which an unknown area is no frontier.
    #[must_use]
    pub fn wide_m(&self) -> f64 {
        (WIDE * self.radius_m).min(MOST_WIDE_M)
    }

    /// The least width of a passage that such a robot takes for sure, in metres.
    #[must_use]
    pub fn least_width_m(&self) -> f64 {
        least_width_m(self.half_width_m(), self.cell_m)
    }
}

/// Side of a cell, in radii of the body, as are all lengths here that are not in metres.
const CELL: f64 = 0.125;
/// The distance from which dark cells are viewed.
const VIEW: f64 = 5.0;
/// Room beside the robot on its way: what it drives beside the straight line, a twentieth, and what the end of a wall may
/// reach beyond where its last cell was met, half a cell.
const ROOM: f64 = 0.125;
/// The width below which an unknown area is no frontier ...
const WIDE: f64 = 0.5;
/// ... nor is what is narrower than so, in metres, however large the body is.
const MOST_WIDE_M: f64 = 0.05;
