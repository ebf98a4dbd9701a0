//! The floor between known walls, and ways across it.

use std::task::{Poll, ready};

use baudbot_geometry::{Point, Segment, Vector};
use serde::Deserialize;

use crate::parameter::{ParameterError, check_positive};
use crate::planning::{Cell, CellGrid, End, Grid, PlanError, ThetaStar, line_of_sight};

/// The places between walls that the centre of a body may take, and ways for it.
#[derive(Clone, Debug)]
pub struct Floor {
    walls: Vec<Segment>,
    grid: Grid,
    /// The convex cells for ways through them.
    cells: Option<CellGrid>,
}

/// The method that finds a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// On the grid, by A\* with ways that turn by any angle: [`theta_star`](crate::planning::theta_star).
    #[default]
    ThetaStar,
    /// Through few large cells, and pulled tight: [`CellGrid`].
    ConvexCells,
}

impl Floor {
    /// The floor between walls `[x, y, x, y]`, in metres, in square cells with sides of `cell_m`. The centre of a body stays
    /// `clearance_m` away from each wall: its radius, and some room.
    ///
    /// # Errors
    /// If there is no such grid, in words that begin with the name of the field.
    pub fn new(
        walls_m: &[[f64; 4]],
        cell_m: f64,
        clearance_m: f64,
        method: Method,
    ) -> Result<Self, ParameterError> {
        if let Some(i) = walls_m.iter().position(|wall| !wall.iter().all(|m| m.is_finite())) {
            return Err(ParameterError::value(format_args!("walls_m[{i}]"), "must be four finite numbers"));
        }
        check_positive([("cell_m", cell_m)])?;
        let wall = |&[x, y, u, v]: &[f64; 4]| Segment { start: Point::new(x, y), end: Point::new(u, v) };
        let walls: Vec<_> = walls_m.iter().map(wall).collect();
        let grid = Grid::from_segments(&walls, cell_m, clearance_m)
            .map_err(|error| ParameterError::value("walls_m", error))?;
        let cells = (method == Method::ConvexCells).then(|| CellGrid::new(grid.clone()));
        Ok(Self { walls, grid, cells })
    }

    /// The floor in cells; free are those of which each point keeps the clearance.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Whether a body may be there.
    pub fn is_free(&self, point: Point) -> bool {
        self.grid.cell_at(point).is_some_and(|cell| self.grid.is_free(cell))
    }

    /// The distance between a point and the nearest wall, in metres.
    pub fn wall_m(&self, point: Point) -> f64 {
        self.walls.iter().map(|wall| wall.distance(point)).fold(f64::INFINITY, f64::min)
    }

    /// Whether a body may go straight from one point to the other. To half the diagonal of a cell: it looks along the line
    /// from the centre of the one cell to that of the other.
    pub fn is_clear(&self, from: Point, to: Point) -> bool {
        let cells = self.grid.cell_at(from).zip(self.grid.cell_at(to));
        cells.is_some_and(|(from, to)| line_of_sight(&self.grid, from, to))
    }

    /// A short way, with both its ends. One that begins nearer to a wall than a body may be first leads away from it.
    ///
    /// # Errors
    /// If no path leads there.
    pub fn path(&self, from: Point, to: Point) -> Result<Vec<Point>, PlanError> {
        let mut search = ThetaStar::default();
        loop {
            if let Poll::Ready(path) = self.seek(&mut search, from, to, &mut { usize::MAX }) {
                return path;
            }
        }
    }

    /// The same in parts: a search on the grid looks at no more cells than are `left`, and goes on when it is called again. A
    /// straight path, and one through the few convex cells, is found at once.
    ///
    /// # Errors
    /// If no path leads there.
    pub fn seek(
        &self,
        search: &mut ThetaStar,
        from: Point,
        to: Point,
        left: &mut usize,
    ) -> Poll<Result<Vec<Point>, PlanError>> {
        let start = self.nearest_free(from);
        let rest = match &self.cells {
            _ if self.is_clear(start, to) => vec![start, to],
            Some(cells) => cells.route(start, to)?.points,
            None => ready!(self.any_angle(search, start, to, left))?,
        };
        let mut path = vec![from];
        path.extend(rest);
        path.dedup();
        Poll::Ready(Ok(path))
    }

