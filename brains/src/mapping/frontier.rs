//! Frontiers: B. Yamauchi, *A frontier-based approach for autonomous exploration*, CIRA 1997.
//!
//! A frontier is where what is known to be free ends at what is unknown. Here it is the first unknown cells, those with a free one
//! at one of their four sides: to see them is what a robot can do to know more.
//!
//! *Deviation.* Unknown cells count only where they are wide: in a square of some centimetres of which nothing is known. They are
//! dark. What is narrower lies between two rays of a laser, or beside a wall that it met at an acute angle; it is taken to be
//! free to go and to look through, if nothing else is in the way.

use baudbot_geometry::grid::Cell;
use baudbot_geometry::{Vector, math};

use super::occupancy::{Occupancy, Occupied};

/// The dark areas of a grid.
#[derive(Clone, Debug)]
pub struct Dark<'a> {
    grid: &'a Occupancy,
    /// The side of a square that counts, in cells.
    side: usize,
    /// In the order of the grid's cells. What is beyond the grid is dark, too.
    is_dark: Vec<bool>,
}

impl<'a> Dark<'a> {
    /// The dark areas of a grid: those that are at least so wide, in metres, and unknown.
    #[must_use]
    pub fn new(grid: &'a Occupancy, wide_m: f64) -> Self {
        let [columns, rows] = grid.size();
        let side = math::round(wide_m / grid.cell_m()).max(1.0) as usize;
        // All squares that have a cell of the grid begin in this larger grid, so many cells to the left and below.
        let [wide, high] = [columns + side, rows + side].map(|length| length + side);
        let is_known = |column: usize, row: usize| {
            let inside = (side..columns + side).contains(&column) && (side..rows + side).contains(&row);
            inside && grid.values()[(row - side) * columns + column - side] != 0.0
        };
        let known = Sums::new(wide, high, is_known);
        let is_free_of_all = |column: usize, row: usize| {
            column + side <= wide && row + side <= high && known.within(column, row, side) == 0
        };
        let squares = Sums::new(wide, high, is_free_of_all);
        let is_dark = |place: usize| {
            let (column, row) = (place % columns + 1, place / columns + 1);
            squares.within(column, row, side) > 0
        };
        Self { grid, side, is_dark: (0..columns * rows).map(is_dark).collect() }
    }

    pub(crate) fn grid(&self) -> &'a Occupancy {
        self.grid
    }

    /// The number of cells of the grid.
    pub(crate) fn len(&self) -> usize {
        self.is_dark.len()
    }

    /// Whether a cell of the grid is neither dark nor occupied.
    pub(crate) fn is_clear_at(&self, place: usize) -> bool {
        !self.is_dark[place] && self.grid.values()[place] <= 0.0
    }

    /// Whether a cell is dark.
    #[must_use]
    pub fn is_dark(&self, cell: Cell) -> bool {
        self.grid.place(cell).is_none_or(|place| self.is_dark[place])
    }

    /// The dark cells beside free ones, which are what is to be seen next, without those that are `but`. Only where more
    /// are in a row than make such a square: in a wall single cells become free by a laser's noise.
    #[must_use]
    pub fn edge(&self, but: impl Fn(&Cell) -> bool) -> Vec<Cell> {
        let free = self.grid.cells().filter(|&cell| self.grid.state(cell) == Occupied::Free);
        let edge: Vec<_> =
            free.flat_map(Cell::sides).filter(|cell| self.is_dark(*cell) && !but(cell)).collect();
        let least = self.side + 1;
        groups(&edge).into_iter().filter(|group| group.len() >= least).flatten().collect()
    }

    /// Calls `mark` with the place of each cell from which nothing dark and nothing occupied hides this one, and which is no farther
    /// away than so many metres; with some of them more than once.
    pub fn light(&self, cell: Cell, radius_m: f64, mut mark: impl FnMut(usize)) {
        let from = self.grid.center(cell);
        let rays = math::ceil(core::f64::consts::TAU * radius_m / self.grid.cell_m()) as u32;
        for ray in 0..rays {
            let (sin, cos) = math::sin_cos(core::f64::consts::TAU * f64::from(ray) / f64::from(rays));
            let to = from + Vector::new(cos, sin) * radius_m;
            for next in self.grid.line(from, to).skip(1) {
                let Some(place) = self.grid.place(next).filter(|&place| self.is_clear_at(place)) else {
                    break;
                };
                mark(place);
            }
        }
    }
}

/// Whether a cell is still to be seen: nothing is known of it, and it is beside a free one.
#[must_use]
pub fn is_edge(grid: &Occupancy, cell: Cell) -> bool {
    grid.state(cell) == Occupied::Unknown && cell.sides().any(|beside| grid.state(beside) == Occupied::Free)
}

/// The groups of cells that touch, at a corner too.
#[must_use]
pub fn groups(cells: &[Cell]) -> Vec<Vec<Cell>> {
    let mut waiting: std::collections::BTreeSet<_> = cells.iter().copied().collect();
    let mut groups = Vec::new();
    while let Some(first) = waiting.pop_first() {
        let mut group = vec![first];
        let mut next = 0;
        while let Some(&cell) = group.get(next) {
            next += 1;
            let around = (-1..=1).flat_map(|row| (-1..=1).map(move |column| cell.offset(column, row)));
            group.extend(around.filter(|cell| waiting.remove(cell)));
        }
        groups.push(group);
    }
    groups
}

