//! Exploration by frontiers: B. Yamauchi, *A frontier-based approach for autonomous exploration*, CIRA 1997.
//!
//! The robot keeps an occupancy grid of all scans. It goes to the nearest place, by the length of the way, from which a
//! frontier is in sight within `view_m`, and faces it. As soon as the frontier that it is on its way to is none any
//! more it chooses another. It is done when there is none that it can get to.
//!
//! Where proximity stops it, which the laser did not see coming, it remembers something in the way and plans again.
//!
//! *Deviations.*
//!
//! - Yamauchi's robot drives to the middle of a group of frontier cells, and sweeps its sensors all around there.
//! - A frontier that is still one after it was looked at from near is given up, as is a group of fewer than
//!   `least_cells` cells: what is behind it is narrower than the laser's rays are apart. So is one that was none any more on
//!   the way there, and came back, too often: beside an edge that lies on the border of two cells, frontiers come and go by
//!   the laser's noise.
//! - What proximity found is forgotten when nothing else is left to be done, so that a thing in one's way costs no
//!   room for ever; but not more often than `attempts` times.

use std::cell::Cell as Shared;
use std::collections::{BTreeMap, BTreeSet};

use baudbot_geometry::{Point, Pose};

use super::approach::{Approach, heading_to, turn};
use super::{Command, Explorer, Failure, Input};
use crate::mapping::disc::Disc;
use crate::mapping::frontier::{frontiers, groups, is_frontier};
use crate::mapping::{Cell, Floor, Occupancy, Occupied, PlacedScan};

/// The lengths of the method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Side of a cell, in metres.
    pub cell_m: f64,
    /// Half the width that a way must have, in metres: the robot's radius and a little more.
    pub half_width_m: f64,
    /// A point on the way is reached within this distance, in metres.
    pub reach_m: f64,
    /// A frontier can be looked at from so far away, in metres.
    pub view_m: f64,
    /// Groups of fewer frontier cells do not count.
    pub least_cells: usize,
    /// How often all that proximity found is forgotten.
    pub attempts: usize,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { cell_m: 0.1, half_width_m: 0.25, reach_m: 0.1, view_m: 1.0, least_cells: 2, attempts: 1 }
    }
}

/// A robot that explores by frontiers.
#[derive(Clone, Debug, PartialEq)]
pub struct Frontiers {
    parameters: Parameters,
    grid: Occupancy,
    last_scan: Option<PlacedScan>,
    /// What proximity found, in the world.
    bumps: Vec<Point>,
    /// How often the bumps were forgotten.
    forgotten: usize,
    given_up: BTreeSet<Cell>,
    /// How often each frontier to which a plan led was none any more.
    resolved: BTreeMap<Cell, usize>,
    state: State,
}

#[derive(Clone, Debug, PartialEq)]
enum State {
    Plan,
    Go {
        plan: Plan,
        approach: Approach,
    },
    /// Faces the frontier.
    Look {
        frontier: Cell,
    },
    Ended(Command),
}

/// A way to a place from which a frontier cell can be seen.
#[derive(Clone, Debug, PartialEq)]
struct Plan {
    /// Points that are left, the last one first.
    turns: Vec<Point>,
    frontier: Cell,
}

impl Explorer for Frontiers {
    fn step(&mut self, input: &Input<'_>) -> Command {
        self.remember(input);
        loop {
            // Each turn of the loop follows a plan or gives up a frontier.
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
            resolved: BTreeMap::new(),
            state: State::Plan,
        }
    }

    /// What it knows.
    #[must_use]
    pub fn grid(&self) -> &Occupancy {
        &self.grid
    }

    /// Puts a new scan into the grid, and gives up a plan that is no good after it.
    fn remember(&mut self, input: &Input<'_>) {
        let Some(scan) = input.scan.filter(|scan| self.last_scan.as_ref() != Some(scan)) else {
            return;
        };
        self.last_scan = Some(scan.clone());
        if !self.grid.add(scan) {
            self.state = State::Ended(Command::Failed(Failure::TooLarge));
        }
        self.grid.free_disc(scan.world_from_robot.position, self.parameters.half_width_m);
        match &self.state {
            State::Go { plan: Plan { frontier, .. }, .. } | State::Look { frontier }
                if !is_frontier(&self.grid, *frontier) =>
            {
                self.resolve(*frontier);
                self.state = State::Plan;
            }
            State::Go { plan, approach } if !self.is_open(&input.world_from_robot, plan, approach) => {
                self.state = State::Plan;
            }
            _ => {}
        }
    }

