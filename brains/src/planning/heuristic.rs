//! Estimates of the path that is left: f(n) of §6.2.1.

use std::f64::consts::SQRT_2;

use std::cell;

use baudbot_geometry::grid::{self, Cell};
use baudbot_geometry::math;

use super::grid::Grid;

/// The estimate of the path between two cells, in cells, as if there were no walls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heuristic {
    /// Steps along rows and columns: the true way of [`Moves::Four`](super::Moves::Four) in the open. With diagonal
    /// moves it estimates too much, and A\* may then miss the shortest path.
    Manhattan,
    /// The straight line. Never too much.
    Euclidean,
    /// Diagonal steps, then straight ones: the true way of eight moves in the open. Never too much.
    Octile,
}

impl Heuristic {
    /// The estimate, in cells.
    pub fn estimate(self, from: Cell, to: Cell) -> f64 {
        self.over(f64::from(from.column.abs_diff(to.column)), f64::from(from.row.abs_diff(to.row)))
    }

    /// The estimate for an offset, in its unit. Neither part of it is negative.
    pub(super) fn over(self, columns: f64, rows: f64) -> f64 {
        match self {
            Self::Manhattan => columns + rows,
            Self::Euclidean => math::hypot(columns, rows),
            Self::Octile => columns.max(rows) + (SQRT_2 - 1.0) * columns.min(rows),
        }
    }
}

/// A heuristic with a penalty for each obstacle on the straight line to the target: the text below Fig. 6.7.
///
/// It estimates too much wherever an obstacle can be passed for less than the penalty. So A\* may miss the shortest path; the search of
/// Fig. 6.7 sees a wall before it stands in front of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penalised {
    /// The estimate without obstacles.
    pub heuristic: Heuristic,
    /// The penalty for each obstacle, in cells; at least 0.
    pub penalty: f64,
}

impl From<Heuristic> for Penalised {
    fn from(heuristic: Heuristic) -> Self {
        Self { heuristic, penalty: 0.0 }
    }
}

impl Penalised {
    /// The estimate, in cells.
    pub fn estimate(self, grid: &Grid, from: Cell, to: Cell) -> f64 {
        let estimate = self.heuristic.estimate(from, to);
        // No line is drawn for nothing.
        if self.penalty == 0.0 {
            estimate
        } else {
            estimate + self.penalty * f64::from(obstacles(grid, from, to))
        }
    }
}

/// The number of obstacles on the straight line from centre to centre: blocked cells that it touches one after the other are one.
pub fn obstacles(grid: &Grid, from: Cell, to: Cell) -> u32 {
    let (count, was_free) = (cell::Cell::new(0), cell::Cell::new(true));
    // All cells are looked at, as none ends the line.
    let _ = grid::line_of_sight(from, to, |cell| {
        let is_free = grid.is_free(cell);
        if was_free.replace(is_free) && !is_free {
            count.set(count.get() + 1);
        }
        true
    });
    count.get()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocked_cells_in_a_row_are_one_obstacle() {
        let count = |text: &str| {
            let sketch = Grid::from_text(text).unwrap();
            obstacles(&sketch.grid, sketch.start.unwrap(), sketch.target.unwrap())
        };
        assert_eq!([count("S....T"), count("S.##.T"), count("S#.#.T"), count("S####T")], [0, 1, 2, 1]);
        assert_eq!(count("S..#\n....\n#..T"), 0);
        let sketch = Grid::from_text("S.#..T").unwrap();
        let (start, target) = (sketch.start.unwrap(), sketch.target.unwrap());
        let penalised = Penalised { heuristic: Heuristic::Euclidean, penalty: 3.5 };
        assert_eq!(penalised.estimate(&sketch.grid, start, target), 5.0 + 3.5);
        assert_eq!(Penalised::from(Heuristic::Euclidean).estimate(&sketch.grid, start, target), 5.0);
    }

    #[test]
    fn three_columns_and_four_rows() {
        let (from, to) = (Cell { column: 5, row: 1 }, Cell { column: 2, row: 5 });
        assert_eq!(Heuristic::Manhattan.estimate(from, to), 7.0);
        assert_eq!(Heuristic::Euclidean.estimate(from, to), 5.0);
        assert!((Heuristic::Octile.estimate(from, to) - (1.0 + 3.0 * SQRT_2)).abs() < 1e-15);
    }
}
