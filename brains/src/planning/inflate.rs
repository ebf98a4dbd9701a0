//! Walls into a grid, made wider by the robot's body.
//!
//! §6.2.1 asks that a grid take the robot's size into account, with a margin. Here a cell is free only if *every*
//! point of it is as far from each wall as the clearance says: body and margin. So a robot whose centre stays
//! within free cells touches nothing, whatever curve it drives there, and convex cells can be made of free ones.

use baudbot_geometry::grid::Cell;
use baudbot_geometry::{Bounds, Point, Segment, Vector, math, polygon};

use super::grid::{Grid, GridError, check};

impl Grid {
    /// The grid that covers these walls, with the cells blocked that are nearer to one than `clearance_m`, in
    /// metres: the body's radius and a margin.
    ///
    /// # Errors
    /// If there are no walls, a number is not finite, the clearance is negative, or as [`Grid::new`].
    pub fn from_segments(walls: &[Segment], cell_m: f64, clearance_m: f64) -> Result<Self, GridError> {
        check("clearance_m", "0 or more", clearance_m, clearance_m >= 0.0)?;
        let bounds = walls.iter().map(Bounds::of_segment).reduce(|a, b| a.union(&b));
        let mut grid = Self::covering(&bounds.ok_or(GridError::NoWalls)?, cell_m)?;
        for wall in walls {
            grid.block_near(wall, clearance_m);
        }
        Ok(grid)
    }

    /// Blocks the cells through which the wall runs, and those with a point nearer to it than `clearance_m`.
    pub fn block_near(&mut self, wall: &Segment, clearance_m: f64) {
        let reach = Vector::new(clearance_m, clearance_m);
        let bounds = Bounds::of_segment(wall);
        for cell in self.within(bounds.min - reach, bounds.max + reach) {
            if self.is_free(cell) && self.is_near(cell, wall, clearance_m) {
                self.block(cell);
            }
        }
    }

    /// Blocks the inside of a solid polygon, given by its corners in order, and what is nearer to it than
    /// `clearance_m`.
    pub fn block_polygon(&mut self, corners: &[Point], clearance_m: f64) {
        for edge in polygon::edges(corners) {
            self.block_near(&edge, clearance_m);
        }
        // No edge runs through the cells that are left, so one point of each speaks for all of it.
        let inside: Vec<_> =
            self.cells().filter(|&cell| polygon::contains(corners, self.center(cell))).collect();
        for cell in inside {
            self.block(cell);
        }
    }

    /// The cells that have a point in the box between two corners, and a few around them.
    pub(crate) fn within(&self, least: Point, greatest: Point) -> impl Iterator<Item = Cell> + use<> {
        let place = |m: f64, origin_m: f64| math::floor((m - origin_m) / self.cell_m());
        let range = |from: f64, to: f64, count: i32| {
            // A cast ends at the largest number.
            (from - 1.0).max(0.0) as i32..((to + 2.0).max(0.0) as i32).min(count)
        };
        let extent = self.extent();
        let columns =
            range(place(least.x, self.origin().x), place(greatest.x, self.origin().x), extent.columns);
        let rows = range(place(least.y, self.origin().y), place(greatest.y, self.origin().y), extent.rows);
        rows.flat_map(move |row| columns.clone().map(move |column| Cell { column, row }))
    }

    /// Whether the wall runs through a cell, or a point of the cell is nearer to it than `clearance_m`.
    fn is_near(&self, cell: Cell, wall: &Segment, clearance_m: f64) -> bool {
        let is_near = |distance_m: f64| distance_m == 0.0 || distance_m < clearance_m - ROUNDING_M;
        let corner = |columns, rows| self.corner(cell.offset(columns, rows));
        let lowest = corner(0, 0);
        let lowest_m = wall.distance(lowest);
        // No point of the cell is farther from its corner than its diagonal.
        if is_near(lowest_m) || lowest_m > clearance_m.max(0.0) + 1.5 * self.cell_m() {
            return is_near(lowest_m);
        }
        let (low, high) = ([lowest, corner(1, 0)], [corner(0, 1), corner(1, 1)]);
        if [low[1], high[0], high[1]].into_iter().any(|corner| is_near(wall.distance(corner))) {
            return true;
        }
        // If the nearest point is no corner it is an end of the wall, or the wall cuts through the square. Then it parts one
        // corner from the opposite one, so it crosses a diagonal.
        let square = Bounds { min: low[0], max: high[1] };
        let diagonals = [Segment { start: low[0], end: high[1] }, Segment { start: low[1], end: high[0] }];
        [wall.start, wall.end].into_iter().any(|end| is_near(square.distance(end)))
            || diagonals.iter().any(|diagonal| diagonal.touches(wall))
    }
}

