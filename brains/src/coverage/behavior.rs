//! The motor behaviour. It stands while it plans.

use std::collections::VecDeque;
use std::task::{Poll, ready};

use baudbot_brain::{Body, Signals};
use baudbot_geometry::{Point, Pose};
use serde::Deserialize;

use super::passage::Passage;
use super::regions::{Parts, Region, Rows, regions};
use crate::navigation::{CELLS_A_STEP, Floor, Method, Path, Pursuit};
use crate::parameter::{ParameterError, check_not_negative, check_positive, for_body};
use crate::planning::ThetaStar;
use crate::process::{MotorBehavior, StepContext};
use crate::steering::{Helm, Steering, braking};

/// Parameters: the floor and the way in which it is covered.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Walls of the map, `[x, y, x, y]` in metres, in the frame of the believed pose.
    pub walls_m: Vec<[f64; 4]>,
    /// The distance from one row to the next, in metres; without it one and a half times the body's radius.
    pub row_m: Option<f64>,
    /// Room that is kept between the body and each wall, in metres. By default a quarter of its radius.
    pub clearance_m: Option<f64>,
    /// Side of the map's cells, in metres. By default an eighth of the body's radius.
    pub cell_m: Option<f64>,
    /// The distance on a row at which it aims, in metres.
    #[serde(default = "look_ahead_m")]
    pub look_ahead_m: f64,
    /// The robot turns at the end of a row within this distance, in metres.
    #[serde(default = "reached_m")]
    pub reached_m: f64,
    /// The robot plans a path back to its row if it is farther from it than this, in metres.
    #[serde(default = "stray_m")]
    pub stray_m: f64,
    /// The gains and speeds of its steering.
    #[serde(default)]
    pub steering: Steering,
}

fn look_ahead_m() -> f64 {
    0.4
}

fn reached_m() -> f64 {
    0.03
}

fn stray_m() -> f64 {
    0.3
}

/// A behaviour that covers a floor.
#[derive(Clone, Debug)]
pub struct CoverRows {
    floor: Floor,
    parts: Parts,
    /// The regions of the whole map, with rows along each axis.
    regions: [(Rows, Vec<Region>); 2],
    rows: Rows,
    /// Cells from one row to the next.
    apart: usize,
    /// The regions that are left; `None` before the robot's pose is known, and with it the part of the floor that it
    /// can reach.
    left: Option<Vec<Region>>,
    /// Straight pieces of the path that is left in this region.
    wheels: VecDeque<Path>,
    pursuit: Option<Pursuit>,
    /// The path to the next region that is being planned.
    passage: Option<Passage>,
    /// The start of the way back and the rest of the leg, after the robot has strayed or was interrupted.
    back: Option<(Point, Vec<Point>)>,
    search: ThetaStar,
    helm: Helm,
    half_track_m: f64,
    look_ahead_m: f64,
    reached_m: f64,
    stray_m: f64,
}

impl CoverRows {
    /// A `CoverRows` for a robot with this body.
    ///
    /// # Errors
    /// If the parameters are invalid.
    pub fn new(parameters: &Parameters, body: &Body) -> Result<Self, ParameterError> {
        let p = parameters;
        p.steering.check()?;
        let row_m = p.row_m.unwrap_or(1.5 * body.radius_m);
        check_positive([
            ("row_m", row_m),
            ("look_ahead_m", p.look_ahead_m),
            ("reached_m", p.reached_m),
            ("stray_m", p.stray_m),
        ])?;
        let clearance_m = p.clearance_m.unwrap_or_else(|| for_body(0.05, body.radius_m));
        let cell_m = p.cell_m.unwrap_or_else(|| for_body(0.025, body.radius_m));
        check_not_negative([("clearance_m", clearance_m)])?;
        let floor = Floor::new(&p.walls_m, cell_m, body.radius_m + clearance_m, Method::ThetaStar)?;
        let apart = ((row_m / cell_m + ROUNDING) as usize).max(1);
        Ok(Self {
            parts: Parts::new(floor.grid()),
            regions: [Rows::AlongX, Rows::AlongY].map(|rows| (rows, regions(floor.grid(), rows, apart))),
            floor,
            rows: Rows::AlongX,
            apart,
            left: None,
            wheels: VecDeque::new(),
            pursuit: None,
            passage: None,
            back: None,
            search: ThetaStar::default(),
            helm: Helm::new(p.steering),
            half_track_m: body.half_track_m,
            look_ahead_m: p.look_ahead_m,
            reached_m: p.reached_m,
            stray_m: p.stray_m,
        })
    }

    /// Whether all that can be reached has been covered.
    pub fn has_covered(&self) -> bool {
        self.left.as_ref().is_some_and(Vec::is_empty) && self.wheels.is_empty() && self.pursuit.is_none()
    }

    /// The regions that a robot can reach from a free place, with rows along the axis along which there are fewer of them.
    fn divide(&mut self, place: Point) -> Vec<Region> {
        let Some(cell) = self.floor.grid().cell_at(place) else { return Vec::new() };
        let part = self.parts.of(cell);
        let of_part = |(rows, all): &(Rows, Vec<Region>)| {
            let is_in = |region: &&Region| self.parts.of(region.a_cell(*rows)) == part;
            (*rows, all.iter().filter(is_in).cloned().collect::<Vec<_>>())
        };
        let count = |(rows, found): &(Rows, Vec<Region>)| -> usize {
            found.iter().map(|region| region.rows(*rows, self.apart).len()).sum()
        };
        let [along_x, along_y] = [of_part(&self.regions[0]), of_part(&self.regions[1])];
        let (rows, found) = if count(&along_y) < count(&along_x) { along_y } else { along_x };
        self.rows = rows;
        found
    }

