//! Where a robot fits, and the ways there.
//!
//! A cell is open if it is known to be free and nothing that is occupied is nearer to its centre than half the
//! robot's width and half a cell. Ways lead from open cell to open cell over sides and corners, and their lengths are
//! found by Dijkstra's algorithm, in whole numbers: 10 for a step over a side and 14 over a corner.
//!
//! A robot that has come too near to something must get away. Free cells around it that are not open are tight: ways
//! lead through them, but a step into one counts ten times, and no way ends in one.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use baudbot_geometry::Point;

use super::disc::Disc;
use super::occupancy::{Cell, Occupancy};

/// Which cells of a grid are open.
#[derive(Clone, Debug)]
pub struct Floor<'a> {
    grid: &'a Occupancy,
    /// In the order of the grid's cells.
    room: Vec<Room>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Room {
    Closed,
    Tight,
    Open,
}

impl<'a> Floor<'a> {
    /// Where a disc with this radius, in metres, fits that is now at `here`. What is at the points of `obstacles` counts
    /// as occupied, whatever the grid says.
    #[must_use]
    pub fn new(grid: &'a Occupancy, radius_m: f64, here: Point, obstacles: &[Point]) -> Self {
        let room = |log_odds: &f32| if *log_odds < 0.0 { Room::Open } else { Room::Closed };
        let mut floor = Self { grid, room: grid.values().iter().map(room).collect() };
        let body = Disc::new(radius_m / grid.cell_m() + 0.5);
        let obstacles: Vec<_> = obstacles.iter().map(|point| grid.cell(*point)).collect();
        let occupied = grid.cells().zip(grid.values()).filter(|(_, log_odds)| **log_odds > 0.0);
        for cell in occupied.map(|(cell, _)| cell).chain(obstacles.iter().copied()) {
            floor.close(cell, &body);
        }
        for place in grid.places(grid.cell(here), &body).flatten() {
            if floor.room[place] == Room::Closed && grid.values()[place] < 0.0 {
                floor.room[place] = Room::Tight;
            }
        }
        let beside = Disc::new(1.0);
        for cell in obstacles {
            floor.close(cell, &beside);
        }
        floor
    }

    fn close(&mut self, center: Cell, disc: &Disc) {
        for places in self.grid.places(center, disc) {
            self.room[places].fill(Room::Closed);
        }
    }

    /// Whether all cells of the straight line between two points are open, or tight.
    #[must_use]
    pub fn is_line_open(&self, from: Point, to: Point) -> bool {
        let is_open = |cell| self.grid.place(cell).is_some_and(|place| self.room[place] != Room::Closed);
        self.grid.line(from, to).all(is_open)
    }

    /// The shortest way from a point's cell to the nearest cell, by the length of the way, for which `is_goal` holds,
    /// with both ends; `None` if there is no way to any. The point's own cell need not be open.
    #[must_use]
    pub fn way(&self, from: Point, is_goal: impl Fn(Cell) -> bool) -> Option<Vec<Cell>> {
        let start = self.grid.cell(from);
        let mut reached = vec![(u32::MAX, start); self.room.len()];
        reached[self.grid.place(start)?].0 = 0;
        let mut waiting = BinaryHeap::from([Reverse((0, start))]);
        while let Some(Reverse((length, cell))) = waiting.pop() {
            let place = self.grid.place(cell)?;
            if length > reached[place].0 {
                continue;
            }
            if (cell == start || self.room[place] == Room::Open) && is_goal(cell) {
                return Some(self.back(cell, start, &reached));
            }
            for (columns, rows, step) in STEPS {
                let next = cell.offset(columns, rows);
                let Some(place) = self.grid.place(next) else { continue };
                let step = match self.room[place] {
                    Room::Open => step,
                    Room::Tight => 10 * step,
                    Room::Closed => continue,
                };
                if length + step < reached[place].0 {
                    reached[place] = (length + step, cell);
                    waiting.push(Reverse((length + step, next)));
                }
            }
        }
        None
    }

