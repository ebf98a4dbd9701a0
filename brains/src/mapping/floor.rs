//! The places where a robot fits, and the ways there.
//!
//! The room at a cell is how far its centre is from the nearest thing that is known: not from the centre of an occupied
//! cell but from where rays have [ended](Occupancy::surface) in it. A cell is open if it has as much room as half the width of a
//! way, and is not known to be occupied nor in the dark. Ways lead from open cell to open cell over sides and corners. Their
//! lengths are found by Dijkstra's algorithm, in whole numbers: 10 for a step over a side and 14 over a corner. Where there is less
//! room than half a path and as much as is at ease a step counts up to five times, so that paths keep to the middle of what is narrow.
//!
//! A path leads through every gap that is as wide as a path and a cell: so far apart may its middle and the nearest
//! centres of cells be, taken twice.
//!
//! A robot that has come too near to something must get away. Cells around it that are not open are tight, if they have no
//! less room than where it is: ways lead through them, but a step into one counts ten times, and no path ends in one.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use baudbot_geometry::grid::Cell;
use baudbot_geometry::{Point, Segment, Vector, math};

use super::disc::Disc;
use super::frontier::Dark;
use super::occupancy::{Occupancy, Occupied};

/// The open cells of a grid.
#[derive(Clone, Debug)]
pub struct Floor<'a> {
    grid: &'a Occupancy,
    /// In the order of the grid's cells.
    kinds: Vec<Kind>,
    /// In metres, in the same order; what is more than a wide way needs is not looked for.
    room_m: Vec<f32>,
    radius_m: f64,
    ease_m: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Closed,
    Tight,
    Open,
}

impl<'a> Floor<'a> {
    /// The places for a disc with this radius, in metres, that is now at `here`, and to which `ease_m` more room is as
    /// good as any. The points of `obstacles` count as occupied, whatever their cells.
    #[must_use]
    pub(crate) fn new(
        dark: &Dark<'a>,
        (radius_m, ease_m): (f64, f64),
        here: Point,
        obstacles: &[Point],
    ) -> Self {
        let grid = dark.grid();
        let far_m = radius_m + ease_m;
        let mut room_m = vec![far_m as f32; dark.len()];
        let surfaces =
            grid.cells().filter(|&cell| is_surface(grid, cell)).filter_map(|cell| grid.surface(cell));
        for point in surfaces.chain(obstacles.iter().copied()) {
            lessen(grid, &mut room_m, point, far_m);
        }
        let kind = |(place, &room_m): (usize, &f32)| {
            let is_open = f64::from(room_m) >= radius_m && dark.is_clear_at(place);
            if is_open { Kind::Open } else { Kind::Closed }
        };
        let kinds = room_m.iter().enumerate().map(kind).collect();
        let mut floor = Self { grid, kinds, room_m, radius_m, ease_m };
        floor.free_around(dark, here);
        floor
    }

    /// Frees the cells beside a robot that has come too near to something.
    fn free_around(&mut self, dark: &Dark<'_>, here: Point) {
        let own = self.grid.cell(here);
        let Some(room_m) = self.grid.place(own).map(|place| self.room_m[place]) else { return };
        let least_m = room_m - 0.5 * self.grid.cell_m() as f32;
        for place in self.grid.places(own, &Disc::new(self.radius_m / self.grid.cell_m())).flatten() {
            if self.kinds[place] == Kind::Closed && self.room_m[place] >= least_m && dark.is_clear_at(place) {
                self.kinds[place] = Kind::Tight;
            }
        }
    }

    /// Whether all cells of the straight line between two points are open, or tight, and none of them has less room.
    fn is_line_as_roomy(&self, from: Point, to: Point, room_m: f32) -> bool {
        let is_open = |cell| {
            let place = self.grid.place(cell);
            place.is_some_and(|place| self.kinds[place] != Kind::Closed && self.room_m[place] >= room_m)
        };
        self.grid.line(from, to).all(is_open)
    }

    /// The cells to which there is a path from a point, in the order of its length, which is found as far as it is asked for. The
    /// point's own cell need not be open.
    #[must_use]
    pub fn search(&self, from: Point) -> Search<'_> {
        let start = self.grid.cell(from);
        let mut reached = vec![(u32::MAX, start); self.kinds.len()];
        let mut waiting = BinaryHeap::new();
        if let Some(place) = self.grid.place(start) {
            reached[place].0 = 0;
            waiting.push(Reverse((0, start)));
        }
        Search { floor: self, start, reached, waiting }
    }

    /// Points at which to turn, so that a path becomes straight lines over open cells; the last one is its end. No line has less
    /// room than the part of the way that it stands for, but for a cell.
    #[must_use]
    pub fn straighten(&self, from: Point, path: &[Cell]) -> Vec<Point> {
        let mut turns: Vec<Point> = Vec::new();
        let room_m = |cell: Cell| self.grid.place(cell).map_or(0.0, |place| self.room_m[place]);
        let (mut begin, mut end) = (from, from);
        let mut least_m = f32::INFINITY;
        for &cell in path {
            let center = self.grid.center(cell);
            least_m = least_m.min(room_m(cell));
            // In a slanted passage the room changes by a part of a cell from one to the next.
            let enough_m = least_m - self.grid.cell_m() as f32;
            if !self.is_line_as_roomy(begin, center, enough_m) && end != begin {
                turns.push(end);
                least_m = room_m(self.grid.cell(end)).min(room_m(cell));
                begin = end;
            }
            end = center;
        }
        turns.push(end);
        turns
    }

    /// The cost of a step into a cell; `None` if there is none.
    fn step(&self, place: usize, step: u32) -> Option<u32> {
        match self.kinds[place] {
            Kind::Open => {
                let spare = (f64::from(self.room_m[place]) - self.radius_m) / self.ease_m;
                Some(step + (4.0 * f64::from(step) * (1.0 - spare.clamp(0.0, 1.0))) as u32)
            }
            Kind::Tight => Some(10 * step),
            Kind::Closed => None,
        }
    }
}