    /// Plans the path to the next region and through it.
    fn next_region(&mut self, here: Point, cells: &mut usize) -> Poll<()> {
        let Some(left) = &mut self.left else { return Poll::Ready(()) };
        let passage =
            self.passage.get_or_insert_with(|| Passage::new(&self.floor, left, self.rows, self.apart, here));
        match ready!(passage.plan(&self.floor, &mut self.search, cells)) {
            Some((region, path)) => {
                left.remove(region);
                self.wheels = path.wheels(BEND_RAD).into();
            }
            None => left.clear(),
        }
        self.passage = None;
        Poll::Ready(())
    }

    /// Sees to it that there is a leg that is not at its end, unless all is done.
    fn go_on(&mut self, here: Point, cells: &mut usize) -> Poll<()> {
        while self.pursuit.as_ref().is_none_or(|pursuit| pursuit.left_m() <= self.reached_m) {
            self.pursuit = None;
            if self.wheels.is_empty() {
                ready!(self.next_region(here, cells));
            }
            let Some(mut pursuit) = self.wheels.pop_front().map(|leg| Pursuit::new(leg, self.look_ahead_m))
            else {
                break;
            };
            pursuit.advance(here);
            self.pursuit = Some(pursuit);
        }
        Poll::Ready(())
    }

    /// The robot plans a path back to its leg.
    fn lose(&mut self, here: Point) {
        let rest: Vec<_> = self.pursuit.iter().flat_map(Pursuit::rest).collect();
        self.back = (!rest.is_empty()).then_some((here, rest));
    }

    /// Back to the leg that it has strayed from, and on along that. Where no path leads there it keeps what it has: it may
    /// believe to be elsewhere soon.
    fn find_back(&mut self, cells: &mut usize) -> Poll<()> {
        let Some((from, rest)) = &self.back else { return Poll::Ready(()) };
        let path = ready!(self.floor.seek(&mut self.search, *from, rest[0], cells));
        if let Ok(path) = path {
            self.pursuit = None;
            let back = Path::new(path.into_iter().chain(rest.iter().copied()).collect());
            for leg in back.wheels(BEND_RAD).into_iter().rev() {
                self.wheels.push_front(leg);
            }
        }
        self.back = None;
        Poll::Ready(())
    }

    /// Signals on its way. Pending while that is being planned.
    fn drive(&mut self, world_from_robot: &Pose) -> Poll<Signals> {
        let (here, mut cells) = (world_from_robot.position, CELLS_A_STEP);
        let strays = |pursuit: &mut Pursuit| pursuit.advance(here) > self.stray_m;
        if self.back.is_none() && self.pursuit.as_mut().is_some_and(strays) {
            self.lose(here);
        }
        ready!(self.find_back(&mut cells));
        ready!(self.go_on(here, &mut cells));
        let Some(pursuit) = &self.pursuit else { return Poll::Ready(Signals::default()) };
        let target = pursuit.target(|point| self.floor.is_clear(here, point)).unwrap_or(here);
        Poll::Ready(self.helm.pursue(world_from_robot, target, self.half_track_m, braking(pursuit.left_m())))
    }
}

impl MotorBehavior for CoverRows {
    /// The robot goes back to the place of the interruption. The path to a region that was being planned began
    /// elsewhere.
    fn enter(&mut self, context: &mut StepContext<'_>) {
        self.passage = None;
        if let Some(estimate) = context.beliefs.pose {
            self.lose(estimate.world_from_robot.position);
        }
    }

    fn step(&mut self, context: &mut StepContext<'_>) -> Option<Signals> {
        let world_from_robot = context.beliefs.pose?.world_from_robot;
        let place = self.floor.nearest_free(world_from_robot.position);
        if !self.floor.is_free(place) {
            // The believed pose may change soon; then the robot goes on at its row.
            context.beliefs.intention = "is not on its map".to_owned();
            return Some(Signals::default());
        }
        if self.left.is_none() {
            self.left = Some(self.divide(place));
        }
        let driven = self.drive(&world_from_robot);
        let points = self.pursuit.iter().flat_map(Pursuit::rest);
        context.beliefs.path =
            points.chain(self.wheels.iter().flat_map(|leg| leg.points().to_vec())).collect();
        let left = self.left.as_ref().map_or(0, Vec::len);
        context.beliefs.intention = match driven {
            Poll::Pending => format!("plans its path, {left} regions left"),
            Poll::Ready(_) if self.has_covered() => "has covered all".to_owned(),
            Poll::Ready(_) => format!("{left} regions left"),
        };
        Some(match driven {
            Poll::Ready(signals) => signals,
            Poll::Pending => Signals::default(),
        })
    }

    fn goes_by_pose(&self) -> bool {
        true
    }
}

/// Part of a cell by which a distance may fall short of a whole number of cells and still count as that.
const ROUNDING: f64 = 1e-9;
/// The bend above which the robot turns on the spot, in radians.
const BEND_RAD: f64 = 0.6;

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
