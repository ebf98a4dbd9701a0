//! The motor behaviour.

use baudbot_brain::{Body, Signals};
use baudbot_geometry::{Direction, Point, Pose, Vector, angle, math};
use serde::Deserialize;

use super::candidates::{Wanted, choose};
use super::histogram::{Histogram, Window};
use super::memory::Memory;
use super::sight::{self, Sight};
use crate::navigation::Goals;
use crate::odometry::Odometry;
use crate::parameter::{ParameterError, check_not_negative, check_positive, for_body};
use crate::process::{MotorBehavior, StepContext};
use crate::steering::{Helm, Steering, braking};

/// The goals, and the sensors that it heeds on its way.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Goals `[x, y]`, in metres, in the frame of the believed pose, one after the other.
    pub goals_m: Vec<[f64; 2]>,
    /// A goal is reached within this distance, in metres.
    #[serde(default = "reached_m")]
    pub reached_m: f64,
    /// The first goal comes again after the last.
    #[serde(default)]
    pub again: bool,
    /// The sensors that are used.
    #[serde(default)]
    pub sight: sight::Parameters,
    /// Room to be kept beside the body, in metres: r_s. By default three quarters of its radius.
    pub clearance_m: Option<f64>,
    /// The distance, in metres, beyond which objects do not count.
    #[serde(default = "window_m")]
    pub window_m: f64,
    /// Side of the cells in which obstacles are remembered, in metres. By default a quarter of the body's radius.
    pub cell_m: Option<f64>,
    /// The time without sight, in seconds, after which an object is forgotten.
    #[serde(default = "forget_s")]
    pub forget_s: f64,
    /// The number of directions in the histogram.
    #[serde(default = "sectors")]
    pub sectors: usize,
    /// τ_low: a direction with less becomes free.
    #[serde(default = "low")]
    pub low: f64,
    /// τ_high: a direction with more becomes blocked.
    #[serde(default = "high")]
    pub high: f64,
    /// Width from which on an opening is wide, in radians: s_max.
    #[serde(default = "wide_rad")]
    pub wide_rad: f64,
    /// μ₁, μ₂, μ₃: costs of an angle to the goal's direction, to the heading, and to the direction before.
    #[serde(default = "costs")]
    pub costs: [f64; 3],
    /// Radius of the turns that it makes, in metres; 0 if it turns on the spot.
    #[serde(default)]
    pub turn_radius_m: f64,
    /// The robot slows down with less room ahead than this, in metres.
    #[serde(default = "slow_m")]
    pub slow_m: f64,
    /// The robot stops with less room ahead than this, in metres. By default half of the body's radius.
    pub stop_m: Option<f64>,
    /// The greatest speed at which a person may walk into the robot's path, in metres a second; 0 if there are no
    /// people. Only scans of lasers alone are used for that. A person slower than [`Memory::slowest_m_s`] is taken to
    /// stand.
    #[serde(default = "walker_m_s")]
    pub walker_m_s: f64,
    /// The time from when something is seen until the robot has stopped for that, in seconds.
    #[serde(default = "halt_s")]
    pub halt_s: f64,
    /// The robot stands still if there was no reading for so long, in seconds.
    #[serde(default = "stale_s")]
    pub stale_s: f64,
    /// The gains and speeds of its steering.
    #[serde(default)]
    pub steering: Steering,
}

fn reached_m() -> f64 {
    0.1
}

fn window_m() -> f64 {
    1.5
}

fn forget_s() -> f64 {
    5.0
}

fn sectors() -> usize {
    72
}

fn low() -> f64 {
    0.25
}

fn high() -> f64 {
    0.5
}

fn wide_rad() -> f64 {
    0.8
}

fn costs() -> [f64; 3] {
    [5.0, 2.0, 2.0]
}

fn slow_m() -> f64 {
    0.6
}

fn walker_m_s() -> f64 {
    0.5
}

fn halt_s() -> f64 {
    0.9
}