    fn any_angle(
        &self,
        search: &mut ThetaStar,
        from: Point,
        to: Point,
        left: &mut usize,
    ) -> Poll<Result<Vec<Point>, PlanError>> {
        let cell = |end, point| self.grid.cell_at(point).ok_or(PlanError::OffMap { end, point });
        let ends = [cell(End::Start, from)?, cell(End::Target, to)?];
        let turns = ready!(search.seek(&self.grid, ends, left))?;
        // The ends of the path are centres of cells. Those stay in it: a straight line that leaves them out may cut a corner.
        let turns = turns.into_iter().map(|cell| self.grid.center(cell));
        Poll::Ready(Ok([from].into_iter().chain(turns).chain([to]).collect()))
    }

    /// The point itself, if a body may be there; otherwise the nearest centre of a free cell from which no wall parts it.
    /// Itself, too, if there is none nearby.
    pub fn nearest_free(&self, point: Point) -> Point {
        if self.is_free(point) {
            return point;
        }
        let place = |cell: Cell| self.grid.center(cell);
        let reach = Vector::new(ESCAPE_M, ESCAPE_M);
        let around = self.grid.within(point - reach, point + reach);
        let centers = around.filter(|&cell| self.grid.is_free(cell)).map(place);
        let near = centers.map(|center| ((center - point).norm(), center)).filter(|(m, _)| *m < ESCAPE_M);
        let near = near.filter(|&(_, end)| {
            let line = Segment { start: point, end };
            !self.walls.iter().any(|wall| wall.touches(&line))
        });
        near.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(point, |(_, center)| center)
    }
}

/// Cells that are examined in one step of a behaviour, so that planning takes a fraction of a millisecond.
pub const CELLS_A_STEP: usize = 500;

/// A robot that is farther from free floor than this, in metres, is not on this map.
const ESCAPE_M: f64 = 1.0;

#[cfg(test)]
mod tests {
    use super::*;

    /// A room of 4 m × 3 m with a wall from below in its middle.
    const ROOM: [[f64; 4]; 5] = [
        [0.0, 0.0, 4.0, 0.0],
        [4.0, 0.0, 4.0, 3.0],
        [4.0, 3.0, 0.0, 3.0],
        [0.0, 3.0, 0.0, 0.0],
        [2.0, 0.0, 2.0, 2.0],
    ];

    /// The least distance of a path from the walls, in metres.
    fn clearance_m(floor: &Floor, path: &[Point]) -> f64 {
        let points = path.windows(2).flat_map(|ends| {
            let (from, step) = (ends[0], (ends[1] - ends[0]) / 100.0);
            (0..=100).map(move |i| from + step * f64::from(i))
        });
        let distances = points
            .flat_map(|point| floor.walls.iter().map(move |wall| wall.distance(point)).collect::<Vec<_>>());
        distances.fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn both_methods_lead_round_the_wall_and_keep_clear_of_it() {
        let (from, to) = (Point::new(0.5, 0.5), Point::new(3.5, 0.5));
        for method in [Method::ThetaStar, Method::ConvexCells] {
            let floor = Floor::new(&ROOM, 0.05, 0.3, method).unwrap();
            let path = floor.path(from, to).unwrap();
            let length: f64 = path.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
            // The tangents to a disc of 0.3 m around the wall's end, and the arc between them, are 4.76 m long.
            assert!((4.7..5.0).contains(&length), "{method:?}: {length} {path:?}");
            assert!(clearance_m(&floor, &path) >= 0.3 - 0.036, "{method:?}: {path:?}");
            assert_eq!((path[0], path[path.len() - 1]), (from, to));
        }
    }

    #[test]
    fn who_stands_too_near_to_a_wall_first_leaves_it_on_the_same_side() {
        let floor = Floor::new(&ROOM, 0.05, 0.3, Method::ThetaStar).unwrap();
        let path = floor.path(Point::new(1.95, 1.0), Point::new(3.5, 0.5)).unwrap();
        assert!(path[1].x < 1.8 && floor.is_free(path[1]), "{path:?}");
        assert!(floor.path(Point::new(9.0, 9.0), Point::new(3.5, 0.5)).is_err());
    }

    #[test]
    fn what_makes_no_sense_is_said() {
        let problem = |walls: &[[f64; 4]], cell_m| {
            Floor::new(walls, cell_m, 0.3, Method::default()).unwrap_err().to_string()
        };
        assert_eq!(problem(&[], 0.05), "walls_m: the map has no walls; give it one, or the grid its bounds");
        assert_eq!(problem(&ROOM, 0.0), "cell_m: must be positive, is 0");
        assert_eq!(problem(&[[0.0, 0.0, 1.0, f64::NAN]], 0.1), "walls_m[0]: must be four finite numbers");
    }
}
