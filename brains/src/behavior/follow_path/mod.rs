//! Path following: to goals in a known map, on a planned path that keeps clear of the walls, by pure pursuit.
//!
//! The paths from goal to goal are known from the beginning. The robot plans one to its first goal, and plans again if it has
//! strayed: because something pushed it, or because localization has corrected its pose. It stands while it plans, since
//! planning a path through a large map takes longer than one step may. With a `field` it goes around what is on no map (`around`). In the notes a path of §6.2.1 is followed from cell to
//! cell; everything between planning and wheels is ours.

mod around;

use std::task::{Poll, ready};

use baudbot_brain::{Body, Signals};
use baudbot_geometry::{Point, Pose};
use serde::Deserialize;

use self::around::Around;
use crate::navigation::{CELLS_A_STEP, Floor, Goals, Method, Path, Pursuit};
use crate::parameter::{ParameterError, check_not_negative, check_positive, for_body};
use crate::planning::ThetaStar;
use crate::process::{MotorBehavior, StepContext};
use crate::steering::{Helm, Steering, braking};

/// The goals, and the walls between which it drives.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Walls of the map, `[x, y, x, y]` in metres, in the frame of the believed pose.
    pub walls_m: Vec<[f64; 4]>,
    /// Goals `[x, y]`, in metres, one after the other.
    pub goals_m: Vec<[f64; 2]>,
    /// Room that is kept between the body and each wall, in metres. By default half of its radius.
    pub clearance_m: Option<f64>,
    /// Side of the map's cells, in metres. By default a quarter of the body's radius.
    pub cell_m: Option<f64>,
    /// The method that finds a path.
    #[serde(default)]
    pub method: Method,
    /// The distance on its way at which it aims, in metres.
    #[serde(default = "look_ahead_m")]
    pub look_ahead_m: f64,
    /// A goal is reached within this distance, in metres.
    #[serde(default = "reached_m")]
    pub reached_m: f64,
    /// The path is planned again if the robot is farther from it than this, in metres.
    #[serde(default = "stray_m")]
    pub stray_m: f64,
    /// The first goal comes again after the last.
    #[serde(default)]
    pub again: bool,
    /// The potential field by which it goes around what is on no map; without it, it does not look.
    pub field: Option<around::Parameters>,
    /// The gains and speeds of its steering.
    #[serde(default)]
    pub steering: Steering,
}

fn look_ahead_m() -> f64 {
    0.4
}

fn reached_m() -> f64 {
    0.05
}

fn stray_m() -> f64 {
    0.3
}

/// A behaviour that follows planned paths.
#[derive(Clone, Debug)]
pub struct FollowPath {
    floor: Floor,
    goals: Goals,
    /// The path to each goal from the one before it; to the first one that from the last, if it goes round.
    paths: Vec<Option<Vec<Point>>>,
    helm: Helm,
    half_track_m: f64,
    look_ahead_m: f64,
    stray_m: f64,
    /// The goal, by its place, and the way there.
    pursuit: Option<(usize, Pursuit)>,
    /// A path that is being planned: to which goal, and from where.
    planned: Option<(usize, Point)>,
    search: ThetaStar,
    /// The goal to which there was no path, and the instant of the next attempt.
    retry: Option<(usize, u64)>,
    around: Option<Around>,
}

impl FollowPath {
    /// A `FollowPath` for a robot with this body.
    ///
    /// # Errors
    /// If the parameters are invalid, a goal is too near to a wall, or no path leads from one goal to the next.
    pub fn new(parameters: &Parameters, body: &Body) -> Result<Self, ParameterError> {
        let p = parameters;
        p.steering.check()?;
        check_positive([("look_ahead_m", p.look_ahead_m), ("stray_m", p.stray_m)])?;
        let clearance_m = p.clearance_m.unwrap_or_else(|| for_body(0.1, body.radius_m));
        let cell_m = p.cell_m.unwrap_or_else(|| for_body(0.05, body.radius_m));
        check_not_negative([("clearance_m", clearance_m)])?;
        let goals = Goals::new("goals_m", &p.goals_m, p.reached_m, p.again)?;
        let floor = Floor::new(&p.walls_m, cell_m, body.radius_m + clearance_m, p.method)?;
        Ok(Self {
            paths: paths(&floor, goals.points(), p.again)?,
            floor,
            goals,
            helm: Helm::new(p.steering),
            half_track_m: body.half_track_m,
            look_ahead_m: p.look_ahead_m,
            stray_m: p.stray_m,
            pursuit: None,
            planned: None,
            search: ThetaStar::default(),
            retry: None,
            around: p.field.as_ref().map(|field| Around::new(field, body, p.look_ahead_m)).transpose()?,
        })
    }

    /// Whether all goals have been reached.
    pub fn has_arrived(&self) -> bool {
        self.goals.has_arrived()
    }

    /// Makes sure that there is a path to the goal. Pending until there is one; an error if there is none.
    fn plan(&mut self, here: Point, goal: Point, at_ns: u64) -> Poll<Result<(), NoWay>> {
        let place = self.goals.next();
        let is_followed = match &mut self.pursuit {
            Some((to, pursuit)) if *to == place => pursuit.advance(here) <= self.stray_m,
            _ => self.go_on(place, here),
        };
        if is_followed {
            return Poll::Ready(Ok(()));
        }
        self.pursuit = None;
        if self.retry.is_some_and(|(to, retry_ns)| to == place && at_ns < retry_ns) {
            return Poll::Ready(Err(NoWay { goal: place, from: here }));
        }
        let from = self.planned.filter(|(to, _)| *to == place).map_or(here, |(_, from)| from);
        self.planned = Some((place, from));
        let path = ready!(self.floor.seek(&mut self.search, from, goal, &mut { CELLS_A_STEP }));
        self.planned = None;
        self.retry = path.is_err().then_some((place, at_ns.saturating_add(RETRY_NS)));
        self.follow(place, path.map_err(|_| NoWay { goal: place, from })?);
        Poll::Ready(Ok(()))
    }