fn stale_s() -> f64 {
    0.5
}

/// The parameters that follow from the body, in metres.
#[derive(Clone, Copy, Debug)]
struct Lengths {
    clearance_m: f64,
    cell_m: f64,
    stop_m: f64,
}

impl Lengths {
    fn new(p: &Parameters, radius_m: f64) -> Self {
        Self {
            clearance_m: p.clearance_m.unwrap_or_else(|| for_body(0.15, radius_m)),
            cell_m: p.cell_m.unwrap_or_else(|| for_body(0.05, radius_m)),
            stop_m: p.stop_m.unwrap_or_else(|| for_body(0.1, radius_m)),
        }
    }
}

/// A behaviour that goes to a goal past what it sees.
#[derive(Clone, Debug)]
pub struct Vfh {
    parameters: Parameters,
    goals: Goals,
    sight: Sight,
    memory: Memory,
    histogram: Histogram,
    helm: Helm,
    radius_m: f64,
    lengths: Lengths,
    previous_rad: Option<f64>,
    seen_ns: Option<u64>,
    /// The instant at which the newest scan was taken.
    taken_ns: u64,
}

impl Vfh {
    /// A `Vfh` for a robot with this body.
    ///
    /// # Errors
    /// If the parameters are invalid, or it sees nothing.
    pub fn new(parameters: Parameters, body: &Body) -> Result<Self, ParameterError> {
        let p = &parameters;
        p.steering.check()?;
        let lengths = Lengths::new(p, body.radius_m);
        let cell_m = lengths.cell_m;
        check(p, &lengths)?;
        let most_m = 0.5 * (body.radius_m + lengths.clearance_m);
        if cell_m > most_m {
            let problem = "must be at most half of the body's radius with its clearance";
            return Err(ParameterError::value("cell_m", format_args!("{problem}, {most_m}, is {cell_m}")));
        }
        let (sight, slowest_m_s) = (Sight::new(&p.sight, body)?, Memory::slowest_m_s(cell_m));
        if sight.tells_walkers() && p.walker_m_s > 0.0 && p.walker_m_s < slowest_m_s {
            let why = "with cells of `cell_m` anything slower cannot be told from what stands still";
            let found = p.walker_m_s;
            let problem = format_args!("must be 0, or at least {slowest_m_s}, is {found}: {why}");
            return Err(ParameterError::value("walker_m_s", problem));
        }
        let goals = Goals::new("goals_m", &p.goals_m, p.reached_m, p.again)?;
        Ok(Self {
            goals,
            sight,
            memory: Memory::new(cell_m, p.window_m, p.forget_s),
            histogram: Histogram::new(p.sectors),
            helm: Helm::new(p.steering),
            radius_m: body.radius_m,
            lengths,
            previous_rad: None,
            seen_ns: None,
            taken_ns: 0,
            parameters,
        })
    }

    /// Whether all goals have been reached.
    pub fn has_arrived(&self) -> bool {
        self.goals.has_arrived()
    }

    /// Takes in what has come.
    fn look(&mut self, context: &StepContext<'_>) {
        for seen in self.sight.look(context.turn, context.beliefs) {
            self.memory.see(&seen.scan, &seen.world_from_robot, seen.at_ns);
            self.seen_ns = Some(context.turn.at_ns);
            self.taken_ns = self.taken_ns.max(seen.at_ns);
        }
    }

