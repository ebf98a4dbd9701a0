//! Frontiers: B. Yamauchi, *A frontier-based approach for autonomous exploration*, CIRA 1997.
//!
//! A frontier is where what is known to be free ends at what is unknown: a free cell with an unknown one at one of its
//! four sides. Frontier cells that touch, at a corner too, are one group.

use super::occupancy::{Cell, Occupancy, Occupied};

/// Whether a cell is on a frontier.
#[must_use]
pub fn is_frontier(grid: &Occupancy, cell: Cell) -> bool {
    let is_unknown = |(columns, rows)| grid.state(cell.offset(columns, rows)) == Occupied::Unknown;
    grid.state(cell) == Occupied::Free && SIDES.into_iter().any(is_unknown)
}

/// For each cell of the grid, in order, whether it is on a frontier.
#[must_use]
pub(crate) fn frontiers(grid: &Occupancy) -> Vec<bool> {
    let known = grid.cells().zip(grid.values());
    known.map(|(cell, log_odds)| *log_odds < 0.0 && is_frontier(grid, cell)).collect()
}

/// The cells of the grid that are `waiting`, in order, in groups that touch.
#[must_use]
pub(crate) fn groups(grid: &Occupancy, mut waiting: Vec<bool>) -> Vec<Vec<Cell>> {
    let mut groups = Vec::new();
    for (place, cell) in grid.cells().enumerate() {
        if !std::mem::take(&mut waiting[place]) {
            continue;
        }
        let mut group = vec![cell];
        let mut next = 0;
        while let Some(&cell) = group.get(next) {
            next += 1;
            let around = (-1..=1).flat_map(|row| (-1..=1).map(move |column| cell.offset(column, row)));
            group.extend(
                around.filter(|cell| {
                    grid.place(*cell).is_some_and(|place| std::mem::take(&mut waiting[place]))
                }),
            );
        }
        groups.push(group);
    }
    groups
}

const SIDES: [(i32, i32); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use baudbot_geometry::Pose;

    use super::*;
    use crate::mapping::PlacedScan;
    use crate::scan::Scan;

    /// What half a turn sees of a corridor of 2 m whose walls are to the left and to the right.
    fn corridor() -> Occupancy {
        let mut grid = Occupancy::new(0.1);
        let rays = 1000;
        let mut scan = PlacedScan {
            world_from_robot: Pose::new(0.03, 0.03, 0.0),
            scan: Scan {
                robot_from_laser: Pose::new(0.0, 0.0, 0.0),
                opening_rad: PI,
                range_m: 3.0,
                distances_m: vec![f64::INFINITY; rays],
            },
        };
        for i in 0..rays {
            scan.scan.distances_m[i] = 1.0 / scan.scan.bearing_rad(i).sin().abs();
        }
        assert!(grid.add(&scan));
        grid
    }

    #[test]
    fn a_corridor_has_a_frontier_ahead_and_one_behind() {
        let grid = corridor();
        let groups = groups(&grid, frontiers(&grid));
        let mut columns: Vec<_> = groups.iter().map(|group| group[0].column).collect();
        columns.sort_unstable();
        assert_eq!(columns.len(), 2, "{columns:?}");
        assert!((-1..=0).contains(&columns[0]) && columns[1] >= 27, "{columns:?}");
        assert!(groups.iter().all(|group| group.len() >= 18), "they are as wide as the corridor");
    }

    #[test]
    fn only_cells_that_wait_are_found() {
        let grid = corridor();
        let ahead = frontiers(&grid).into_iter().zip(grid.cells()).map(|(is, cell)| is && cell.column > 5);
        assert_eq!(groups(&grid, ahead.collect()).len(), 1);
        let nothing = Occupancy::new(0.1);
        assert_eq!(groups(&nothing, frontiers(&nothing)), Vec::<Vec<Cell>>::new());
    }
}
