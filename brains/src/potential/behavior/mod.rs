//! A motor behaviour that goes down a potential field, and gets out of places where it locks.
//!
//! The direction is that of (6.3), the wheels' speeds are those of (6.4) to (6.7). Waypoints attract one after the other:
//! each goes once the robot has been within L of it.
//!
//! *Beyond the notes*: a robot that gets no lower for a while though it is not at its goal is locked. It then plans a path on the
//! ground (`terrain`), round the hills of its field and round what it has felt (`felt`), and follows that until the field
//! leads from where it is to the goal; then it goes down the field again. What it feels in its way stops it, and begins such a
//! detour at once. With `escape_after_s = 0` there is no detour: it stays locked, as in Fig. 6.13.

mod escape;

use std::collections::VecDeque;

use baudbot_brain::{Body, Signals};
use baudbot_geometry::{Point, Pose, Vector, angle, math};
use serde::Deserialize;

use super::detour::Detour;
use super::felt::Felt;
use super::field::{Field, Potential};
use super::lock::Lock;
use crate::parameter::{ParameterError, check_positive};
use crate::process::{MotorBehavior, StepContext};
use crate::steering::{Helm, Steering};
use crate::vfh::sight;

/// The field, and how it is followed.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// The navigation goal.
    pub goal: Potential,
    /// The potentials to keep clear of.
    #[serde(default)]
    pub obstacles: Vec<Potential>,
    /// Attracting potentials on the way, one after the other.
    #[serde(default)]
    pub waypoints: Vec<Potential>,
    /// L: a waypoint goes within this distance, in metres.
    #[serde(default = "passed_m")]
    pub passed_m: f64,
    /// The robot has arrived within this distance of the goal, in metres.
    #[serde(default = "passed_m")]
    pub arrived_m: f64,
    /// So long it may get no lower in the field before it is locked, in seconds; 0: for ever.
    #[serde(default = "escape_after_s")]
    pub escape_after_s: f64,
    /// The sensors for obstacles that the field does not contain.
    #[serde(default)]
    pub sight: sight::Parameters,
    /// The gains and speeds of its steering.
    #[serde(default)]
    pub steering: Steering,
}

fn passed_m() -> f64 {
    0.1
}

fn escape_after_s() -> f64 {
    10.0
}

impl Parameters {
    /// The field of goal and obstacles, and of a waypoint.
    pub fn field(&self, waypoint: Option<&Potential>) -> Field {
        let all = [self.goal].into_iter().chain(self.obstacles.iter().copied()).chain(waypoint.copied());
        Field { potentials: all.collect() }
    }
}

/// A behaviour that follows a field.
#[derive(Clone, Debug)]
pub struct PotentialField {
    parameters: Parameters,
    radius_m: f64,
    waypoints: VecDeque<Potential>,
    helm: Helm,
    /// The steering on a detour.
    careful: Helm,
    arrived: bool,
    lock: Lock,
    felt: Felt,
    detour: Option<Detour>,
    /// The start of the detour, and the number of detours on the way to this target.
    begun: (Point, u32),
    /// The instant at which the detour was planned last, in nanoseconds.
    thought_ns: u64,
    /// Since when it stands before something that it feels, in nanoseconds.
    stands_ns: Option<u64>,
}

impl PotentialField {
    /// A `PotentialField` at its start, for a robot with this body.
    ///
    /// # Errors
    /// If the parameters are invalid.
    pub fn new(parameters: Parameters, body: &Body) -> Result<Self, ParameterError> {
        parameters.steering.check()?;
        let after_s = parameters.escape_after_s;
        if !(after_s == 0.0 || (1.0..=1e6).contains(&after_s)) {
            return Err(ParameterError::range("escape_after_s", "0 or from 1 to 1000000", after_s));
        }
        check(&parameters)?;
        let (waypoints, helm) =
            (parameters.waypoints.iter().copied().collect(), Helm::new(parameters.steering));
        let rotate_above_rad = parameters.steering.rotate_above_rad.min(ROTATE_ABOVE_RAD);
        let rotate_until_rad = parameters.steering.rotate_until_rad.min(rotate_above_rad);
        let careful = Helm::new(Steering { rotate_above_rad, rotate_until_rad, ..parameters.steering });
        Ok(Self {
            careful,
            felt: Felt::new(&parameters.sight, body)?,
            radius_m: body.radius_m,
            parameters,
            waypoints,
            helm,
            arrived: false,
            lock: Lock::default(),
            detour: None,
            begun: (Point::origin(), 0),
            thought_ns: 0,
            stands_ns: None,
        })
    }

