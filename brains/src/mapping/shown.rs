//! A grid for people who look.

use baudbot_client::GridMap;
use baudbot_geometry::math;

use super::occupancy::Occupancy;

impl Occupancy {
    /// The grid as observers are shown it: a byte a cell, from 0, free for sure, to 254, occupied for sure, and 255 where
    /// nothing is known.
    #[must_use]
    pub fn shown(&self) -> GridMap {
        let byte = |log_odds: f32| match f64::from(log_odds) {
            0.0 => 255,
            // From 0 to 254.
            log_odds => math::round(254.0 / (1.0 + math::exp(-log_odds))) as u8,
        };
        let corner =
            self.cells().next().map_or_else(baudbot_geometry::Point::origin, |first| self.center(first));
        GridMap {
            x_m: corner.x - 0.5 * self.cell_m(),
            y_m: corner.y - 0.5 * self.cell_m(),
            cell_m: self.cell_m(),
            columns: self.columns(),
            cells: self.cells().map(|cell| byte(self.log_odds(cell))).collect(),
        }
    }
}

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
        assert!(grid.add(&PlacedScan { world_from_robot: Pose::new(-1.0, 0.02, 0.0), scan }));
        let shown = grid.shown();
        let at = |point: Point| {
            let [column, row] = [point.x - shown.x_m, point.y - shown.y_m].map(|way| (way / 0.1) as u32);
            shown.cells[(row * shown.columns + column) as usize]
        };
        assert_eq!(at(Point::new(-0.8, 0.05)), 102, "p = 0.4");
        assert_eq!(at(Point::new(-0.45, 0.05)), 178, "p = 0.7");
        assert_eq!(at(Point::new(-0.35, 0.05)), 255);
    }
}
