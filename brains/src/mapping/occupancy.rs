//! An occupancy grid from scans with known poses: H. Moravec and A. Elfes 1985, with the log-odds that S. Thrun et al.,
//! *Probabilistic Robotics* (2005), §9.2, use.
//!
//! For each cell the grid keeps l = ln(p / (1 - p)) of the probability p that something is there. A scan adds
//! `l_hit` to a cell in which a ray met something, and takes `l_miss` from one that rays only went through.
//!
//! *Deviations.* A scan changes each cell once, and a hit counts more than any number of rays that passed: otherwise
//! the many rays along a wall wipe out what few of them met. Rays have no width.

use std::ops::Range;

use baudbot_geometry::Point;
use baudbot_geometry::grid::{self, Cell, Grid, Rectangle};

use super::disc::Disc;
use super::placed::PlacedScan;

/// The knowledge about a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occupied {
    /// The cell is free.
    Free,
    /// The cell is occupied.
    Occupied,
    /// The cell was not seen, or it was seen both ways.
    Unknown,
}

/// A grid over that part of the plane that was seen. It grows as needed.
#[derive(Clone, Debug, PartialEq)]
pub struct Occupancy {
    /// The origin of the world is a corner of cells.
    grid: Grid,
    log_odds: Vec<f32>,
    /// The ends of rays in each cell.
    ends: Vec<Ends>,
    /// The number of the last scan that changed each cell.
    changed: Vec<u32>,
    scans: u32,
}

/// The ends of rays in a cell, in its last scans.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Ends {
    count: f32,
    /// The mean of the rays' ends, from the cell's centre, in cells.
    aside: [f32; 2],
}

impl Ends {
    fn add(&mut self, aside: [f64; 2]) {
        self.count = (self.count + 1.0).min(MOST_ENDS);
        for (mean, new) in self.aside.iter_mut().zip(aside) {
            *mean += (new as f32 - *mean) / self.count;
        }
    }
}

/// The changes that a scan makes.
struct Change<'a> {
    log_odds: &'a mut [f32],
    changed: &'a mut [u32],
    /// The scan's number.
    scan: u32,
}

impl Change<'_> {
    /// Changes the cell at a place, unless this scan already did.
    #[inline]
    fn change(&mut self, place: usize, by: f32) {
        if self.changed[place] != self.scan {
            self.changed[place] = self.scan;
            self.log_odds[place] = (self.log_odds[place] + by).clamp(-MOST, MOST);
        }
    }
}

impl Occupancy {
    /// A grid of cells with this side, in metres, of which nothing is known.
    ///
    /// # Panics
    /// If the side is not positive.
    #[must_use]
    pub fn new(cell_m: f64) -> Self {
        assert!(cell_m > 0.0, "a cell has a side");
        let grid = Grid { origin: Point::origin(), cell_m, cells: Rectangle::default() };
        Self { grid, log_odds: vec![], ends: vec![], changed: vec![], scans: 0 }
    }

    /// Side of a cell, in metres.
    #[must_use]
    pub fn cell_m(&self) -> f64 {
        self.grid.cell_m
    }

    /// The cell around a point.
    #[must_use]
    pub fn cell(&self, point: Point) -> Cell {
        self.grid.cell_at(point)
    }

    /// The centre of a cell, in metres in the world.
    #[must_use]
    pub fn center(&self, cell: Cell) -> Point {
        self.grid.center(cell)
    }

    /// l of a cell; 0 if nothing is known of it.
    #[must_use]
    pub fn log_odds(&self, cell: Cell) -> f32 {
        self.place(cell).map_or(0.0, |place| self.log_odds[place])
    }

    /// The knowledge about a cell.
    #[must_use]
    pub fn state(&self, cell: Cell) -> Occupied {
        let log_odds = self.log_odds(cell);
        if log_odds > 0.0 {
            Occupied::Occupied
        } else if log_odds < 0.0 {
            Occupied::Free
        } else {
            Occupied::Unknown
        }
    }

    /// The cells that the grid has, known or not, row by row.
    pub fn cells(&self) -> impl Iterator<Item = Cell> {
        self.grid.cells.cells()
    }

