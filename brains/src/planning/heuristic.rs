//! Estimates of the path that is left: f(n) of §6.2.1.

use std::f64::consts::SQRT_2;

use baudbot_geometry::grid::Cell;
use baudbot_geometry::math;

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
        let columns = f64::from(from.column.abs_diff(to.column));
        let rows = f64::from(from.row.abs_diff(to.row));
        match self {
            Self::Manhattan => columns + rows,
            Self::Euclidean => math::hypot(columns, rows),
            Self::Octile => columns.max(rows) + (SQRT_2 - 1.0) * columns.min(rows),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_columns_and_four_rows() {
        let (from, to) = (Cell { column: 5, row: 1 }, Cell { column: 2, row: 5 });
        assert_eq!(Heuristic::Manhattan.estimate(from, to), 7.0);
        assert_eq!(Heuristic::Euclidean.estimate(from, to), 5.0);
        assert!((Heuristic::Octile.estimate(from, to) - (1.0 + 3.0 * SQRT_2)).abs() < 1e-15);
    }
}
