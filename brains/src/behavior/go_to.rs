//! Point-to-point navigation by the believed pose: one point after the other, straight on, more slowly near the last.

use baudbot_client::Signals;
use baudbot_geometry::{Point, Pose, math};
use serde::Deserialize;

use super::steering::{Helm, Steering};
use crate::process::{Moment, MotorBehavior};

/// Where it goes.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Points `[x, y]`, in metres, in the frame of the believed pose.
    pub points_m: Vec<[f64; 2]>,
    /// A point is reached within this distance, in metres.
    #[serde(default = "reached_m")]
    pub reached_m: f64,
    /// After the last point comes the first again.
    #[serde(default)]
    pub again: bool,
    /// How it steers.
    #[serde(default)]
    pub steering: Steering,
}

fn reached_m() -> f64 {
    0.05
}

/// A behaviour that visits points.
#[derive(Clone, Debug, PartialEq)]
pub struct GoTo {
    points: Vec<Point>,
    reached_m: f64,
    again: bool,
    helm: Helm,
    next: usize,
}

impl GoTo {
    /// At its start.
    ///
    /// # Errors
    /// If the parameters make no sense, in words.
    pub fn new(parameters: &Parameters) -> Result<Self, String> {
        if let Some(problem) = parameters.steering.problem() {
            return Err(problem);
        }
        if parameters.points_m.is_empty() {
            return Err("points_m: has no point".to_owned());
        }
        if !(parameters.reached_m.is_finite() && parameters.reached_m > 0.0) {
            return Err(format!("reached_m: must be positive, is {}", parameters.reached_m));
        }
        let points = parameters.points_m.iter().map(|&[x, y]| Point::new(x, y)).collect();
        let (reached_m, again) = (parameters.reached_m, parameters.again);
        Ok(Self { points, reached_m, again, helm: Helm::new(parameters.steering), next: 0 })
    }

    /// Whether all points have been reached.
    pub fn has_arrived(&self) -> bool {
        self.next >= self.points.len()
    }

    fn toward(&mut self, world_from_robot: &Pose) -> Signals {
        while let Some(point) = self.points.get(self.next) {
            let way = point - world_from_robot.position;
            let left_m = math::hypot(way.x, way.y);
            if left_m > self.reached_m {
                let is_last = self.next + 1 == self.points.len() && !self.again;
                let part = if is_last { (left_m / BRAKING_M).clamp(SLOWEST, 1.0) } else { 1.0 };
                return self.helm.signals(world_from_robot, math::atan2(way.y, way.x), part);
            }
            self.next += 1;
            if self.again && self.next == self.points.len() {
                self.next = 0;
                // All points within reach of each other would otherwise be gone round for ever.
                break;
            }
        }
        Signals::default()
    }
}

impl MotorBehavior for GoTo {
    /// It begins with the first point again if it had arrived; a tour that was interrupted goes on.
    fn enter(&mut self, _: &mut Moment<'_>) {
        if self.has_arrived() {
            self.next = 0;
        }
    }

    fn step(&mut self, moment: &mut Moment<'_>) -> Option<Signals> {
        let Some(estimate) = moment.beliefs.pose else { return Some(Signals::default()) };
        let signals = self.toward(&estimate.world_from_robot);
        moment.beliefs.path = self.points.iter().skip(self.next).copied().collect();
        moment.beliefs.intention = if self.has_arrived() { "has arrived".to_owned() } else { String::new() };
        Some(signals)
    }
}

/// From this distance on it slows down, in metres.
const BRAKING_M: f64 = 0.3;
/// Part of its speed that is left at the end.
const SLOWEST: f64 = 0.25;
