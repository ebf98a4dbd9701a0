//! Exploration by frontiers: B. Yamauchi, *A frontier-based approach for autonomous exploration*, CIRA 1997.
//!
//! The robot keeps an occupancy grid of all scans. It goes to the nearest place, by the length of the path, from which a
//! cell at the edge of the [dark](crate::mapping::frontier) is in sight within `view_m`, and faces it. As soon as that cell is
//! no longer dark it chooses another. When there is none, it looks from farther away: through an opening that is too narrow for
//! it a laser sees more than a metre. It is done when it can see no such cell from any place that it can reach, and reports
//! [the places that it leaves out](super::LeftOut).
//!
//! At an object that proximity has found and the laser did not see coming, it remembers an obstacle and plans again.
//!
//! *The least width* of a passage is 2 `half_width_m` + `cell_m`, see [`Floor`].
//!
//! *Deviations.*
//!
//! - Yamauchi's robot drives to the middle of a group of frontier cells, and sweeps its sensors all around there.
//! - A cell that is still dark after a look from near is given up: the laser does not show it. So is a cell that too often left
//!   the edge while the robot was on its way, and came back: beside an edge that lies on the border of two cells, free cells
//!   come and go with the laser's noise.
//! - Obstacles that proximity found are forgotten when nothing else is left to be done, so that an obstacle does not close a
//!   room for ever; but not more often than `attempts` times.

mod parameters;

use std::collections::{BTreeMap, BTreeSet};

use baudbot_geometry::{Point, Pose};

use super::approach::{Approach, heading_to, turn};
use super::left_out::{LeftOut, Rest};
use super::outlook::{Outlook, sparse};
use super::{Command, Explorer, Failure, Goal, Input};
use crate::mapping::disc::Disc;
use crate::mapping::floor::is_clear;
use crate::mapping::frontier::{Dark, is_edge};
use crate::mapping::{Cell, Floor, Occupancy, PlacedScan};

pub use parameters::Parameters;

/// A robot that explores by frontiers.
#[derive(Clone, Debug, PartialEq)]
pub struct Frontiers {
    parameters: Parameters,
    grid: Occupancy,
    last_scan: Option<PlacedScan>,
    /// The places, in the world, at which proximity found something.
    bumps: Vec<Point>,
    /// The number of times that the bumps were forgotten.
    forgotten: usize,
    given_up: BTreeSet<Cell>,
    /// The cells that the robot did not get to.
    missed: BTreeSet<Cell>,
    /// The number of times that each cell to which a plan led was no longer part of the edge.
    resolved: BTreeMap<Cell, usize>,
    /// The number of plans that have come to an end.
    ended: usize,
    state: State,
}

#[derive(Clone, Debug, PartialEq)]
enum State {
    Plan,
    Go {
        plan: Plan,
        approach: Approach,
    },
    /// Faces what is dark.
    Look {
        at: Cell,
    },
    Ended(Command),
}

/// A path to a place from which a cell of the edge can be seen.
#[derive(Clone, Debug, PartialEq)]
struct Plan {
    /// Points that are left, the last one first.
    turns: Vec<Point>,
    look_at: Cell,
}

impl Explorer for Frontiers {
    fn step(&mut self, input: &Input<'_>) -> Command {
        self.remember(input);
        loop {
            // Each turn of the loop follows a plan or gives up a cell of the edge.
            if let Some(command) = self.advance(input) {
                return command;
            }
        }
    }

    fn interrupt(&mut self) {
        let is_stuck = self.state == State::Ended(Command::Failed(Failure::Stuck));
        if is_stuck {
            self.bumps.clear();
        }
        if is_stuck || !matches!(self.state, State::Ended(_)) {
            self.state = State::Plan;
        }
    }

    fn goal(&self, here: &Pose) -> Option<Goal> {
        match &self.state {
            State::Go { plan, approach } => {
                let ways = [here.position, approach.to].into_iter().chain(plan.turns.iter().rev().copied());
                let ways: Vec<_> = ways.collect();
                let left_m = ways.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
                Some(Goal { place: self.grid.center(plan.look_at), left_m })
            }
            State::Look { at } => Some(Goal { place: self.grid.center(*at), left_m: 0.0 }),
            State::Plan | State::Ended(_) => None,
        }
    }

    fn abandon(&mut self) {
        let (State::Go { plan: Plan { look_at, .. }, .. } | State::Look { at: look_at }) = self.state else {
            return;
        };
        let cells = self.around(look_at, self.parameters.radius_m);
        self.given_up.extend(&cells);
        self.missed.extend(&cells);
        self.ended += 1;
        self.state = State::Plan;
    }

    fn finish(&mut self, here: &Pose) {
        if matches!(self.state, State::Ended(_)) {
            return;
        }
        let dark = Dark::new(&self.grid, self.parameters.wide_m());
        let wanted = dark.edge(|cell| self.given_up.contains(cell));
        let reached: Vec<_> = self.floor(&dark, here, &self.bumps).search(here.position).collect();
        // The wanted cells can be reached, and were not.
        self.missed.extend(&wanted);
        let left_out = self.left_out(here, &dark, &wanted, &reached);
        self.state = State::Ended(Command::Done(left_out));
    }