/// Whether a cell is occupied and beside one that is not.
fn is_surface(grid: &Occupancy, cell: Cell) -> bool {
    let is_occupied = |cell| grid.state(cell) == Occupied::Occupied;
    is_occupied(cell) && cell.sides().any(|beside| !is_occupied(beside))
}

/// Something is at this point: cells around it that are not as far away have less room.
fn lessen(grid: &Occupancy, room_m: &mut [f32], point: Point, far_m: f64) {
    let far = Vector::new(far_m, far_m);
    let (low, high) = (grid.cell(point - far), grid.cell(point + far));
    for row in low.row..=high.row {
        for column in low.column..=high.column {
            let cell = Cell { column, row };
            let Some(place) = grid.place(cell) else { continue };
            let way_m = grid.center(cell) - point;
            let squared = way_m.dot(&way_m) as f32;
            if squared < room_m[place] * room_m[place] {
                room_m[place] = math::sqrt(f64::from(squared)) as f32;
            }
        }
    }
}

/// A search for the nearest cells, by the length of the path.
#[derive(Clone, Debug)]
pub struct Search<'a> {
    floor: &'a Floor<'a>,
    start: Cell,
    /// The length of the path to each cell, as far as it is known, and the cell before.
    reached: Vec<(u32, Cell)>,
    waiting: BinaryHeap<Reverse<(u32, Cell)>>,
}

impl Iterator for Search<'_> {
    type Item = Cell;

    fn next(&mut self) -> Option<Cell> {
        let Floor { grid, kinds, .. } = self.floor;
        while let Some(Reverse((length, cell))) = self.waiting.pop() {
            let place = grid.place(cell)?;
            if length > self.reached[place].0 {
                continue;
            }
            for (columns, rows, step) in STEPS {
                let next = cell.offset(columns, rows);
                let Some(place) = grid.place(next) else { continue };
                let Some(step) = self.floor.step(place, step) else { continue };
                if length + step < self.reached[place].0 {
                    self.reached[place] = (length + step, cell);
                    self.waiting.push(Reverse((length + step, next)));
                }
            }
            if cell == self.start || kinds[place] == Kind::Open {
                return Some(cell);
            }
        }
        None
    }
}

impl Search<'_> {
    /// The path to a cell that was found, with both ends.
    #[must_use]
    pub fn path(&self, to: Cell) -> Vec<Cell> {
        let mut path = vec![to];
        let mut cell = to;
        while cell != self.start {
            let Some(place) = self.floor.grid.place(cell) else { break };
            cell = self.reached[place].1;
            path.push(cell);
        }
        path.reverse();
        path
    }
}

const STEPS: [(i32, i32, u32); 8] =
    [(1, 0, 10), (0, 1, 10), (-1, 0, 10), (0, -1, 10), (1, 1, 14), (-1, 1, 14), (-1, -1, 14), (1, -1, 14)];

/// Whether a disc with this radius, in metres, can go straight from one point to another past all that is known: from where it
/// is too near to something it may go away from that.
#[must_use]
pub(crate) fn is_clear(
    grid: &Occupancy,
    (from, to): (Point, Point),
    radius_m: f64,
    obstacles: &[Point],
) -> bool {
    let path = Segment { start: from, end: to };
    let is_past = |point: Point| {
        let least_m = radius_m.min((point - from).norm() - AWAY_M);
        path.distance(point) >= least_m
    };
    let around = Vector::new(radius_m, radius_m);
    let low = Point::new(from.x.min(to.x), from.y.min(to.y)) - around;
    let high = Point::new(from.x.max(to.x), from.y.max(to.y)) + around;
    let (low, high) = (grid.cell(low), grid.cell(high));
    let cells = (low.row..=high.row)
        .flat_map(|row| (low.column..=high.column).map(move |column| Cell { column, row }));
    obstacles.iter().all(|point| is_past(*point)) && cells.filter_map(|cell| grid.surface(cell)).all(is_past)
}

/// A robot that moves away from something may come nearer to it by no more than this, in metres.
const AWAY_M: f64 = 0.005;

#[cfg(test)]
mod tests {
    use super::*;

