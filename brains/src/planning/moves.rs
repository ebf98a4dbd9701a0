//! The edges of the grid's graph: which cells are neighbours, and how far apart.

use std::f64::consts::SQRT_2;

use baudbot_geometry::grid::Cell;

use super::grid::Grid;

/// The steps that lead from a cell to its neighbours. A straight step is 1 cell long, a diagonal one √2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moves {
    /// Along rows and columns.
    Four,
    /// Diagonally too, even between two blocked cells that touch at a corner: for a robot that is a point.
    Eight,
    /// Diagonally only where both cells beside the step are free, so that no corner is cut.
    EightNoCut,
}

impl Moves {
    /// The free neighbours of a cell and the lengths, in cells, of the steps to them. The order is the same for all
    /// cells, straight steps first: it decides between ways that are equally good.
    pub fn neighbours(self, grid: &Grid, cell: Cell) -> impl Iterator<Item = (Cell, f64)> {
        let steps = match self {
            Self::Four => &STEPS[..4],
            Self::Eight | Self::EightNoCut => &STEPS[..],
        };
        steps.iter().filter_map(move |&(columns, rows)| {
            let diagonal = columns != 0 && rows != 0;
            let beside = [cell.offset(columns, 0), cell.offset(0, rows)];
            let cuts = self == Self::EightNoCut && diagonal && !beside.iter().all(|&cell| grid.is_free(cell));
            let next = cell.offset(columns, rows);
            (grid.is_free(next) && !cuts).then_some((next, if diagonal { SQRT_2 } else { 1.0 }))
        })
    }
}

const STEPS: [(i32, i32); 8] = [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)];

#[cfg(test)]
mod tests {
    use super::*;

    fn count(text: &str, moves: Moves) -> usize {
        let sketch = Grid::from_text(text).unwrap();
        moves.neighbours(&sketch.grid, sketch.start.unwrap()).count()
    }

    #[test]
    fn a_corner_may_be_cut_or_not() {
        let open = "...\n.S.\n...";
        assert_eq!([Moves::Four, Moves::Eight, Moves::EightNoCut].map(|m| count(open, m)), [4, 8, 8]);
        let beside_a_wall = "...\n.S#\n...";
        assert_eq!(
            [Moves::Four, Moves::Eight, Moves::EightNoCut].map(|m| count(beside_a_wall, m)),
            [3, 7, 5]
        );
        let in_the_corner = "S.\n..";
        assert_eq!(
            [Moves::Four, Moves::Eight, Moves::EightNoCut].map(|m| count(in_the_corner, m)),
            [2, 3, 3]
        );
    }
}