    /// Whether it is at its goal.
    pub fn has_arrived(&self) -> bool {
        self.arrived
    }

    /// Signals at this believed pose and instant, and the stated intention.
    fn drive(&mut self, pose: &Pose, at_ns: u64) -> (Signals, &'static str) {
        let (p, at) = (&self.parameters, pose.position);
        self.arrived |= distance(p.goal.center(), at) <= p.arrived_m;
        if self.arrived {
            return (Signals::default(), "has arrived");
        }
        if self.waypoints.front().is_some_and(|waypoint| distance(waypoint.center(), at) <= p.passed_m) {
            self.waypoints.pop_front();
            self.lock.begin();
            (self.detour, self.begun.1) = (None, 0);
        }
        if !self.felt.is_senseless() && self.felt.is_blind(at_ns) {
            return (Signals::default(), "feels nothing");
        }
        if self.detour.is_none() { self.follow(pose, at_ns) } else { self.go_round(pose, at_ns) }
    }

    /// Goes down the field.
    fn follow(&mut self, pose: &Pose, at_ns: u64) -> (Signals, &'static str) {
        let (at, after_s) = (pose.position, self.parameters.escape_after_s);
        let field = self.field();
        let down = field.direction(at);
        let heading_rad = (down != Vector::zeros()).then(|| math::atan2(down.y, down.x));
        if after_s > 0.0 {
            let is_closed =
                heading_rad.is_some_and(|rad| self.felt.room_m(pose, rad) < AHEAD * self.radius_m);
            if self.lock.holds(at, field.height(at), at_ns, after_s) || is_closed {
                return self.begin_detour(pose, at_ns);
            }
        }
        let Some(heading_rad) = heading_rad else { return (Signals::default(), "") };
        (self.steer(pose, heading_rad, at_ns), "")
    }

    /// The field as it is now: goal, obstacles, and the next waypoint.
    fn field(&self) -> Field {
        self.parameters.field(self.waypoints.front())
    }

    /// The present target.
    fn target(&self) -> Point {
        self.waypoints.front().unwrap_or(&self.parameters.goal).center()
    }

    /// Signals that lead in a direction, as fast as there is room.
    fn steer(&mut self, pose: &Pose, heading_rad: f64, at_ns: u64) -> Signals {
        let room_m = self.felt.room_m(pose, pose.heading) - STOP * self.radius_m;
        if room_m > 0.0 {
            self.stands_ns = None;
            let part = (room_m / (SLOW * self.radius_m)).clamp(SLOWEST, 1.0);
            let helm = if self.detour.is_some() { &mut self.careful } else { &mut self.helm };
            return helm.signals(pose, heading_rad, part);
        }
        let s = self.parameters.steering;
        let off_rad = angle::difference(heading_rad, pose.heading);
        if off_rad.abs() > s.rotate_until_rad {
            let signal = s.rotation_m_s.copysign(off_rad) / s.full_speed_m_s;
            return Signals { left: -signal, right: signal };
        }
        let since_ns = *self.stands_ns.get_or_insert(at_ns);
        if at_ns.saturating_sub(since_ns) > STANDS_NS {
            self.felt.mark_ahead(pose);
            self.stands_ns = None;
        }
        Signals::default()
    }
}

/// Refuses invalid potentials.
pub(super) fn check(parameters: &Parameters) -> Result<(), ParameterError> {
    let named = [("obstacles", &parameters.obstacles), ("waypoints", &parameters.waypoints)];
    let named = named
        .into_iter()
        .flat_map(|(name, all)| all.iter().enumerate().map(move |(i, one)| (format!("{name}[{i}]"), *one)));
    for (name, potential) in [("goal".to_owned(), parameters.goal)].into_iter().chain(named) {
        let sizes = [("beta_m", potential.beta_m), ("gamma_m", potential.gamma_m)];
        check_positive(sizes.map(|(field, value)| (format!("{name}.{field}"), value)))?;
    }
    Ok(())
}

impl PotentialField {
    /// The earlier way does not count: it may have led elsewhere, also away from the goal. The obstacles that were
    /// sensed do count.
    fn begin(&mut self) {
        self.arrived = false;
        self.lock.begin();
        (self.detour, self.stands_ns) = (None, None);
    }
}

