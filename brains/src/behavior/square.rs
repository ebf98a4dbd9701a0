//! Round a square by the believed pose: the path of UMBmark (Borenstein & Feng 1996, "Measurement and Correction of Systematic
//! Odometry Errors in Mobile Robots").
//!
//! From the origin it drives a side along the x axis, turns on the spot by 90°, and so on, four sides and four turns, back to
//! where it began as far as it believes. It keeps to the sides by pure pursuit. The notes have no such behaviour.
//!
//! *Deviation.* UMBmark's robot is programmed to drive straight; this one steers back to the side, so that a corner that was
//! not met exactly does not shift all that comes after.

use std::f64::consts::FRAC_PI_2;

use baudbot_brain::{Body, Signals};
use baudbot_geometry::{Direction, Point, Pose, Vector, angle};
use serde::Deserialize;

use crate::parameter::{ParameterError, check_positive};
use crate::process::{MotorBehavior, StepContext};
use crate::steering::{Helm, Steering, braking};

/// The square, and how it is driven.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// Length of a side, in metres.
    pub side_m: f64,
    /// Whether it turns right at the corners.
    pub clockwise: bool,
    /// The gains and speeds of its steering; K_p is of no use here.
    pub steering: Steering,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { side_m: 4.0, clockwise: false, steering: Steering::default() }
    }
}

/// A behaviour that drives round a square once and then stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Square {
    parameters: Parameters,
    half_track_m: f64,
    helm: Helm,
    stage: Stage,
}

/// The part of the square that it drives. Sides count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Side(u8),
    /// The corner at the end of this side.
    Corner(u8),
    Arrived,
}

impl Square {
    /// A `Square` for a robot with this body.
    ///
    /// # Errors
    /// If the parameters are invalid.
    pub fn new(parameters: &Parameters, body: &Body) -> Result<Self, ParameterError> {
        parameters.steering.check()?;
        check_positive([("side_m", parameters.side_m)])?;
        let helm = Helm::new(parameters.steering);
        Ok(Self { parameters: *parameters, half_track_m: body.half_track_m, helm, stage: Stage::Side(0) })
    }

    /// Whether it has been round.
    pub fn has_arrived(&self) -> bool {
        self.stage == Stage::Arrived
    }

    /// The heading of this side, in radians; not within a turn.
    fn heading_rad(&self, side: u8) -> f64 {
        self.sign() * f64::from(side) * FRAC_PI_2
    }

    /// 1 for turns to the left.
    fn sign(&self) -> f64 {
        if self.parameters.clockwise { -1.0 } else { 1.0 }
    }

    /// The corner at which this side begins. After the last one that is the start again.
    fn corner(&self, side: u8) -> Point {
        let side_m = self.parameters.side_m;
        let [x, y] = [[0.0, 0.0], [side_m, 0.0], [side_m, side_m], [0.0, side_m]][usize::from(side % SIDES)];
        Point::new(x, self.sign() * y)
    }

    /// The corners that are still to come.
    fn left(&self) -> Vec<Point> {
        let (Stage::Side(side) | Stage::Corner(side)) = self.stage else { return Vec::new() };
        (side + 1..=SIDES).map(|next| self.corner(next)).collect()
    }

    fn drive(&mut self, world_from_robot: &Pose) -> Signals {
        if let Stage::Side(side) = self.stage {
            let along: Vector = Direction::from_angle(self.heading_rad(side)).vector();
            let driven_m = (world_from_robot.position - self.corner(side)).dot(&along);
            let left_m = self.parameters.side_m - driven_m;
            if left_m > REACHED_M {
                let ahead_m = driven_m + LOOK_AHEAD_M.min(0.25 * self.parameters.side_m);
                let target = self.corner(side) + along * ahead_m;
                return self.helm.pursue(world_from_robot, target, self.half_track_m, braking(left_m));
            }
            self.stage = Stage::Corner(side);
        }
        if let Stage::Corner(side) = self.stage {
            let off_rad = angle::difference(self.heading_rad(side + 1), world_from_robot.heading);
            let left_rad = self.sign() * off_rad;
            if left_rad > TURNED_RAD {
                return self.turn(left_rad);
            }
            self.stage = if side + 1 < SIDES { Stage::Side(side + 1) } else { Stage::Arrived };
        }
        Signals::default()
    }