    /// A free square of 4 m around the origin.
    fn square() -> Occupancy {
        let mut grid = Occupancy::new(0.025);
        grid.free_disc(Point::new(0.0, 0.0), 4.0);
        grid
    }

    /// A wall along y, of points, with these gaps in it.
    fn wall(from_m: f64, to_m: f64, gap_m: Option<(f64, f64)>) -> Vec<Point> {
        let points = (0..=((to_m - from_m) / 0.01) as i32).map(|i| from_m + 0.01 * f64::from(i));
        let is_wall = |y: &f64| gap_m.is_none_or(|(low, high)| *y <= low || *y >= high);
        points.filter(is_wall).map(|y| Point::new(0.013, y)).collect()
    }

    fn path(floor: &Floor<'_>, from: Point, to: Cell) -> Option<Vec<Cell>> {
        let mut search = floor.search(from);
        let found = search.find(|cell| *cell == to)?;
        Some(search.path(found))
    }

    fn length_m(from: Point, turns: &[Point]) -> f64 {
        turns.iter().scan(from, |at, to| Some((std::mem::replace(at, *to) - to).norm())).sum()
    }

    #[test]
    fn ways_lead_around_obstacles_and_are_straight_where_they_can_be() {
        let grid = square();
        let dark = Dark::new(&grid, 0.05);
        let (here, there) = (Point::new(-1.99, 0.01), Point::new(1.99, 0.01));
        let goal = grid.cell(there);
        let free = Floor::new(&dark, (0.25, 0.1), here, &[]);
        let straight = path(&free, here, goal).unwrap();
        assert_eq!((straight[0], straight.last()), (grid.cell(here), Some(&goal)));
        assert_eq!(free.straighten(here, &straight), [grid.center(goal)]);
        // A wall across, with a door above.
        let wall = wall(-4.5, 1.0, None);
        let floor = Floor::new(&dark, (0.25, 0.1), here, &wall);
        let round = path(&floor, here, goal).unwrap();
        let clear = |cell: &Cell| wall.iter().all(|point| (grid.center(*cell) - point).norm() >= 0.25 - 1e-6);
        assert!(round.iter().all(clear));
        let turns = floor.straighten(here, &round);
        assert!(turns.len() <= 12, "{turns:?}");
        let length_m = length_m(here, &turns);
        assert!((4.6..5.2).contains(&length_m), "{length_m}: over (0, 1.3) it is 4.7");
    }

    #[test]
    fn a_way_leads_through_every_gap_as_wide_as_a_way_and_a_cell_and_through_none_that_is_narrower_than_a_way()
     {
        let grid = square();
        let dark = Dark::new(&grid, 0.05);
        let here = Point::new(-2.0, 0.0);
        let goal = grid.cell(Point::new(2.0, 0.0));
        for shift in 0..10 {
            let low = 0.003 * f64::from(shift);
            let passes = |gap_m: f64| {
                let mut wall = wall(-4.5, 4.5, Some((low, low + gap_m)));
                wall.extend([Point::new(0.013, low), Point::new(0.013, low + gap_m)]);
                path(&Floor::new(&dark, (0.225, 0.1), here, &wall), here, goal).is_some()
            };
            assert!(passes(0.476) && !passes(0.449), "{low}");
        }
    }

    #[test]
    fn a_way_keeps_to_the_middle_of_what_is_narrow() {
        let grid = square();
        let dark = Dark::new(&grid, 0.05);
        let here = Point::new(-2.0, 0.0);
        let floor_wall = wall(-4.5, 4.5, Some((-0.35, 0.35)));
        let floor = Floor::new(&dark, (0.225, 0.1), here, &floor_wall);
        let turns = floor.straighten(here, &path(&floor, here, grid.cell(Point::new(2.0, 1.0))).unwrap());
        let ends = std::iter::once(here).chain(turns.iter().copied()).collect::<Vec<_>>();
        let nearest_m = ends.windows(2).flat_map(|pair| {
            let line = Segment { start: pair[0], end: pair[1] };
            floor_wall.iter().map(move |point| line.distance(*point)).collect::<Vec<_>>()
        });
        assert!(nearest_m.fold(f64::INFINITY, f64::min) > 0.28, "{turns:?}");
    }

    #[test]
    fn a_robot_beside_a_wall_gets_away_and_not_nearer() {
        let grid = square();
        let dark = Dark::new(&grid, 0.05);
        let wall = wall(-2.0, 2.0, None);
        let here = Point::new(-0.19, 0.0);
        let floor = Floor::new(&dark, (0.25, 0.1), here, &wall);
        let out = path(&floor, here, grid.cell(Point::new(-1.0, 0.0))).unwrap();
        assert!(out.iter().all(|cell| grid.center(*cell).x < -0.16), "{out:?}");
        assert!(!floor.is_line_as_roomy(here, Point::new(-0.1, 0.0), 0.0));
        assert!(is_clear(&grid, (here, Point::new(-1.0, 0.0)), 0.25, &wall));
        assert!(!is_clear(&grid, (here, Point::new(-0.15, 0.0)), 0.25, &wall));
    }
}