    /// What to do in this state; `None` if it has become another.
    fn advance(&mut self, input: &Input<'_>) -> Option<Command> {
        let here = &input.world_from_robot;
        match std::mem::replace(&mut self.state, State::Plan) {
            State::Plan if self.last_scan.is_none() => return Some(Command::Wait),
            State::Plan => self.state = self.plan(here),
            State::Go { plan, approach } => return self.go(input, plan, approach),
            State::Look { frontier } => {
                let is_here = input.scan.is_some_and(|scan| scan.is_from(here));
                let turn = turn(here, heading_to(here, self.grid.center(frontier)));
                if let Some(command) = turn.or(if is_here { None } else { Some(Command::Wait) }) {
                    self.state = State::Look { frontier };
                    return Some(command);
                }
                self.give_up(frontier);
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
        let floor = self.floor(here);
        let frontiers = self.frontiers();
        let view = Disc::new(self.parameters.view_m / self.grid.cell_m());
        let is_in_view = self.cells_in_view(frontiers.clone(), &view);
        let seen = Shared::new(None);
        let is_goal = |cell: Cell| {
            let is_near = self.grid.place(cell).is_some_and(|place| is_in_view[place]);
            seen.set(if is_near { self.seen_from(cell, &frontiers, &view) } else { None });
            seen.get().is_some()
        };
        let way = floor.way(here.position, is_goal);
        let found = way.map(|way| floor.straighten(here.position, &way)).zip(seen.get());
        match found {
            Some((mut turns, frontier)) => {
                turns.reverse();
                let to = turns.pop().unwrap_or(here.position);
                State::Go { plan: Plan { turns, frontier }, approach: Approach::new(to) }
            }
            None if !self.bumps.is_empty() && self.forgotten < self.parameters.attempts => {
                self.forgotten += 1;
                self.bumps.clear();
                State::Plan
            }
            None => State::Ended(Command::Done),
        }
    }

    fn go(&mut self, input: &Input<'_>, mut plan: Plan, mut approach: Approach) -> Option<Command> {
        let here = &input.world_from_robot;
        let Some(command) = approach.step(here, self.parameters.reach_m) else {
            self.state = match plan.turns.pop() {
                Some(to) => State::Go { plan, approach: Approach::new(to) },
                None => State::Look { frontier: plan.frontier },
            };
            return None;
        };
        if input.near && matches!(command, Command::Drive { .. }) {
            let ahead_m = self.parameters.half_width_m + BUMP_M;
            self.bumps.push(here.position + here.direction().vector() * ahead_m);
            return None;
        }
        self.state = State::Go { plan, approach };
        Some(command)
    }

    /// Whether there is still an open way to the frontier.
    fn is_open(&self, here: &Pose, plan: &Plan, approach: &Approach) -> bool {
        let floor = self.floor(here);
        let mut from = here.position;
        let mut is_open = |to: Point| floor.is_line_open(std::mem::replace(&mut from, to), to);
        is_open(approach.to) && plan.turns.iter().rev().all(|turn| is_open(*turn))
    }

    fn floor(&self, here: &Pose) -> Floor<'_> {
        Floor::new(&self.grid, self.parameters.half_width_m, here.position, &self.bumps)
    }

    /// For each cell of the grid whether it is on a frontier that was not given up.
    fn frontiers(&self) -> Vec<bool> {
        let mut frontiers = frontiers(&self.grid);
        for place in self.given_up.iter().filter_map(|cell| self.grid.place(*cell)) {
            frontiers[place] = false;
        }
        frontiers
    }

    /// For each cell of the grid whether it is near enough to a frontier that counts.
    fn cells_in_view(&self, frontiers: Vec<bool>, view: &Disc) -> Vec<bool> {
        let mut is_in_view = vec![false; frontiers.len()];
        let groups = groups(&self.grid, frontiers).into_iter();
        for cell in groups.filter(|group| group.len() >= self.parameters.least_cells).flatten() {
            for places in self.grid.places(cell, view) {
                is_in_view[places].fill(true);
            }
        }
        is_in_view
    }

    /// The nearest frontier cell that can be seen from a cell. What is too small to count does so here: who is near it
    /// anyway may look.
    fn seen_from(&self, cell: Cell, frontiers: &[bool], view: &Disc) -> Option<Cell> {
        let is_clear = |other: &Cell| {
            let mut line = self.grid.line(self.grid.center(cell), self.grid.center(*other));
            line.all(|cell| self.grid.state(cell) == Occupied::Free)
        };
        let near = self.grid.places(cell, view).flatten().filter(|place| frontiers[*place]);
        let seen = near.map(|place| self.grid.cell_of(place)).filter(is_clear);
        seen.min_by_key(|other| cell.distance_squared(*other))
    }

    /// The frontier is none any more. One that was so too often is given up: it will be back. That the way there was closed does
    /// not count: one that is only just wide enough is so by every other scan.
    fn resolve(&mut self, frontier: Cell) {
        let times = self.resolved.entry(frontier).or_default();
        *times += 1;
        if *times == MOST_TIMES {
            self.give_up(frontier);
        }
    }

    /// A frontier that was looked at from near in vain, with what is beside it.
    fn give_up(&mut self, frontier: Cell) {
        let beside = |row| (-1..=1).map(move |column| frontier.offset(column, row));
        self.given_up.extend((-1..=1).flat_map(beside));
    }
}

/// How far beyond half the width of a way something is taken to be that proximity found, in metres.
const BUMP_M: f64 = 0.05;

/// A frontier that was none any more so often is noise.
const MOST_TIMES: usize = 5;

/// A robot that was stopped so often is in a place where it cannot move.
const MOST_BUMPS: usize = 300;

#[cfg(test)]
mod tests;
