//! The map in which a path is planned: what stands still in the arena, as a brain would have been given it.

use baudbot_brains::planning::{Cell, Grid, GridError};
use baudbot_geometry::{Bounds, Segment};
use baudbot_sim::arena::Arena;

/// The cells of an arena. Those are blocked that have a point nearer to a wall than `clearance_m`.
pub(super) fn grid(arena: &Arena, cell_m: f64, clearance_m: f64) -> Result<Grid, GridError> {
    let mut grid = Grid::covering(&bounds(arena).ok_or(GridError::NoWalls)?, cell_m)?;
    for polygon in arena.polygons() {
        match polygon.solid {
            true => grid.block_polygon(&polygon.points, clearance_m),
            false => polygon.edges().for_each(|edge| grid.block_near(&edge, clearance_m)),
        }
    }
    for pillar in arena.pillars() {
        // A disc is what is near to its centre.
        let (start, radius_m) = (pillar.circle.center, pillar.circle.radius);
        grid.block_near(&Segment { start, end: start }, radius_m + clearance_m);
    }
    Ok(grid)
}

/// The box around all that stands in it.
pub(super) fn bounds(arena: &Arena) -> Option<Bounds> {
    let polygons = arena.polygons().iter().filter_map(|polygon| Bounds::of_points(&polygon.points));
    let pillars = arena.pillars().iter().map(|pillar| Bounds::of_circle(&pillar.circle));
    polygons.chain(pillars).reduce(|a, b| a.union(&b))
}

/// Cells as few boxes: each a run of them in a row. They are to be in the order of rows.
pub(super) fn runs(grid: &Grid, which: impl Fn(Cell) -> bool) -> Vec<Bounds> {
    let mut runs: Vec<(Cell, i32)> = Vec::new();
    for cell in grid.cells().filter(|&cell| which(cell)) {
        match runs.last_mut() {
            Some((first, length)) if first.row == cell.row && first.column + *length == cell.column => {
                *length += 1;
            }
            _ => runs.push((cell, 1)),
        }
    }
    let of_run = |(first, length): (Cell, i32)| Bounds {
        min: grid.corner(first),
        max: grid.corner(first.offset(length, 1)),
    };
    runs.into_iter().map(of_run).collect()
}

#[cfg(test)]
mod tests {
    use baudbot_geometry::Point;

    use super::*;

    const ROOM: &str = r#"
        [[arena.polygons]]
        name = "room"
        solid = false
        points_m = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]

        [[arena.circles]]
        name = "pillar"
        x_m = 2.0
        y_m = 1.5
        radius_m = 0.3
    "#;

    #[test]
    fn a_cell_is_free_if_all_of_it_is_clear() {
        let scenario = baudbot_scenario::parse(ROOM).unwrap();
        let grid = grid(&scenario.arena, 0.1, 0.2).unwrap();
        assert_eq!((grid.columns(), grid.rows()), (40, 30));
        let pillar = scenario.arena.pillars()[0].circle;
        for cell in grid.cells() {
            let least = grid.corner(cell);
            let square = Bounds { min: least, max: grid.corner(cell.offset(1, 1)) };
            let wall = least.x.min(least.y).min(4.0 - square.max.x).min(3.0 - square.max.y);
            let clear = wall > 0.2 - 1e-6 && square.distance(pillar.center) > 0.5 - 1e-6;
            assert_eq!(grid.is_free(cell), clear, "{cell:?}");
        }
    }

    #[test]
    fn a_plane_without_walls_is_no_map() {
        let nothing = baudbot_scenario::parse("").unwrap();
        assert_eq!(grid(&nothing.arena, 0.1, 0.2), Err(GridError::NoWalls));
    }

    #[test]
    fn cells_of_a_row_are_one_box() {
        let grid = Grid::new(4, 2, 0.5, Point::origin()).unwrap();
        let all = runs(&grid, |cell| cell.row == 0 || cell.column != 1);
        let corners: Vec<_> = all.iter().map(|run| (run.min.x, run.max.x, run.min.y)).collect();
        assert_eq!(corners, [(0.0, 2.0, 0.0), (0.0, 0.5, 0.5), (1.0, 2.0, 0.5)]);
    }
}
