//! A path, by any of the methods, and the cells that the search examined.

use std::collections::BTreeSet;

use baudbot_brains::planning::{self, Cell, CellGrid, Grid, Moves, Penalised, Plan, PlanError};
use baudbot_geometry::{Bounds, Point};

use crate::args::{Method, PlanArgs};

/// The result of a method.
#[derive(Debug)]
pub(super) struct PlannedPath {
    /// The bends, and both ends; of a walker that got stuck, the last is its place.
    pub(super) points: Vec<Point>,
    pub(super) length_m: f64,
    /// Cells whose neighbours were examined.
    pub(super) expanded: usize,
    /// Cells that were examined.
    pub(super) touched: BTreeSet<Cell>,
    /// The convex cells, of the method that has these.
    pub(super) cells: Vec<Bounds>,
    /// The path does not reach the target.
    pub(super) is_stuck: bool,
}

impl PlannedPath {
    /// Finds one between two points.
    pub(super) fn find(grid: &Grid, args: &PlanArgs, from: Point, to: Point) -> Result<Self, PlanError> {
        if args.method == Method::Cells {
            return Self::through(&CellGrid::new(grid.clone()), from, to);
        }
        let off = |end, point| move || PlanError::OffMap { end, point };
        let start = grid.cell_at(from).ok_or_else(off(planning::End::Start, from))?;
        let target = grid.cell_at(to).ok_or_else(off(planning::End::Target, to))?;
        let moves: Moves = args.steps.into();
        let heuristic = Penalised { heuristic: args.heuristic.into(), penalty: args.penalty };
        let plan = match args.method {
            Method::Walker => planning::walk(grid, start, target, moves, heuristic),
            Method::Greedy => planning::greedy(grid, start, target, moves, heuristic),
            Method::Dijkstra => planning::dijkstra(grid, start, target, moves),
            Method::AStar => planning::a_star(grid, start, target, moves, heuristic),
            Method::ThetaStar | Method::Cells => planning::theta_star(grid, start, target),
        };
        match plan {
            Ok(plan) => Ok(Self::of(grid, &plan)),
            Err(PlanError::DeadEnd { walked, touched, .. }) => Ok(Self::stuck(grid, &walked, &touched)),
            Err(error) => Err(error),
        }
    }

    fn of(grid: &Grid, plan: &Plan) -> Self {
        Self {
            points: bends(&plan.points(grid)),
            length_m: plan.length_m,
            expanded: plan.expanded.len(),
            touched: plan.touched.iter().copied().collect(),
            cells: Vec::new(),
            is_stuck: false,
        }
    }

    fn stuck(grid: &Grid, walked: &[Cell], touched: &[Cell]) -> Self {
        let points: Vec<_> = walked.iter().map(|&cell| grid.center(cell)).collect();
        Self {
            length_m: points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum(),
            points: bends(&points),
            expanded: walked.len(),
            touched: touched.iter().copied().collect(),
            cells: Vec::new(),
            is_stuck: true,
        }
    }

    fn through(cells: &CellGrid, from: Point, to: Point) -> Result<Self, PlanError> {
        let route = cells.route(from, to)?;
        Ok(Self {
            points: route.points,
            length_m: route.length_m,
            expanded: route.cells.len(),
            touched: BTreeSet::new(),
            cells: cells.cells().to_vec(),
            is_stuck: false,
        })
    }
}

/// The points without those at which a line goes straight on.
fn bends(points: &[Point]) -> Vec<Point> {
    let goes_on = |a: Point, b: Point, c: Point| {
        let (there, on) = (b - a, c - b);
        (there.x * on.y - there.y * on.x).abs() < STRAIGHT && there.dot(&on) > 0.0
    };
    let inner =
        points.windows(3).filter(|three| !goes_on(three[0], three[1], three[2])).map(|three| three[1]);
    let ends = points.len().min(2);
    let first = points.iter().take(ends.min(1)).copied();
    let last = points.iter().skip(1).next_back().copied();
    first.chain(inner).chain(last).collect()
}

/// Twice the area of a triangle that is none, in square metres.
const STRAIGHT: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_a_line_goes_straight_on_it_has_no_bend() {
        let points = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 1.0), (4.0, 2.0), (3.0, 1.0)];
        let points = points.map(|(x, y)| Point::new(x, y));
        let found = bends(&points);
        assert_eq!(found, [points[0], points[2], points[4], points[5]]);
        assert_eq!(bends(&points[..1]), points[..1]);
        assert!(bends(&[]).is_empty());
    }
}