/// Sums that give the number of cells of a kind in any rectangle.
struct Sums {
    wide: usize,
    high: usize,
    /// The number below and to the left of each cell, and one more a row and a column.
    below: Vec<u32>,
}

impl Sums {
    fn new(wide: usize, high: usize, is: impl Fn(usize, usize) -> bool) -> Self {
        let mut below = vec![0; (wide + 1) * (high + 1)];
        for row in 0..high {
            let mut sum = 0;
            for column in 0..wide {
                sum += u32::from(is(column, row));
                below[(row + 1) * (wide + 1) + column + 1] = below[row * (wide + 1) + column + 1] + sum;
            }
        }
        Self { wide, high, below }
    }

    /// In the square of this side that begins here.
    fn within(&self, column: usize, row: usize, side: usize) -> u32 {
        let [right, top] = [(column + side).min(self.wide), (row + side).min(self.high)];
        let at = |column: usize, row: usize| self.below[row * (self.wide + 1) + column];
        at(right, top) + at(column, row) - at(column, top) - at(right, row)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use baudbot_geometry::{Point, Pose};

    use super::*;
    use crate::mapping::PlacedScan;
    use crate::scan::Scan;

    /// The map after half a turn in a corridor of 2 m whose walls are to the left and to the right.
    fn corridor(cell_m: f64) -> Occupancy {
        let mut grid = Occupancy::new(cell_m);
        let rays = 1000;
        let mut scan = Scan {
            robot_from_laser: Pose::new(0.0, 0.0, 0.0),
            opening_rad: PI,
            range_m: 3.0,
            distances_m: vec![f64::INFINITY; rays],
        };
        for i in 0..rays {
            scan.distances_m[i] = 1.0 / scan.bearing_rad(i).sin().abs();
        }
        let scan = PlacedScan::new(Pose::new(0.03, 0.03, 0.0), scan);
        assert!(grid.add(&scan));
        grid
    }

    #[test]
    fn a_corridor_has_an_edge_ahead_and_one_behind() {
        for cell_m in [0.1, 0.05, 0.025] {
            let grid = corridor(cell_m);
            let groups = groups(&Dark::new(&grid, 0.05).edge(|_| false));
            let mut columns: Vec<_> =
                groups.iter().map(|group| cell_m * f64::from(group[0].column)).collect();
            columns.sort_by(f64::total_cmp);
            assert_eq!(columns.len(), 2, "{cell_m}: {columns:?}");
            assert!((-0.2..=0.0).contains(&columns[0]) && columns[1] >= 2.7, "{cell_m}: {columns:?}");
            let wide = |group: &Vec<Cell>| group.len() as f64 * cell_m >= 1.8;
            assert!(groups.iter().all(wide), "they are as wide as the corridor");
            assert!(groups.iter().flatten().all(|cell| is_edge(&grid, *cell)));
        }
    }

    #[test]
    fn what_is_left_out_is_no_edge_nor_what_is_too_few_to_be_wide() {
        let grid = corridor(0.025);
        let dark = Dark::new(&grid, 0.05);
        assert!(dark.edge(|cell| cell.column < 5).iter().all(|cell| cell.column >= 5));
        let edge = dark.edge(|_| false);
        let ahead: Vec<_> = edge.iter().copied().filter(|cell| cell.column > 5).collect();
        let few = dark.edge(|cell| !ahead[..2].contains(cell));
        assert!(few.is_empty(), "{few:?}");
        let nothing = Occupancy::new(0.1);
        assert!(Dark::new(&nothing, 0.05).edge(|_| false).is_empty());
    }

    #[test]
    fn what_is_narrow_and_unknown_is_not_dark() {
        let mut grid = Occupancy::new(0.025);
        grid.free_disc(Point::new(0.0, 0.0), 1.0);
        let dark = Dark::new(&grid, 0.05);
        assert!(!dark.is_dark(grid.cell(Point::new(0.0, 0.0))));
        assert!(dark.is_dark(grid.cell(Point::new(1.2, 0.0))) && dark.is_dark(Cell { column: 999, row: 0 }));
        // Two discs that almost touch leave a gap of one cell.
        let mut grid = Occupancy::new(0.025);
        for x in [-0.505, 0.52] {
            grid.free_disc(Point::new(x, 0.0), 0.5);
        }
        let gap = Cell { column: 0, row: 0 };
        assert_eq!(grid.state(gap), Occupied::Unknown);
        assert!(!Dark::new(&grid, 0.05).is_dark(gap));
    }

    #[test]
    fn a_cell_is_seen_from_where_nothing_is_between() {
        let grid = corridor(0.05);
        let dark = Dark::new(&grid, 0.05);
        let ahead = dark.edge(|cell| cell.column < 5);
        let mut seen = vec![false; dark.len()];
        dark.light(ahead[ahead.len() / 2], 1.5, |place| seen[place] = true);
        let sees = |x: f64, y: f64| grid.place(grid.cell(Point::new(x, y))).is_some_and(|place| seen[place]);
        assert!(sees(2.0, 0.0) && !sees(1.0, 0.0), "1.5 m far");
        assert!(!sees(2.0, 1.2), "a wall");
    }
}