    /// The direction to drive in, in radians; `None` if all are blocked.
    fn direction(&mut self, world_from_robot: &Pose, goal: Point) -> Option<f64> {
        let p = &self.parameters;
        let (here, heading_rad) = (world_from_robot.position, world_from_robot.heading);
        let offset = goal - here;
        let (wide_m, slack_m) = (self.radius_m + self.lengths.clearance_m, self.lengths.cell_m);
        let window = Window { radius_m: p.window_m, wide_m, slack_m, low: p.low, high: p.high };
        // An object beyond the goal is not in the way.
        let near = |obstacle: &Point| (obstacle - here).norm() <= offset.norm();
        self.histogram.update(here, self.memory.obstacles().filter(near), &window);
        let obstacles = self.memory.obstacles().filter(near);
        let masked = self.histogram.masked(world_from_robot, obstacles, p.turn_radius_m, &window);
        let wanted = Wanted {
            goal_rad: math::atan2(offset.y, offset.x),
            heading_rad,
            previous_rad: self.previous_rad.unwrap_or(heading_rad),
            costs: p.costs,
            wide_rad: p.wide_rad,
        };
        let chosen = choose(&masked, &wanted);
        self.previous_rad = chosen.or(self.previous_rad);
        chosen
    }

    /// The distance that the body can go straight on before it meets something, in metres.
    fn room_m(&self, world_from_robot: &Pose) -> f64 {
        let ahead = Direction::from_angle(world_from_robot.heading).vector();
        let half_width_m = self.radius_m + 0.5 * self.lengths.clearance_m;
        let room = |obstacle: Point| {
            let offset: Vector = obstacle - world_from_robot.position;
            let (along_m, aside_m) = (offset.dot(&ahead), ahead.perp(&offset));
            let is_ahead = along_m > 0.0 && aside_m.abs() < half_width_m;
            is_ahead.then(|| along_m - math::sqrt(half_width_m * half_width_m - aside_m * aside_m))
        };
        self.memory.obstacles().filter_map(room).fold(f64::INFINITY, f64::min)
    }

    /// The greatest speed at which it stops before a walking person can reach it, in metres a second. People who come from
    /// behind are ignored.
    fn safe_m_s(&self, world_from_robot: &Pose, now_ns: u64) -> f64 {
        let p = &self.parameters;
        if p.walker_m_s == 0.0 || !self.sight.tells_walkers() {
            return f64::INFINITY;
        }
        let age_s = now_ns.saturating_sub(self.taken_ns) as f64 * 1e-9;
        let walked_m = p.walker_m_s * (age_s + p.halt_s);
        let reach_m = self.radius_m + walked_m + p.steering.speed_m_s * p.halt_s;
        let ahead = world_from_robot.direction().vector();
        let offset = |obstacle: Point| obstacle - world_from_robot.position;
        let counts =
            |obstacle: Point| offset(obstacle).dot(&ahead) > 0.0 && offset(obstacle).norm() < reach_m;
        let safe_m_s = |obstacle| (offset(obstacle).norm() - self.radius_m - walked_m) / p.halt_s;
        self.memory.walkers(counts).map(safe_m_s).fold(f64::INFINITY, f64::min)
    }

    /// Signals towards a direction, with as much speed as there is room, at most a part of the whole; and the stated
    /// intention.
    fn signals(
        &mut self,
        world_from_robot: &Pose,
        direction_rad: f64,
        most: f64,
        now_ns: u64,
    ) -> (Signals, &'static str) {
        let p = &self.parameters;
        let part = ((self.room_m(world_from_robot) - self.lengths.stop_m) / p.slow_m).min(most);
        let safe = self.safe_m_s(world_from_robot, now_ns) / p.steering.speed_m_s;
        if part > 0.0 && safe > SLOWEST {
            let part = part.min(safe);
            return (self.helm.signals(world_from_robot, direction_rad, part.max(SLOWEST)), "");
        }
        let why = if part > 0.0 { "waits for somebody" } else { "has no room ahead" };
        // There is no room to drive, but to turn.
        let off_rad = angle::difference(direction_rad, world_from_robot.heading);
        let is_off = off_rad.abs() > p.steering.rotate_until_rad;
        let signal = p.steering.rotation_m_s.copysign(off_rad) / p.steering.full_speed_m_s;
        (if is_off { Signals { left: -signal, right: signal } } else { Signals::default() }, why)
    }