impl MotorBehavior for PotentialField {
    fn enter(&mut self, _: &mut StepContext<'_>) {
        self.begin();
    }

    fn step(&mut self, context: &mut StepContext<'_>) -> Option<Signals> {
        self.felt.feel(context.turn, context.beliefs);
        let Some(estimate) = context.beliefs.pose else { return Some(Signals::default()) };
        let (signals, intention) = self.drive(&estimate.world_from_robot, context.turn.at_ns);
        let waypoints = self.waypoints.iter().map(Potential::center);
        let round = self.detour.iter().flat_map(|detour| detour.left()).copied();
        context.beliefs.path = round.chain(waypoints).chain([self.parameters.goal.center()]).collect();
        intention.clone_into(&mut context.beliefs.intention);
        Some(signals)
    }

    fn goes_by_pose(&self) -> bool {
        true
    }
}

pub(super) fn distance(a: Point, b: Point) -> f64 {
    math::hypot(a.x - b.x, a.y - b.y)
}

/// A detour begins with so much room in the direction of the field, in radii of the body.
const AHEAD: f64 = 1.0;
/// A robot with no more room ahead than this does not drive on, in radii of the body.
const STOP: f64 = 0.3;
/// The additional room with which it drives at its full speed, in radii of the body.
const SLOW: f64 = 1.5;
/// On a detour it turns on the spot if the heading is off by more than that, in radians: it may be narrow there.
const ROTATE_ABOVE_RAD: f64 = 0.35;
/// Part of its speed that is left where there is little room.
const SLOWEST: f64 = 0.25;
/// A robot that stands before something for so long marks it, in nanoseconds.
const STANDS_NS: u64 = 1_000_000_000;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_body::body;

    fn wedge(escape_after_s: f64, waypoints: Vec<Potential>) -> PotentialField {
        let hill = |x_m, y_m| Potential { x_m, y_m, alpha: 0.6, beta_m: 0.25, gamma_m: 0.25 };
        let parameters = Parameters {
            goal: Potential { x_m: 2.0, y_m: 0.0, alpha: -1.0, beta_m: 3.0, gamma_m: 3.0 },
            obstacles: vec![hill(1.0, 0.0), hill(0.8, 0.3), hill(0.8, -0.3)],
            waypoints,
            passed_m: 0.1,
            arrived_m: 0.05,
            escape_after_s,
            sight: sight::Parameters::default(),
            steering: Steering::default(),
        };
        PotentialField::new(parameters, &body(&[])).unwrap()
    }

    /// A robot of half track 0.2 m whose wheels obey commands at once: where it is, when it arrived, and how often it
    /// began to turn on the spot.
    fn drive(mut field: PotentialField, y_m: f64, for_s: f64) -> (Pose, Option<f64>, u32) {
        let (mut pose, dt_s, mut rotations, mut rotated) = (Pose::new(-1.0, y_m, 0.0), 0.01, 0, false);
        for step in 0..(for_s / dt_s) as u64 {
            let (Signals { left, right }, _) = field.drive(&pose, step * 10_000_000);
            rotations += u32::from(field.helm.rotates() && !rotated);
            rotated = field.helm.rotates();
            if field.has_arrived() {
                return (pose, Some(step as f64 * dt_s), rotations);
            }
            // Half a metre a second for a signal of 1.
            let (speed, turn) = ((left + right) / 4.0, (right - left) / 0.8);
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

    /// Such as a robot that has charged its battery elsewhere in between.
    #[test]
    fn who_is_led_away_from_the_goal_has_not_arrived_any_more() {
        let mut field = wedge(0.0, Vec::new());
        let there = Pose::new(2.0, 0.0, 0.0);
        assert_eq!(field.drive(&there, 0).1, "has arrived");
        field.begin();
        assert_ne!(field.drive(&Pose::new(-1.0, 2.0, 0.0), 10_000_000).1, "has arrived");
        assert!(!field.has_arrived());
    }

    #[test]
    fn what_makes_no_sense_is_said() {
        let bad = Potential { x_m: 0.0, y_m: 0.0, alpha: 1.0, beta_m: 1.0, gamma_m: 0.0 };
        let mut parameters = wedge(0.0, Vec::new()).parameters;
        parameters.waypoints.push(bad);
        let problem = PotentialField::new(parameters, &body(&[])).unwrap_err().to_string();
        assert_eq!(problem, "waypoints[0].gamma_m: must be positive, is 0");
    }
}
