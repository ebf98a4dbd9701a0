//! Going to a point: turn on the spot, then straight on.

use baudbot_geometry::{Point, Pose, angle, math};

use super::Command;

/// A straight path to a point, while the robot is on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Approach {
    pub(super) to: Point,
    facing: bool,
}

impl Approach {
    pub(super) const fn new(to: Point) -> Self {
        Self { to, facing: false }
    }

    /// The next command; `None` if the robot is within `reach_m` of the point.
    pub(super) fn step(&mut self, here: &Pose, reach_m: f64) -> Option<Command> {
        if (self.to - here.position).norm() <= reach_m {
            return None;
        }
        let heading_rad = heading_to(here, self.to);
        let aside = angle::difference(heading_rad, here.heading).abs();
        self.facing = aside <= if self.facing { ASTRAY_RAD } else { FACING_RAD };
        Some(if self.facing { Command::Drive { to: self.to } } else { Command::Turn { heading_rad } })
    }
}

/// The turn to a heading; `None` if the robot faces that path.
pub(super) fn turn(here: &Pose, heading_rad: f64) -> Option<Command> {
    let aside = angle::difference(heading_rad, here.heading).abs();
    (aside > FACING_RAD).then_some(Command::Turn { heading_rad })
}

/// The heading in radians that leads to a point.
pub(super) fn heading_to(here: &Pose, to: Point) -> f64 {
    let offset = to - here.position;
    math::atan2(offset.y, offset.x)
}

/// A robot faces a point if its heading is off by less than this, in radians; at 1 m that is 5 cm, ...
const FACING_RAD: f64 = 0.05;

/// ... and turns on the spot again if it is off by more than this.
const ASTRAY_RAD: f64 = 0.5;