    /// Signals on the way to a goal, and the stated intention.
    fn drive(&mut self, world_from_robot: &Pose, goal: Point, now_ns: u64) -> (Signals, &'static str) {
        let most =
            if self.goals.is_last() { braking((goal - world_from_robot.position).norm()) } else { 1.0 };
        if let Some(direction_rad) = self.direction(world_from_robot, goal) {
            return self.signals(world_from_robot, direction_rad, most, now_ns);
        }
        // Round about: to the left, until a direction becomes free.
        let signal = self.parameters.steering.rotation_m_s / self.parameters.steering.full_speed_m_s;
        (Signals { left: -signal, right: signal }, "sees no way")
    }
}

/// Checks the parameters.
fn check(p: &Parameters, lengths: &Lengths) -> Result<(), ParameterError> {
    check_positive([
        ("window_m", p.window_m),
        ("cell_m", lengths.cell_m),
        ("forget_s", p.forget_s),
        ("low", p.low),
        ("wide_rad", p.wide_rad),
        ("slow_m", p.slow_m),
        ("halt_s", p.halt_s),
        ("stale_s", p.stale_s),
    ])?;
    let others = [
        ("clearance_m", lengths.clearance_m),
        ("turn_radius_m", p.turn_radius_m),
        ("stop_m", lengths.stop_m),
        ("walker_m_s", p.walker_m_s),
    ];
    check_not_negative(others.into_iter().chain(p.costs.map(|cost| ("costs", cost))))?;
    if lengths.cell_m * 1000.0 < p.window_m {
        return Err(ParameterError::range("cell_m", "at least a thousandth of window_m", lengths.cell_m));
    }
    if !(8..=720).contains(&p.sectors) {
        return Err(ParameterError::range("sectors", "from 8 to 720", p.sectors as f64));
    }
    if !(p.low..1.0).contains(&p.high) {
        let problem = format_args!("must not be below low, and below 1, is {}", p.high);
        return Err(ParameterError::value("high", problem));
    }
    Ok(())
}

impl MotorBehavior for Vfh {
    /// The tour begins with the first goal again if the robot had arrived; the memory of obstacles is empty.
    fn enter(&mut self, _: &mut StepContext<'_>) {
        self.goals.begin();
        self.sight.forget();
        let p = &self.parameters;
        self.memory = Memory::new(self.lengths.cell_m, p.window_m, p.forget_s);
        self.histogram = Histogram::new(p.sectors);
        (self.previous_rad, self.seen_ns, self.taken_ns) = (None, None, 0);
    }

    fn step(&mut self, context: &mut StepContext<'_>) -> Option<Signals> {
        self.look(context);
        let estimate = context.beliefs.pose?;
        let goal = self.goals.from(estimate.world_from_robot.position);
        context.beliefs.path = self.goals.left().to_vec();
        // A sight counts only once odometry gives its pose.
        let patience_ns = context.beliefs.odometry.as_ref().map_or(0, Odometry::patience_ns);
        let stale_ns = ((self.parameters.stale_s * 1e9) as u64).max(patience_ns);
        let is_blind =
            self.seen_ns.is_none_or(|seen_ns| context.turn.at_ns.saturating_sub(seen_ns) > stale_ns);
        let (signals, intention) = match goal {
            None => (Signals::default(), if self.has_arrived() { "has arrived" } else { "" }),
            Some(_) if is_blind => {
                let beliefs = &mut *context.beliefs;
                let awaited = self.sight.awaited(context.turn, beliefs, self.seen_ns.unwrap_or_default());
                beliefs.awaited = beliefs.awaited.take().or(awaited);
                (Signals::default(), "sees nothing")
            }
            Some(goal) => self.drive(&estimate.world_from_robot, goal, context.turn.at_ns),
        };
        intention.clone_into(&mut context.beliefs.intention);
        Some(signals)
    }

    fn goes_by_pose(&self) -> bool {
        true
    }
}

/// Part of its speed that is left where there is little room.
const SLOWEST: f64 = 0.2;

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