    fn grid(&self) -> &Occupancy {
        &self.grid
    }
}

impl Frontiers {
    /// A robot that knows nothing yet.
    #[must_use]
    pub fn new(parameters: Parameters) -> Self {
        Self {
            parameters,
            grid: Occupancy::new(parameters.cell_m),
            last_scan: None,
            bumps: Vec::new(),
            forgotten: 0,
            given_up: BTreeSet::new(),
            missed: BTreeSet::new(),
            resolved: BTreeMap::new(),
            ended: 0,
            state: State::Plan,
        }
    }

    /// The number of its plans that have come to an end.
    pub(super) const fn ended(&self) -> usize {
        self.ended
    }

    /// The end of the straight path on which it is.
    pub(super) const fn leg(&self) -> Option<Point> {
        match &self.state {
            State::Go { approach, .. } => Some(approach.to),
            State::Plan | State::Look { .. } | State::Ended(_) => None,
        }
    }

    /// Puts a new scan into the grid, and gives up a plan that is no good after it. Returns whether there was one.
    pub(super) fn remember(&mut self, input: &Input<'_>) -> bool {
        let Some(scan) = input.scan.filter(|scan| self.last_scan.as_ref() != Some(scan)) else {
            return false;
        };
        self.last_scan = Some(scan.clone());
        if !self.grid.add(scan) {
            self.state = State::Ended(Command::Failed(Failure::TooLarge));
        }
        let Parameters { radius_m, cell_m, .. } = self.parameters;
        self.grid.free_disc(scan.world_from_robot().position, radius_m - cell_m);
        match &self.state {
            State::Go { plan: Plan { look_at, .. }, .. } | State::Look { at: look_at }
                if !is_edge(&self.grid, *look_at) =>
            {
                self.resolve(*look_at);
                self.state = State::Plan;
            }
            State::Go { plan, approach } if !self.is_open(&input.world_from_robot, plan, approach) => {
                self.state = State::Plan;
            }
            State::Go { .. } | State::Look { .. } | State::Plan | State::Ended(_) => {}
        }
        true
    }

    /// The next command in this state; `None` if it has become another.
    fn advance(&mut self, input: &Input<'_>) -> Option<Command> {
        let here = &input.world_from_robot;
        match std::mem::replace(&mut self.state, State::Plan) {
            State::Plan if self.last_scan.is_none() => return Some(Command::Wait),
            State::Plan => self.state = self.plan(here),
            State::Go { plan, approach } => return self.go(input, plan, approach),
            State::Look { at } => {
                let is_here =
                    input.scan.is_some_and(|scan| scan.is_from(here, HERE * self.parameters.radius_m));
                let turn = turn(here, heading_to(here, self.grid.center(at)));
                if let Some(command) = turn.or(if is_here { None } else { Some(Command::Wait) }) {
                    self.state = State::Look { at };
                    return Some(command);
                }
                self.give_up(at);
                self.ended += 1;
            }
            State::Ended(command) => {
                self.state = State::Ended(command);
                return Some(command);
            }
        }
        None
    }

    fn plan(&mut self, here: &Pose) -> State {
        if self.bumps.len() > MOST_BUMPS {
            return State::Ended(Command::Failed(Failure::Stuck));
        }
        let dark = Dark::new(&self.grid, self.parameters.wide_m());
        let floor = self.floor(&dark, here, &self.bumps);
        let wanted = dark.edge(|cell| self.given_up.contains(cell));
        let mut search = floor.search(here.position);
        let mut reached = Vec::new();
        for (view_m, wanted) in self.views(&wanted) {
            let outlook = Outlook::new(&self.grid, &dark, wanted, view_m);
            let seen = |cell: Cell| Some((cell, outlook.from(cell)?));
            let known = reached.iter().copied().find_map(seen);
            let mut on = search.by_ref().inspect(|cell| reached.push(*cell));
            let Some((place, look_at)) = known.or_else(|| on.find_map(seen)) else { continue };
            let mut turns = floor.straighten(here.position, &search.path(place));
            turns.reverse();
            let approach = Approach::new(turns.pop().unwrap_or(here.position));
            return State::Go { plan: Plan { turns, look_at }, approach };
        }
        if !self.bumps.is_empty() && self.forgotten < self.parameters.attempts {
            self.forgotten += 1;
            self.bumps.clear();
            return State::Plan;
        }
        State::Ended(Command::Done(self.left_out(here, &dark, &wanted, &reached)))
    }

    /// The places that a robot leaves out which can reach these cells.
    fn left_out(&self, here: &Pose, dark: &Dark<'_>, wanted: &[Cell], reached: &[Cell]) -> LeftOut {
        let half_width_m = self.parameters.half_width_m();
        let reached_but: Vec<_> = self.floor(dark, here, &[]).search(here.position).collect();
        let (grid, given_up, missed) = (&self.grid, &self.given_up, &self.missed);
        Rest { grid, dark, reached, reached_but: &reached_but, wanted, given_up, missed, half_width_m }
            .left_out()
    }

