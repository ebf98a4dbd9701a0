//! A motor behaviour that goes down a potential field, and gets out of places where it locks.
//!
//! The direction is that of (6.3), the wheels' speeds are those of (6.4) to (6.7). Waypoints attract one after the other:
//! each goes once the robot has been within L of it.
//!
//! *Beyond the notes*: a robot that has hardly moved for a while though it is not at the goal is locked, and it then puts a
//! waypoint of its own beside the way to the goal, in turn to the left and to the right, each time farther away. With
//! `escape_after_s = 0` it stays locked, as in Fig. 6.13.

use std::collections::VecDeque;

use baudbot_client::Signals;
use baudbot_geometry::{Point, Pose, Vector, math};
use serde::Deserialize;

use super::field::{Field, Potential};
use crate::behavior::Steering;
use crate::behavior::steering::Helm;
use crate::process::{Moment, MotorBehavior};

/// The field, and how it is followed.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// The navigation goal.
    pub goal: Potential,
    /// What is to be kept clear of.
    #[serde(default)]
    pub obstacles: Vec<Potential>,
    /// Attracting potentials on the way, one after the other.
    #[serde(default)]
    pub waypoints: Vec<Potential>,
    /// L: a waypoint goes within this distance, in metres.
    #[serde(default = "passed_m")]
    pub passed_m: f64,
    /// It has arrived within this distance of the goal, in metres.
    #[serde(default = "passed_m")]
    pub arrived_m: f64,
    /// So long it may stay within a few centimetres before it is locked, in seconds; 0: for ever.
    #[serde(default = "escape_after_s")]
    pub escape_after_s: f64,
    /// How it steers.
    #[serde(default)]
    pub steering: Steering,
}

fn passed_m() -> f64 {
    0.1
}

fn escape_after_s() -> f64 {
    10.0
}

/// A behaviour that follows a field.
#[derive(Clone, Debug)]
pub struct PotentialField {
    parameters: Parameters,
    waypoints: VecDeque<Potential>,
    helm: Helm,
    arrived: bool,
    lock: Lock,
}

/// Whether the robot gets anywhere.
#[derive(Clone, Debug, Default)]
struct Lock {
    /// Places with their instants, in nanoseconds, of the last while.
    places: VecDeque<(u64, Point)>,
    escapes: u32,
}

impl PotentialField {
    /// At its start.
    ///
    /// # Errors
    /// If the parameters make no sense, in words.
    pub fn new(parameters: Parameters) -> Result<Self, String> {
        if let Some(problem) = parameters.steering.problem() {
            return Err(problem);
        }
        let after_s = parameters.escape_after_s;
        if !(after_s == 0.0 || (1.0..=1e6).contains(&after_s)) {
            return Err(format!("escape_after_s: must be 0 or from 1 to 1000000, is {after_s}"));
        }
        let named = [("obstacles", &parameters.obstacles), ("waypoints", &parameters.waypoints)];
        let named = named.into_iter().flat_map(|(name, all)| {
            all.iter().enumerate().map(move |(i, one)| (format!("{name}[{i}]"), *one))
        });
        for (name, potential) in [("goal".to_owned(), parameters.goal)].into_iter().chain(named) {
            for (field, value) in [("beta_m", potential.beta_m), ("gamma_m", potential.gamma_m)] {
                if !(value.is_finite() && value > 0.0) {
                    return Err(format!("{name}.{field}: must be positive, is {value}"));
                }
            }
        }
        let (waypoints, helm) =
            (parameters.waypoints.iter().copied().collect(), Helm::new(parameters.steering));
        Ok(Self { parameters, waypoints, helm, arrived: false, lock: Lock::default() })
    }

    /// Whether it is at its goal.
    pub fn has_arrived(&self) -> bool {
        self.arrived
    }

    /// Wheel speeds at this believed pose and instant, in metres a second.
    pub fn wheels(&mut self, world_from_robot: &Pose, at_ns: u64) -> [f64; 2] {
        match self.heading_rad(world_from_robot.position, at_ns) {
            Some(heading_rad) => self.helm.wheels(world_from_robot, heading_rad),
            None => [0.0; 2],
        }
    }

    /// φ_ref; `None` once it has arrived, or where there is no slope.
    fn heading_rad(&mut self, at: Point, at_ns: u64) -> Option<f64> {
        let p = &self.parameters;
        self.arrived |= distance(p.goal.center(), at) <= p.arrived_m;
        if self.arrived {
            return None;
        }
        if self.waypoints.front().is_some_and(|waypoint| distance(waypoint.center(), at) <= p.passed_m) {
            self.waypoints.pop_front();
        }
        if p.escape_after_s > 0.0 && self.lock.is_locked(at, at_ns, p.escape_after_s) {
            let waypoint = self.lock.way_out(at, p.goal.center());
            self.waypoints.push_front(waypoint);
        }
        let all =
            [p.goal].into_iter().chain(p.obstacles.iter().copied()).chain(self.waypoints.front().copied());
        let down = Field { potentials: all.collect() }.direction(at);
        (down != Vector::zeros()).then(|| math::atan2(down.y, down.x))
    }
}

impl Lock {
    /// Whether it has been within a few centimetres of here for so long.
    fn is_locked(&mut self, at: Point, at_ns: u64, after_s: f64) -> bool {
        let after_ns = (after_s * 1e9) as u64;
        // One place in a tenth of a second is enough.
        if self.places.back().is_none_or(|(last_ns, _)| at_ns.saturating_sub(*last_ns) >= 100_000_000) {
            self.places.push_back((at_ns, at));
        }
        while self.places.front().is_some_and(|(then_ns, _)| at_ns.saturating_sub(*then_ns) > after_ns) {
            self.places.pop_front();
        }
        let whole = self
            .places
            .front()
            .is_some_and(|(then_ns, _)| at_ns.saturating_sub(*then_ns) + 200_000_000 >= after_ns);
        whole && self.places.iter().all(|(_, place)| distance(*place, at) < LOCKED_M)
    }