    /// On the spot, and more slowly at the end.
    fn turn(&self, left_rad: f64) -> Signals {
        let Steering { rotation_m_s, full_speed_m_s, .. } = self.parameters.steering;
        let part = (left_rad / SLOW_RAD).clamp(SLOWEST, 1.0);
        let signal = self.sign() * part * rotation_m_s / full_speed_m_s;
        Signals { left: -signal, right: signal }
    }
}

impl MotorBehavior for Square {
    fn step(&mut self, context: &mut StepContext<'_>) -> Option<Signals> {
        let Some(estimate) = context.beliefs.pose else { return Some(Signals::default()) };
        let signals = self.drive(&estimate.world_from_robot);
        context.beliefs.path = self.left();
        context.beliefs.intention = if self.has_arrived() { "has arrived".to_owned() } else { String::new() };
        Some(signals)
    }

    fn goes_by_pose(&self) -> bool {
        true
    }
}

const SIDES: u8 = 4;
/// A side ends so far before its corner, in metres: the robot rolls a little farther.
const REACHED_M: f64 = 0.005;
/// The distance on a side at which it aims, in metres.
const LOOK_AHEAD_M: f64 = 0.3;
/// A turn ends so far before its heading, in radians.
const TURNED_RAD: f64 = 0.01;
/// The angle from which on the robot turns more slowly, in radians.
const SLOW_RAD: f64 = 0.5;
/// Part of its speed that is left at the end of a turn.
const SLOWEST: f64 = 0.25;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_body::body;

    /// Drives round with wheels that obey commands, and returns where it is after each stage.
    fn corners(clockwise: bool, side_m: f64) -> Vec<Pose> {
        let body = body(&[]);
        let steering = Steering { full_speed_m_s: 1.0, ..Steering::default() };
        let mut square = Square::new(&Parameters { side_m, clockwise, steering }, &body).unwrap();
        let (mut pose, dt_s) = (Pose::new(0.0, 0.0, 0.0), 0.02);
        let mut poses = Vec::new();
        for _ in 0..20_000 {
            let before = square.stage;
            let Signals { left, right } = square.drive(&pose);
            if square.stage != before {
                poses.push(pose);
            }
            if square.has_arrived() {
                return poses;
            }
            let turn = (right - left) / (2.0 * body.half_track_m) * dt_s;
            let middle = pose.heading + 0.5 * turn;
            pose.position += Vector::new(middle.cos(), middle.sin()) * (0.5 * (left + right) * dt_s);
            pose.heading = angle::wrap(pose.heading + turn);
        }
        panic!("it never arrives: {poses:?}");
    }

    #[test]
    fn it_turns_at_each_corner_and_ends_where_and_as_it_began() {
        for (clockwise, sign, side_m) in [(false, 1.0, 4.0), (true, -1.0, 4.0), (false, 1.0, 0.4)] {
            let poses = corners(clockwise, side_m);
            assert_eq!(poses.len(), 8, "{poses:?}");
            let places = [[side_m, 0.0], [side_m, side_m], [0.0, side_m], [0.0, 0.0]];
            for (side, (pair, [x, y])) in poses.chunks(2).zip(places).enumerate() {
                let off = (pair[0].position - Point::new(x, sign * y)).norm();
                assert!(off < 0.01, "{side_m} m, side {side}: {:?}", pair[0]);
                let heading = sign * (side as f64 + 1.0) * FRAC_PI_2;
                let turned = angle::difference(pair[1].heading, heading).abs();
                assert!(turned < 0.02, "{side_m} m, corner {side}: {:?}", pair[1]);
            }
        }
    }

    #[test]
    fn a_square_without_a_side_is_refused() {
        let parameters = Parameters { side_m: 0.0, ..Parameters::default() };
        let error = Square::new(&parameters, &body(&[])).unwrap_err();
        assert_eq!(error.to_string(), "side_m: must be positive, is 0");
    }
}