    /// Takes the path that is known from one goal to the next, if the robot is at the former and nothing is between.
    fn go_on(&mut self, place: usize, here: Point) -> bool {
        let Some(path) = &self.paths[place] else { return false };
        let is_there = path.first().is_some_and(|first| (first - here).norm() <= self.goals.reached_m());
        // Straight to where the path first turns, if it can.
        let first = (0..path.len().min(2)).rev().find(|&i| self.floor.is_clear(here, path[i]));
        let Some(first) = first.filter(|_| is_there) else { return false };
        let path = [here].into_iter().chain(path[first..].iter().copied()).collect();
        self.follow(place, path);
        true
    }

    fn follow(&mut self, place: usize, path: Vec<Point>) {
        self.pursuit = Some((place, Pursuit::new(Path::new(path), self.look_ahead_m)));
    }

    /// Signals on the way.
    fn drive(&mut self, world_from_robot: &Pose) -> Signals {
        let here = world_from_robot.position;
        let Some((_, pursuit)) = &self.pursuit else { return Signals::default() };
        let Some(target) = pursuit.target(|point| self.floor.is_clear(here, point)) else {
            return Signals::default();
        };
        let part = if self.goals.is_last() { braking(pursuit.left_m()) } else { 1.0 };
        let down_rad = self.around.as_ref().and_then(|around| around.heading_rad(here, target));
        if let Some(heading_rad) = down_rad {
            return self.helm.signals(world_from_robot, heading_rad, part);
        }
        self.helm.pursue(world_from_robot, target, self.half_track_m, part)
    }
}

/// No way leads to a goal, by its place in the list, from where the robot is.
#[derive(Debug, thiserror::Error)]
#[error("goals_m[{goal}]: no path leads there from ({:.2} m, {:.2} m)", from.x, from.y)]
struct NoWay {
    goal: usize,
    from: Point,
}

/// The paths from goal to goal: what can be known of them before it is known where the robot is.
fn paths(floor: &Floor, goals: &[Point], again: bool) -> Result<Vec<Option<Vec<Point>>>, ParameterError> {
    let place = |point: &Point| format!("({} m, {} m)", point.x, point.y);
    if let Some(i) = goals.iter().position(|goal| !floor.is_free(*goal)) {
        let why = "is outside the map, or closer to a wall than the body's radius and `clearance_m` allow";
        return Err(ParameterError::value(
            format_args!("goals_m[{i}]"),
            format_args!("{} {why}", place(&goals[i])),
        ));
    }
    let before = |i: usize| i.checked_sub(1).or_else(|| again.then_some(goals.len() - 1));
    let path = |i: usize| {
        let Some(before) = before(i) else { return Ok(None) };
        let (from, to) = (&goals[before], &goals[i]);
        floor.path(*from, *to).map(Some).map_err(|_| {
            let why = "with the body's radius and `clearance_m` on both sides";
            let problem = format_args!("no path leads to {} from {}, {why}", place(to), place(from));
            ParameterError::value(format_args!("goals_m[{i}]"), problem)
        })
    };
    (0..goals.len()).map(path).collect()
}

impl MotorBehavior for FollowPath {
    /// The tour begins with the first goal again if the robot had arrived; one that was interrupted goes on, on a new
    /// path.
    fn enter(&mut self, _: &mut StepContext<'_>) {
        self.goals.begin();
        (self.pursuit, self.planned, self.retry) = (None, None, None);
    }

    fn step(&mut self, context: &mut StepContext<'_>) -> Option<Signals> {
        if let Some(around) = &mut self.around {
            around.look(context.turn, context.beliefs, &self.floor);
        }
        let Some(estimate) = context.beliefs.pose else { return Some(Signals::default()) };
        let world_from_robot = estimate.world_from_robot;
        let here = world_from_robot.position;
        context.beliefs.path.clear();
        context.beliefs.intention.clear();
        let Some(goal) = self.goals.from(here) else {
            context.beliefs.intention =
                if self.has_arrived() { "has arrived".to_owned() } else { String::new() };
            return Some(Signals::default());
        };
        let wait = match self.plan(here, goal, context.turn.at_ns) {
            Poll::Ready(Ok(())) => None,
            Poll::Ready(Err(no_way)) => Some(no_way.to_string()),
            Poll::Pending => Some("plans its path".to_owned()),
        };
        if let Some(why) = wait {
            context.beliefs.intention = why;
            return Some(Signals::default());
        }
        if let Some((_, pursuit)) = &self.pursuit {
            context.beliefs.path = pursuit.rest().collect();
        }
        Some(self.drive(&world_from_robot))
    }

    fn goes_by_pose(&self) -> bool {
        true
    }
}

/// So long it waits before it looks for a path again, in nanoseconds.
const RETRY_NS: u64 = 1_000_000_000;

#[cfg(test)]
mod tests;