    /// A waypoint beside the way to the goal.
    fn way_out(&mut self, at: Point, goal: Point) -> Potential {
        let way = goal - at;
        let left = Vector::new(-way.y, way.x) / math::hypot(way.x, way.y).max(1e-9);
        let side = if self.escapes.is_multiple_of(2) { 1.0 } else { -1.0 };
        let far_m = ESCAPE_M * f64::from(1 + self.escapes / 2);
        self.escapes += 1;
        self.places.clear();
        let place = at + left * (side * far_m);
        let reach_m = far_m * 0.75;
        Potential { x_m: place.x, y_m: place.y, alpha: -3.0, beta_m: reach_m, gamma_m: reach_m }
    }
}

impl MotorBehavior for PotentialField {
    fn step(&mut self, moment: &mut Moment<'_>) -> Option<Signals> {
        let Some(estimate) = moment.beliefs.pose else { return Some(Signals::default()) };
        let [left, right] = self.wheels(&estimate.world_from_robot, moment.turn.at_ns);
        let full_speed_m_s = self.parameters.steering.full_speed_m_s;
        moment.beliefs.path =
            self.waypoints.iter().map(Potential::center).chain([self.parameters.goal.center()]).collect();
        moment.beliefs.intention = if self.arrived { "has arrived".to_owned() } else { String::new() };
        Some(Signals { left: left / full_speed_m_s, right: right / full_speed_m_s })
    }

    fn goes_by_pose(&self) -> bool {
        true
    }
}

fn distance(a: Point, b: Point) -> f64 {
    math::hypot(a.x - b.x, a.y - b.y)
}

/// Who stays within this distance for a while is locked, in metres.
const LOCKED_M: f64 = 0.05;
/// How far the first waypoints out of a lock are, in metres.
const ESCAPE_M: f64 = 0.8;

#[cfg(test)]
mod tests {
    use super::*;

    fn wedge(escape_after_s: f64, waypoints: Vec<Potential>) -> PotentialField {
        let hill = |x_m, y_m| Potential { x_m, y_m, alpha: 0.6, beta_m: 0.25, gamma_m: 0.25 };
        let parameters = Parameters {
            goal: Potential { x_m: 2.0, y_m: 0.0, alpha: -1.0, beta_m: 3.0, gamma_m: 3.0 },
            obstacles: vec![hill(1.0, 0.0), hill(0.8, 0.3), hill(0.8, -0.3)],
            waypoints,
            passed_m: 0.1,
            arrived_m: 0.05,
            escape_after_s,
            steering: Steering::default(),
        };
        PotentialField::new(parameters).unwrap()
    }

    /// A robot of half track 0.2 m whose wheels do at once what they are told: where it is, when it arrived, and how often it
    /// began to turn on the spot.
    fn drive(mut field: PotentialField, y_m: f64, for_s: f64) -> (Pose, Option<f64>, u32) {
        let (mut pose, dt_s, mut rotations, mut rotated) = (Pose::new(-1.0, y_m, 0.0), 0.01, 0, false);
        for step in 0..(for_s / dt_s) as u64 {
            let [left, right] = field.wheels(&pose, step * 10_000_000);
            rotations += u32::from(field.helm.rotates() && !rotated);
            rotated = field.helm.rotates();
            if field.has_arrived() {
                return (pose, Some(step as f64 * dt_s), rotations);
            }
            let (speed, turn) = ((left + right) / 2.0, (right - left) / 0.4);
            pose.position += pose.direction().vector() * (speed * dt_s);
            pose.heading += turn * dt_s;
        }
        (pose, None, rotations)
    }

    #[test]
    fn without_waypoints_it_locks_and_turns_to_and_fro() {
        let (pose, reached_s, rotations) = drive(wedge(0.0, Vec::new()), 0.0, 200.0);
        assert!(reached_s.is_none() && rotations >= 10, "{rotations}");
        assert!((pose.position.x - 0.385).abs() < 0.01 && pose.position.y.abs() < 0.01, "{pose:?}");
    }

    #[test]
    fn with_waypoints_it_gets_there() {
        let waypoint = |x_m| Potential { x_m, y_m: 0.75, alpha: -1.2, beta_m: 0.45, gamma_m: 0.45 };
        let (_, reached_s, rotations) = drive(wedge(0.0, vec![waypoint(0.45), waypoint(1.2)]), 0.0, 60.0);
        assert!((reached_s.expect("it arrives") - 21.06).abs() < 0.5, "{reached_s:?}");
        assert!(rotations <= 2, "{rotations}");
    }

    #[test]
    fn from_every_start_it_escapes_from_its_lock_by_itself() {
        for i in -40..=40 {
            let (pose, reached_s, _) = drive(wedge(10.0, Vec::new()), 0.05 * f64::from(i), 200.0);
            assert!(reached_s.is_some(), "from y = {}: at {pose:?}", 0.05 * f64::from(i));
        }
    }

    #[test]
    fn what_makes_no_sense_is_said() {
        let bad = Potential { x_m: 0.0, y_m: 0.0, alpha: 1.0, beta_m: 1.0, gamma_m: 0.0 };
        let mut parameters = wedge(0.0, Vec::new()).parameters;
        parameters.waypoints.push(bad);
        let problem = PotentialField::new(parameters).unwrap_err();
        assert_eq!(problem, "waypoints[0].gamma_m: must be positive, is 0");
    }
}
