//! The motor behaviour.
//!
//! Regions are taken as they come: the next one is that of which a corner is nearest along a way. That is not the shortest
//! way through all of them, which would be a travelling salesman's.

use std::collections::VecDeque;

use baudbot_client::{Body, Signals};
use baudbot_geometry::{Point, Pose};
use serde::Deserialize;

use super::regions::{Region, Rows, reachable, regions};
use crate::behavior::Steering;
use crate::behavior::steering::{Helm, braking};
use crate::navigation::{Floor, Method, Pursuit, Way};
use crate::process::{Moment, MotorBehavior};

/// What is covered, and how.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Walls of the map, `[x, y, x, y]` in metres, in the frame of the believed pose.
    pub walls_m: Vec<[f64; 4]>,
    /// From one row to the next, in metres; without it one and a half times the body's radius.
    pub row_m: Option<f64>,
    /// Room that is kept between the body and each wall, in metres.
    #[serde(default = "clearance_m")]
    pub clearance_m: f64,
    /// Side of the map's cells, in metres.
    #[serde(default = "cell_m")]
    pub cell_m: f64,
    /// How far ahead on a row it looks, in metres.
    #[serde(default = "look_ahead_m")]
    pub look_ahead_m: f64,
    /// It turns at the end of a row within this distance, in metres.
    #[serde(default = "reached_m")]
    pub reached_m: f64,
    /// It finds its way back to its row if it is farther from it than this, in metres.
    #[serde(default = "stray_m")]
    pub stray_m: f64,
    /// How it steers.
    #[serde(default)]
    pub steering: Steering,
}

fn clearance_m() -> f64 {
    0.05
}

fn cell_m() -> f64 {
    0.025
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
    rows: Rows,
    /// Cells from one row to the next.
    apart: usize,
    /// Those that are left; `None` before it is known where the robot is, and so what it can reach.
    left: Option<Vec<Region>>,
    /// Straight pieces of the way that is left in this region.
    legs: VecDeque<Way>,
    pursuit: Option<Pursuit>,
    helm: Helm,
    half_track_m: f64,
    look_ahead_m: f64,
    reached_m: f64,
    stray_m: f64,
}