    /// The floor on which the robot fits.
    fn floor<'a>(&self, dark: &Dark<'a>, here: &Pose, bumps: &[Point]) -> Floor<'a> {
        let ease_m = EASE * self.parameters.radius_m;
        Floor::new(dark, (self.parameters.half_width_m(), ease_m), here.position, bumps)
    }

    /// The ranges of view to plan for, and the cells to see within each, in turn. Cells side by side are mostly seen
    /// from the same places.
    fn views(&self, wanted: &[Cell]) -> [(f64, Vec<Cell>); 3] {
        let Parameters { view_m, cell_m, radius_m, .. } = self.parameters;
        let range_m = self.last_scan.as_ref().map_or(view_m, |scan| scan.scan().range_m);
        // The laser may miss an object just at the end of its range.
        let view_m = view_m.min(range_m - 2.0 * cell_m).max(cell_m);
        // No line is longer than what is known.
        let [columns, rows] = self.grid.size();
        let range_m = range_m.min((columns + rows) as f64 * cell_m);
        let few = sparse(wanted, (SPARSE * radius_m / cell_m) as i32 + 1);
        [(view_m, few.clone()), (view_m, wanted.to_vec()), (view_m.max(range_m), few)]
    }

    fn go(&mut self, input: &Input<'_>, mut plan: Plan, mut approach: Approach) -> Option<Command> {
        let here = &input.world_from_robot;
        // The centre of the cell that it is in is reached.
        let Parameters { radius_m, cell_m, .. } = self.parameters;
        let reach_m = (REACH * radius_m).max(HALF_DIAGONAL * cell_m);
        let Some(command) = approach.step(here, reach_m) else {
            self.state = match plan.turns.pop() {
                Some(to) => State::Go { plan, approach: Approach::new(to) },
                None => State::Look { at: plan.look_at },
            };
            return None;
        };
        if input.near && matches!(command, Command::Drive { .. }) {
            // So near that no path leads any farther ahead.
            let ahead_m = self.parameters.half_width_m() - 0.5 * cell_m;
            self.bumps.push(here.position + here.direction().vector() * ahead_m);
            return None;
        }
        self.state = State::Go { plan, approach };
        Some(command)
    }

    /// Whether there is still an open way to the place, or one that is narrower by no more than the laser's noise.
    fn is_open(&self, here: &Pose, plan: &Plan, approach: &Approach) -> bool {
        let mut from = here.position;
        let mut is_open = |to: Point| self.is_straight(std::mem::replace(&mut from, to), to);
        is_open(approach.to) && plan.turns.iter().rev().all(|turn| is_open(*turn))
    }

    /// The cell is of the edge no more. One that was so too often is given up: it will be back. That the way there was closed does
    /// not count: one that is only just wide enough is so by every other scan.
    fn resolve(&mut self, cell: Cell) {
        self.ended += 1;
        let times = self.resolved.entry(cell).or_default();
        *times += 1;
        if *times == MOST_TIMES {
            self.give_up(cell);
        }
    }

    /// A cell that was viewed from near in vain, with its neighbours.
    fn give_up(&mut self, cell: Cell) {
        self.given_up.extend(self.around(cell, BESIDE * self.parameters.radius_m));
    }

    /// The cells within so many metres of one.
    fn around(&self, cell: Cell, radius_m: f64) -> Vec<Cell> {
        let rows = Disc::new(radius_m / self.parameters.cell_m).rows.into_iter();
        rows.flat_map(|(row, half)| (-half..=half).map(move |column| cell.offset(column, row))).collect()
    }

    /// Whether the robot can go straight from here to there, by what it knows.
    pub(super) fn is_straight(&self, here: Point, to: Point) -> bool {
        let half_width_m = self.parameters.half_width_m() - NOISE * self.parameters.radius_m;
        is_clear(&self.grid, (here, to), half_width_m, &self.bumps)
    }
}

/// A point on the way is reached within this distance, in radii of the body, as are all lengths here.
const REACH: f64 = 0.15;
/// A scan was taken where the robot is if it has moved less since then.
pub(super) const HERE: f64 = 0.25;
/// Beyond half a path so much room is as good as any.
const EASE: f64 = 0.5;

/// Half the diagonal of a cell, in cells, and a little more.
const HALF_DIAGONAL: f64 = 0.71;

/// A path that was open is not closed by a loss of room below this.
const NOISE: f64 = 0.05;

/// The radius, in metres, within which other cells are given up with a cell.
const BESIDE: f64 = 0.25;

/// One cell of the edge in a square of this side stands for the others.
const SPARSE: f64 = 0.5;

/// A cell that was no longer part of the edge so many times is noise.
const MOST_TIMES: usize = 5;

/// A robot that was stopped so often is in a place where it cannot move.
const MOST_BUMPS: usize = 300;

#[cfg(test)]
mod tests;