    fn back(&self, goal: Cell, start: Cell, reached: &[(u32, Cell)]) -> Vec<Cell> {
        let mut way = vec![goal];
        let mut cell = goal;
        while cell != start {
            let Some(place) = self.grid.place(cell) else { break };
            cell = reached[place].1;
            way.push(cell);
        }
        way.reverse();
        way
    }

    /// Points at which to turn, so that a way becomes straight lines over open cells; the last one is its end.
    #[must_use]
    pub fn straighten(&self, from: Point, way: &[Cell]) -> Vec<Point> {
        let mut turns: Vec<Point> = Vec::new();
        let mut begin = from;
        let mut end = from;
        for &cell in way {
            let center = self.grid.center(cell);
            if !self.is_line_open(begin, center) && end != begin {
                turns.push(end);
                begin = end;
            }
            end = center;
        }
        turns.push(end);
        turns
    }
}

const STEPS: [(i32, i32, u32); 8] =
    [(1, 0, 10), (0, 1, 10), (-1, 0, 10), (0, -1, 10), (1, 1, 14), (-1, 1, 14), (-1, -1, 14), (1, -1, 14)];

#[cfg(test)]
mod tests {
    use super::*;

    /// A free square of 4 m around the origin.
    fn square() -> Occupancy {
        let mut grid = Occupancy::new(0.1);
        grid.free_disc(Point::new(0.0, 0.0), 4.0);
        grid
    }

    #[test]
    fn ways_lead_around_obstacles_and_are_straight_where_they_can_be() {
        let grid = square();
        let (here, there) = (Point::new(-1.95, 0.05), Point::new(1.95, 0.05));
        let goal = grid.cell(there);
        let free = Floor::new(&grid, 0.25, here, &[]);
        let way = free.way(here, |cell| cell == goal).unwrap();
        assert_eq!((way.len(), way[0], way[39]), (40, grid.cell(here), goal));
        assert_eq!(free.straighten(here, &way), [grid.center(goal)]);
        // A wall across, with a door above.
        let wall: Vec<_> = (-45..=10).map(|i| Point::new(0.05, 0.1 * f64::from(i) + 0.05)).collect();
        let floor = Floor::new(&grid, 0.25, here, &wall);
        let way = floor.way(here, |cell| cell == goal).unwrap();
        let clear = |cell: &Cell| wall.iter().all(|point| (grid.center(*cell) - point).norm() > 0.3);
        assert!(way.iter().all(clear));
        let turns = floor.straighten(here, &way);
        assert!(turns.len() >= 2 && turns.len() <= 5, "{turns:?}");
        let length: f64 =
            turns.iter().scan(here, |at, to| Some((std::mem::replace(at, *to) - to).norm())).sum();
        assert!((4.7..5.0).contains(&length), "{length}: over (0, 1.4) it is 4.7");
    }

    #[test]
    fn there_is_no_way_where_the_robot_does_not_fit() {
        let grid = square();
        let wall: Vec<_> = (-45..=45).filter(|i| !(0..=4).contains(i)).collect();
        let wall: Vec<_> = wall.iter().map(|i| Point::new(0.05, 0.1 * f64::from(*i) + 0.05)).collect();
        let goal = grid.cell(Point::new(2.0, 0.0));
        let here = Point::new(-2.0, 0.0);
        let way = |radius_m| Floor::new(&grid, radius_m, here, &wall).way(here, |cell| cell == goal);
        assert!(way(0.25).is_none(), "the gap of 0.5 m is too narrow for a cell in it");
        assert!(way(0.15).is_some());
    }

    #[test]
    fn a_robot_beside_a_wall_gets_away() {
        let grid = square();
        let wall: Vec<_> = (-20..20).map(|i| Point::new(0.05, 0.1 * f64::from(i) + 0.05)).collect();
        let here = Point::new(-0.2, 0.0);
        let goal = grid.cell(Point::new(-1.0, 0.0));
        assert!(Floor::new(&grid, 0.25, here, &wall).way(here, |cell| cell == goal).is_some());
    }
}