impl CoverRows {
    /// For a robot with this body.
    ///
    /// # Errors
    /// If the parameters make no sense, in words.
    pub fn new(parameters: &Parameters, body: &Body) -> Result<Self, String> {
        let p = parameters;
        if let Some(problem) = p.steering.problem() {
            return Err(problem);
        }
        let row_m = p.row_m.unwrap_or(1.5 * body.radius_m);
        let positive = [
            ("row_m", row_m),
            ("look_ahead_m", p.look_ahead_m),
            ("reached_m", p.reached_m),
            ("stray_m", p.stray_m),
        ];
        for (name, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return Err(format!("{name}: must be positive, is {value}"));
            }
        }
        if !(p.clearance_m.is_finite() && p.clearance_m >= 0.0) {
            return Err(format!("clearance_m: must not be negative, is {}", p.clearance_m));
        }
        let floor = Floor::new(&p.walls_m, p.cell_m, body.radius_m + p.clearance_m, Method::ThetaStar)?;
        Ok(Self {
            floor,
            rows: Rows::AlongX,
            apart: ((row_m / p.cell_m + ROUNDING) as usize).max(1),
            left: None,
            legs: VecDeque::new(),
            pursuit: None,
            helm: Helm::new(p.steering),
            half_track_m: body.half_track_m,
            look_ahead_m: p.look_ahead_m,
            reached_m: p.reached_m,
            stray_m: p.stray_m,
        })
    }

    /// Whether all that can be reached has been covered.
    pub fn has_covered(&self) -> bool {
        self.left.as_ref().is_some_and(Vec::is_empty) && self.legs.is_empty() && self.pursuit.is_none()
    }

    /// The regions that a robot can reach from a free place, with rows along the axis along which there are fewer of them.
    fn divide(&mut self, place: Point) -> Vec<Region> {
        let Some(cell) = self.floor.grid().cell_at(place) else { return Vec::new() };
        let grid = reachable(self.floor.grid(), cell);
        let found = [Rows::AlongX, Rows::AlongY].map(|rows| (rows, regions(&grid, rows, self.apart)));
        let count = |(rows, found): &(Rows, Vec<Region>)| -> usize {
            found.iter().map(|region| region.rows(*rows, self.apart).len()).sum()
        };
        let [along_x, along_y] = found;
        let (rows, found) = if count(&along_y) < count(&along_x) { along_y } else { along_x };
        self.rows = rows;
        found
    }

    /// Takes the region of which a corner is nearest, and plans the way there and through it.
    fn next_region(&mut self, here: Point) {
        let Some(left) = &mut self.left else { return };
        let center = |cell| self.floor.grid().center(cell);
        let mut corners: Vec<_> = left
            .iter()
            .enumerate()
            .flat_map(|(i, region)| entries(region, self.rows, self.apart).map(|rows| (i, rows)))
            .map(|(i, rows)| (i, rows.into_iter().map(|row| row.map(center)).collect::<Vec<_>>()))
            .map(|(i, rows)| ((rows[0][0] - here).norm(), i, rows))
            .collect();
        corners.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut best: Option<(f64, usize, Way, Vec<[Point; 2]>)> = None;
        for (straight_m, i, rows) in corners {
            if best.as_ref().is_some_and(|(length_m, ..)| straight_m >= *length_m) {
                break;
            }
            let Ok(way) = self.floor.way(here, rows[0][0]) else { continue };
            let way = Way::new(way);
            if best.as_ref().is_none_or(|(length_m, ..)| way.length_m() < *length_m) {
                best = Some((way.length_m(), i, way, rows));
            }
        }
        let Some((_, i, way, rows)) = best else {
            left.clear();
            return;
        };
        left.remove(i);
        let points = way.points().to_vec();
        self.legs = self.through(points, &rows).legs(BEND_RAD).into();
    }

    /// A way on through rows, to and fro.
    fn through(&self, mut points: Vec<Point>, rows: &[[Point; 2]]) -> Way {
        for (i, &[near, far]) in rows.iter().enumerate() {
            let [from, to] = if i % 2 == 0 { [near, far] } else { [far, near] };
            if let Some(last) = points.last() {
                points.extend(self.floor.way(*last, from).unwrap_or_default());
            }
            points.push(to);
        }
        Way::new(points)
    }

    /// Sees to it that there is a leg that is not at its end.
    fn go_on(&mut self, here: Point) {
        while self.pursuit.as_ref().is_none_or(|pursuit| pursuit.left_m() <= self.reached_m) {
            self.pursuit = None;
            if self.legs.is_empty() {
                self.next_region(here);
            }
            let Some(mut pursuit) = self.legs.pop_front().map(|leg| Pursuit::new(leg, self.look_ahead_m))
            else {
                return;
            };
            pursuit.advance(here);
            self.pursuit = Some(pursuit);
        }
    }

    /// Back to the leg that it has strayed from, and on along that. Where no way leads there it keeps what it has: it may
    /// believe to be elsewhere soon.
    fn find_back(&mut self, here: Point) {
        let rest: Vec<_> = self.pursuit.iter().flat_map(Pursuit::rest).collect();
        if let Some(Ok(way)) = rest.first().map(|place| self.floor.way(here, *place)) {
            self.pursuit = None;
            let back = Way::new(way.into_iter().chain(rest).collect());
            for leg in back.legs(BEND_RAD).into_iter().rev() {
                self.legs.push_front(leg);
            }
        }
    }

    fn drive(&mut self, world_from_robot: &Pose) -> Signals {
        let here = world_from_robot.position;
        if self.pursuit.as_mut().is_some_and(|pursuit| pursuit.advance(here) > self.stray_m) {
            self.find_back(here);
        }
        self.go_on(here);
        let Some(pursuit) = &self.pursuit else { return Signals::default() };
        let target = pursuit.target(|point| self.floor.is_clear(here, point)).unwrap_or(here);
        self.helm.pursue(world_from_robot, target, self.half_track_m, braking(pursuit.left_m()))
    }
}

/// The rows of a region from each of its four corners: first the near end of a row, then its far one.
fn entries(region: &Region, rows: Rows, apart: usize) -> [Vec<[crate::planning::Cell; 2]>; 4] {
    let up = region.rows(rows, apart);
    let down: Vec<_> = up.iter().rev().copied().collect();
    let other_side = |rows: &[[_; 2]]| rows.iter().map(|&[from, to]| [to, from]).collect();
    [other_side(&up), other_side(&down), up, down]
}

impl MotorBehavior for CoverRows {
    /// It finds its way back to where it was interrupted.
    fn enter(&mut self, moment: &mut Moment<'_>) {
        if let Some(estimate) = moment.beliefs.pose {
            self.find_back(estimate.world_from_robot.position);
        }
    }

    fn step(&mut self, moment: &mut Moment<'_>) -> Option<Signals> {
        let world_from_robot = moment.beliefs.pose?.world_from_robot;
        let place = self.floor.nearest_free(world_from_robot.position);
        if !self.floor.is_free(place) {
            // It may believe to be elsewhere soon, and then goes on where it was.
            moment.beliefs.intention = "is nowhere on its map".to_owned();
            return Some(Signals::default());
        }
        if self.left.is_none() {
            self.left = Some(self.divide(place));
        }
        let signals = self.drive(&world_from_robot);
        let points = self.pursuit.iter().flat_map(Pursuit::rest);
        moment.beliefs.path = points.chain(self.legs.iter().flat_map(|leg| leg.points().to_vec())).collect();
        let left = self.left.as_ref().map_or(0, Vec::len);
        moment.beliefs.intention =
            if self.has_covered() { "has covered all".to_owned() } else { format!("{left} regions left") };
        Some(signals)
    }
}

/// Part of a cell by which a distance may fall short of a whole number of cells and still count as that.
const ROUNDING: f64 = 1e-9;
/// At a bend of more than this, in radians, it turns on the spot.
const BEND_RAD: f64 = 0.6;

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
