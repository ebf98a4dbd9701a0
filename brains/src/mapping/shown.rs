//! A grid for observers.

use baudbot_brain::GridMap;
use baudbot_geometry::grid::Cell;
use baudbot_geometry::math;

use super::occupancy::Occupancy;

impl Occupancy {
    /// The grid as observers are shown it: a byte a cell, from 0, free for sure, to 254, occupied for sure, and 255 where
    /// nothing is known. Only the part of it of which something is known; and where that is too large to be published, with
    /// cells as large as several of its own, each as occupied as the most occupied of them.
    #[must_use]
    pub fn shown(&self) -> GridMap {
        let known = || self.cells().filter(|&cell| self.log_odds(cell) != 0.0);
        let Some((low, high)) = known().map(|cell| (cell, cell)).reduce(union) else {
            return GridMap { x_m: 0.0, y_m: 0.0, cell_m: self.cell_m(), columns: 0, cells: Vec::new() };
        };
        let sides = [high.column - low.column, high.row - low.row].map(|last| last as usize + 1);
        let across = |each: usize| sides.map(|side| side.div_ceil(each));
        let fits =
            |[columns, rows]: [usize; 2]| columns * rows <= MOST_CELLS && columns.max(rows) <= MOST_A_SIDE;
        let each = (1..).find(|&each| fits(across(each))).unwrap_or(1);
        let [columns, rows] = across(each);
        let mut most: Vec<Option<f32>> = vec![None; columns * rows];
        for cell in known() {
            let [column, row] =
                [cell.column - low.column, cell.row - low.row].map(|number| number as usize / each);
            let place = &mut most[row * columns + column];
            let log_odds = self.log_odds(cell);
            *place = Some(place.map_or(log_odds, |other| other.max(log_odds)));
        }
        let corner = self.center(low);
        GridMap {
            x_m: corner.x - 0.5 * self.cell_m(),
            y_m: corner.y - 0.5 * self.cell_m(),
            cell_m: each as f64 * self.cell_m(),
            columns: columns as u32,
            cells: most.into_iter().map(|log_odds| log_odds.map_or(UNKNOWN, byte)).collect(),
        }
    }
}

/// The brightness of a cell, 0 to 254.
fn byte(log_odds: f32) -> u8 {
    math::round(254.0 / (1.0 + math::exp(-f64::from(log_odds)))) as u8
}

/// The corners of the box around two boxes.
fn union((low, high): (Cell, Cell), (other_low, other_high): (Cell, Cell)) -> (Cell, Cell) {
    let low = Cell { column: low.column.min(other_low.column), row: low.row.min(other_low.row) };
    (low, Cell { column: high.column.max(other_high.column), row: high.row.max(other_high.row) })
}

const UNKNOWN: u8 = 255;
/// The most cells of a belief, of which a server takes 256 KiB, and 4096 cells a side.
const MOST_CELLS: usize = 200_000;
const MOST_A_SIDE: usize = 4096;

#[cfg(test)]
mod tests {
    use baudbot_geometry::{Point, Pose};

    use super::*;
    use crate::mapping::PlacedScan;
    use crate::scan::Scan;

    #[test]
    fn what_is_shown_is_where_it_is_on_the_grid() {
        let robot_from_laser = Pose::new(0.0, 0.0, 0.0);
        let scan = Scan { robot_from_laser, opening_rad: 1.0, range_m: 2.0, distances_m: vec![0.5] };
        let mut grid = Occupancy::new(0.1);
        assert!(grid.shown().cells.is_empty());
        assert!(grid.add(&PlacedScan::new(Pose::new(-1.0, 0.02, 0.0), scan)));
        let shown = grid.shown();
        let at = |point: Point| {
            let [column, row] = [point.x - shown.x_m, point.y - shown.y_m].map(|path| (path / 0.1) as u32);
            shown.cells[(row * shown.columns + column) as usize]
        };
        assert_eq!(at(Point::new(-0.8, 0.05)), 102, "p = 0.4");
        assert_eq!(at(Point::new(-0.45, 0.05)), 178, "p = 0.7");
        assert_eq!(shown.cells.len() as u32 % shown.columns, 0);
        assert!(shown.cells.len() < 20, "only what is known: {shown:?}");
    }

    #[test]
    fn a_large_map_is_shown_with_larger_cells_and_its_walls_stay() {
        let robot_from_laser = Pose::new(0.0, 0.0, 0.0);
        let mut grid = Occupancy::new(0.05);
        for x in 0..20 {
            let distances_m = vec![8.0; 100];
            let scan = Scan { robot_from_laser, opening_rad: 6.2, range_m: 9.0, distances_m };
            let world_from_robot = Pose::new(4.0 * f64::from(x), 0.0, 0.0);
            assert!(grid.add(&PlacedScan::new(world_from_robot, scan)));
        }
        let shown = grid.shown();
        assert!(
            shown.cells.len() <= 200_000 && shown.cell_m > 0.09,
            "{} {}",
            shown.cells.len(),
            shown.cell_m
        );
        let rows = shown.cells.len() / shown.columns as usize;
        assert!((f64::from(shown.columns) * shown.cell_m - 92.0).abs() < 0.3, "{}", shown.columns);
        assert!((rows as f64 * shown.cell_m - 16.0).abs() < 0.3, "{rows}");
        assert!(shown.cells.contains(&178), "walls: p = 0.7");
    }
}