/// The length, in metres, by which a cell may be nearer than the clearance and still be free: a wall and a clearance
/// that are whole numbers of cells shall not block a cell more for a rounding.
const ROUNDING_M: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    fn wall(x0: f64, y0: f64, x1: f64, y1: f64) -> Segment {
        Segment { start: Point::new(x0, y0), end: Point::new(x1, y1) }
    }

    fn picture(grid: &Grid) -> Vec<String> {
        let letters: Vec<_> = grid.cells().map(|cell| if grid.is_free(cell) { '.' } else { '#' }).collect();
        letters.chunks(grid.columns()).map(|row| row.iter().collect()).collect()
    }

    #[test]
    fn a_free_cell_is_clear_of_all_walls_and_a_blocked_one_is_not() {
        let walls = [wall(0.0, 0.0, 4.0, 0.0), wall(0.4, 2.7, 3.1, 0.9), wall(4.0, 3.0, 4.0, 3.0)];
        let (cell_m, clearance_m) = (0.1, 0.33);
        let grid = Grid::from_segments(&walls, cell_m, clearance_m).unwrap();
        let mut free = 0;
        for cell in grid.cells() {
            // The nearest points of a square are those of its border.
            let along = |i: u32| f64::from(i) * cell_m / 20.0;
            let offsets = (0..=20).flat_map(|i| {
                let (a, b) = (along(i), along(20));
                [(a, 0.0), (a, b), (0.0, a), (b, a)]
            });
            let points = offsets.map(|(x, y)| grid.corner(cell) + Vector::new(x, y));
            let nearest = points.flat_map(|p| walls.map(|w| w.distance(p))).fold(f64::INFINITY, f64::min);
            if grid.is_free(cell) {
                assert!(nearest >= clearance_m - 1e-9, "{cell:?}: {nearest}");
                free += 1;
            } else {
                // Only sampled, so a little too large.
                assert!(nearest < clearance_m + 1e-3, "{cell:?}: {nearest}");
            }
        }
        assert!(free > 300, "{free}");
    }

    /// The distance between a cell, as a solid square, and a wall, in metres.
    fn distance_m(grid: &Grid, cell: Cell, wall: &Segment) -> f64 {
        let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(x, y)| grid.corner(cell.offset(x, y)));
        let diagonals = [[0, 2], [1, 3]].map(|[a, b]| Segment { start: corners[a], end: corners[b] });
        if diagonals.iter().any(|diagonal| diagonal.touches(wall)) {
            return 0.0;
        }
        let square = Bounds { min: corners[0], max: corners[2] };
        let ends = [wall.start, wall.end].map(|end| square.distance(end));
        let corners = corners.map(|corner| wall.distance(corner));
        ends.into_iter().chain(corners).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn blocked_are_the_cells_whose_distance_to_the_wall_is_less_than_the_clearance() {
        let mut chance = crate::Chance::new(1, "inflate");
        for i in 0..300 {
            let grid = Grid::new(23, 17, 0.3, Point::new(-2.1, 0.7)).unwrap();
            // Some along borders and corners of cells.
            let part = if i % 3 == 0 { 1.0 } else { 0.37 };
            let mut end = || {
                let place = [23.0, 17.0].map(|count| math::floor(chance.uniform() * count) * part * 0.3);
                grid.origin() + Vector::new(place[0], place[1])
            };
            let wall = Segment { start: end(), end: end() };
            for clearance_m in [0.0, 0.1, 0.3, 0.65] {
                let mut blocked = grid.clone();
                blocked.block_near(&wall, clearance_m);
                for cell in grid.cells() {
                    let distance_m = distance_m(&grid, cell, &wall);
                    let is_near = distance_m == 0.0 || distance_m < clearance_m - ROUNDING_M;
                    assert_eq!(blocked.is_free(cell), !is_near, "{cell:?}: {distance_m}, {wall:?}");
                }
            }
        }
    }

    #[test]
    fn a_wall_without_clearance_blocks_what_it_runs_through() {
        let mut grid = Grid::new(5, 3, 1.0, Point::origin()).unwrap();
        grid.block_near(&wall(0.5, 1.4, 3.5, 1.6), 0.0);
        assert_eq!(picture(&grid), [".....", "####.", "....."]);
        // One far away blocks nothing.
        grid.block_near(&wall(-50.0, -70.0, 1e9, -1e9), 0.5);
        assert_eq!(picture(&grid), [".....", "####.", "....."]);
    }

    #[test]
    fn a_clearance_of_whole_cells_blocks_whole_cells() {
        let walls = [wall(0.0, 0.0, 0.9, 0.0), wall(0.0, 0.5, 0.9, 0.5)];
        let grid = Grid::from_segments(&walls, 0.1, 0.2).unwrap();
        assert_eq!(picture(&grid), ["#########", "#########", ".........", "#########", "#########"]);
    }

    #[test]
    fn a_solid_polygon_is_blocked_inside_too() {
        let mut grid = Grid::new(9, 7, 1.0, Point::origin()).unwrap();
        let corners = [(2.5, 1.5), (6.5, 1.5), (6.5, 5.5), (2.5, 5.5)].map(|(x, y)| Point::new(x, y));
        grid.block_polygon(&corners, 0.0);
        assert_eq!(picture(&grid)[3], "..#####..");
        assert_eq!(picture(&grid)[0], ".........");
    }

    #[test]
    fn maps_without_sense_are_refused() {
        assert_eq!(Grid::from_segments(&[], 0.1, 0.2), Err(GridError::NoWalls));
        let nowhere = [wall(0.0, f64::NAN, 1.0, 1.0)];
        assert!(Grid::from_segments(&nowhere, 0.1, 0.2).is_err());
        let negative = Grid::from_segments(&[wall(0.0, 0.0, 1.0, 1.0)], 0.1, -0.2).unwrap_err();
        assert_eq!(negative.to_string(), "clearance_m must be 0 or more, not -0.2");
    }
}