    /// The numbers of columns and rows.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.grid.cells.columns as usize, self.grid.cells.rows as usize]
    }

    /// The place of a cell in the order of [`cells`](Self::cells); `None` if the grid has not grown so far.
    #[inline]
    pub(crate) fn place(&self, cell: Cell) -> Option<usize> {
        self.grid.cells.number(cell)
    }

    /// The cell at a place in the order of [`cells`](Self::cells).
    pub(crate) fn cell_of(&self, place: usize) -> Cell {
        self.grid.cells.cell(place)
    }

    /// The places of a disc's cells around this one, row by row, as far as the grid has them.
    pub(crate) fn places(&self, center: Cell, disc: &Disc) -> impl Iterator<Item = Range<usize>> {
        disc.rows.iter().filter_map(move |&(row, half)| {
            let row = center.row.checked_add(row)?;
            let from = center.column.saturating_sub(half).max(self.grid.cells.first.column);
            let until = center.column.saturating_add(half).min(self.grid.cells.last().column);
            let range = self.place(Cell { column: from, row })?..=self.place(Cell { column: until, row })?;
            (from <= until).then(|| *range.start()..range.end() + 1)
        })
    }

    /// Whether the cell at a place is free.
    pub(crate) fn is_free_at(&self, place: usize) -> bool {
        self.log_odds[place] < 0.0
    }

    /// The known area, in square metres.
    pub(crate) fn known_m2(&self) -> f64 {
        let known = self.log_odds.iter().filter(|log_odds| **log_odds != 0.0).count();
        known as f64 * self.grid.cell_m * self.grid.cell_m
    }

    /// The log-odds of all cells, in the order of [`cells`](Self::cells).
    pub(super) fn values(&self) -> &[f32] {
        &self.log_odds
    }

    /// All cells that the straight line between two points goes through, in order.
    pub fn line(&self, from: Point, to: Point) -> impl Iterator<Item = Cell> + use<> {
        grid::line(self.grid.grid_from_world(from), self.grid.grid_from_world(to))
    }

    /// Adds a scan. Returns whether it did: a scan that would make the grid larger than 4 million cells is left out.
    pub fn add(&mut self, scan: &PlacedScan) -> bool {
        let from = scan.world_from_laser().position;
        let ends: Vec<_> = scan.ends().collect();
        if !self.grow(ends.iter().map(|(end, _)| *end).chain([from])) {
            return false;
        }
        self.scans += 1;
        for &(end, _) in ends.iter().filter(|(_, met)| *met) {
            self.met(end);
            if let Some(place) = self.place(self.cell(end)) {
                self.scan().change(place, HIT);
            }
        }
        let (grid, mut scan) = (self.grid, self.scan());
        let from = grid.grid_from_world(from);
        for (end, _) in ends {
            grid.cells.visit_line(from, grid.grid_from_world(end), |place| scan.change(place, MISS));
        }
        true
    }

    /// A disc about a point is free, such as a robot's place.
    pub fn free_disc(&mut self, center: Point, radius_m: f64) {
        let corner = baudbot_geometry::Vector::new(radius_m, radius_m);
        if !self.grow([center - corner, center + corner].into_iter()) {
            return;
        }
        self.scans += 1;
        let (low, high) = (self.cell(center - corner), self.cell(center + corner));
        for row in low.row..=high.row {
            for column in low.column..=high.column {
                let cell = Cell { column, row };
                if let Some(place) = self.place(cell)
                    && (self.center(cell) - center).norm() <= radius_m
                {
                    self.scan().change(place, MISS);
                }
            }
        }
    }

    /// A ray has met something at this point. What was met in a cell that has been free since then is forgotten.
    fn met(&mut self, end: Point) {
        let cell = self.cell(end);
        let Some(place) = self.place(cell) else { return };
        if self.log_odds[place] <= 0.0 {
            self.ends[place].count = 0.0;
        }
        let aside = (end - self.center(cell)) / self.grid.cell_m;
        self.ends[place].add([aside.x, aside.y]);
    }

    /// The mean end of the rays in an occupied cell, in metres in the world: nearer to the surface there than the
    /// cell's centre.
    #[must_use]
    pub fn surface(&self, cell: Cell) -> Option<Point> {
        let place = self.place(cell).filter(|place| self.log_odds[*place] > 0.0)?;
        let [x, y] = self.ends[place].aside.map(f64::from);
        Some(self.center(cell) + baudbot_geometry::Vector::new(x, y) * self.grid.cell_m)
    }

    /// The present scan.
    fn scan(&mut self) -> Change<'_> {
        Change { log_odds: &mut self.log_odds, changed: &mut self.changed, scan: self.scans }
    }

    /// Makes the grid so large that it has these points' cells; returns whether that is not too large.
    fn grow(&mut self, points: impl Iterator<Item = Point>) -> bool {
        let is_new = self.log_odds.is_empty();
        let old = (!is_new).then(|| (self.grid.cells.first, self.grid.cells.last()));
        let cells = points.map(|point| (self.cell(point), self.cell(point)));
        let union = |a: (Cell, Cell), b: (Cell, Cell)| {
            let low = Cell { column: a.0.column.min(b.0.column), row: a.0.row.min(b.0.row) };
            (low, Cell { column: a.1.column.max(b.1.column), row: a.1.row.max(b.1.row) })
        };
        let Some(all) = cells.chain(old).reduce(union) else { return true };
        if Some(all) == old {
            return true;
        }
        // Room to spare where it grows, and not on the other sides.
        let spare = |grows: bool| if grows { SPARE } else { 0 };
        let grows = |side: fn(&(Cell, Cell)) -> i32| old.is_none_or(|old| side(&old) != side(&all));
        let low = all.0.offset(-spare(grows(|all| all.0.column)), -spare(grows(|all| all.0.row)));
        let high = all.1.offset(spare(grows(|all| all.1.column)), spare(grows(|all| all.1.row)));
        let (columns, rows) = (
            i64::from(high.column) - i64::from(low.column) + 1,
            i64::from(high.row) - i64::from(low.row) + 1,
        );
        if columns.saturating_mul(rows) > MOST_CELLS {
            return false;
        }
        let before = std::mem::replace(self, Self { scans: self.scans, ..Self::new(self.grid.cell_m) });
        self.grid.cells = Rectangle::between(low, high);
        self.log_odds = vec![0.0; (columns * rows) as usize];
        self.ends = vec![Ends::default(); self.log_odds.len()];
        self.changed = vec![0; self.log_odds.len()];
        for (place, cell) in before.cells().enumerate() {
            if let Some(new) = self.place(cell) {
                self.log_odds[new] = before.log_odds[place];
                self.ends[new] = before.ends[place];
            }
        }
        true
    }
}

/// The addition of a ray that met something, `l_hit`: p = 0.7.
const HIT: f32 = 0.847;
/// The addition of rays that only went through, −`l_miss`: p = 0.4.
const MISS: f32 = -0.405;
/// Cells are never surer than this, p = 0.97, so that what has moved is believed in a few scans.
const MOST: f32 = 3.5;
/// The most ends with a part in the mean of a cell's.
const MOST_ENDS: f32 = 50.0;
/// The number of cells more than needed on each side, so that not every scan makes the grid grow.
const SPARE: i32 = 16;
/// A square kilometre in cells of half a metre, 200 m by 200 m in cells of 10 cm, or 50 m by 50 m in cells of 2.5 cm.
const MOST_CELLS: i64 = 4_000_000;

#[cfg(test)]
mod tests {
    use baudbot_geometry::Pose;

    use super::*;
    use crate::scan::Scan;

    fn scan(x: f64, distances_m: &[f64]) -> PlacedScan {
        PlacedScan::new(
            Pose::new(x, 0.05, 0.0),
            Scan {
                robot_from_laser: Pose::new(0.0, 0.0, 0.0),
                opening_rad: 0.0,
                range_m: 2.0,
                distances_m: distances_m.to_vec(),
            },
        )
    }

    fn states(grid: &Occupancy, columns: Range<i32>) -> String {
        let letter = |column| match grid.state(Cell { column, row: 0 }) {
            Occupied::Free => '.',
            Occupied::Occupied => '#',
            Occupied::Unknown => '?',
        };
        columns.map(letter).collect()
    }

    #[test]
    fn a_ray_frees_what_it_goes_through_and_occupies_where_it_ends() {
        let mut grid = Occupancy::new(0.1);
        assert!(grid.add(&scan(0.05, &[0.5])));
        assert_eq!(states(&grid, -2..8), "??.....#??");
        let mut grid = Occupancy::new(0.1);
        assert!(grid.add(&scan(0.05, &[f64::INFINITY])));
        assert_eq!(states(&grid, 18..23), "...??", "2 m from 0.05 end in cell 20");
    }

    #[test]
    fn a_hit_counts_more_than_rays_that_pass_in_the_same_scan() {
        let mut grid = Occupancy::new(0.1);
        assert!(grid.add(&scan(0.05, &[0.5, 1.0, 1.0, 1.0, 1.0])));
        assert_eq!(states(&grid, 4..12), ".#....#?");
    }

    #[test]
    fn what_has_gone_away_is_forgotten_after_some_scans() {
        let mut grid = Occupancy::new(0.1);
        for _ in 0..100 {
            grid.add(&scan(0.05, &[0.5]));
        }
        let scans = (1..100).find(|_| {
            grid.add(&scan(0.05, &[1.0]));
            states(&grid, 5..6) == "."
        });
        assert_eq!(scans, Some(9), "3.5 / 0.405");
    }

    #[test]
    fn growing_keeps_what_is_known_in_every_direction() {
        let mut grid = Occupancy::new(0.1);
        for x in [0.05, 10.05, -20.05] {
            assert!(grid.add(&scan(x, &[0.5])));
        }
        assert_eq!(states(&grid, 0..7), ".....#?");
        assert_eq!(states(&grid, 100..107), ".....#?");
        assert_eq!(grid.cells().count(), grid.grid.cells.count());
        assert_eq!(grid.cells().filter(|cell| grid.state(*cell) == Occupied::Occupied).count(), 3);
    }

    #[test]
    fn a_grid_does_not_grow_without_bound() {
        let mut grid = Occupancy::new(0.1);
        assert!(grid.add(&scan(0.05, &[0.5])));
        for x in [1e6, -1e9, 1e300, f64::INFINITY, f64::NAN] {
            grid.add(&scan(x, &[0.5]));
            assert!(grid.log_odds.len() < 4_000_000, "{x}");
        }
        assert_eq!(states(&grid, 1..7), "....#?");
    }
}
