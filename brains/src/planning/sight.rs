//! Whether a straight line between two cells is free.

use baudbot_geometry::grid::{self, Cell};

use super::grid::Grid;

/// Whether all cells are free that the straight line from centre to centre touches, be it at a corner.
pub fn line_of_sight(grid: &Grid, from: Cell, to: Cell) -> bool {
    grid::line_of_sight(from, to, |cell| grid.is_free(cell))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sees(text: &str) -> bool {
        let sketch = Grid::from_text(text).unwrap();
        let (start, target) = (sketch.start.unwrap(), sketch.target.unwrap());
        let there = line_of_sight(&sketch.grid, start, target);
        assert_eq!(there, line_of_sight(&sketch.grid, target, start), "the same from the other end");
        there
    }

    #[test]
    fn a_line_that_touches_a_blocked_cell_is_not_free() {
        assert!(sees("S...T"));
        assert!(!sees("S.#.T"));
        assert!(sees("S..\n...\n..T"));
        assert!(!sees("S#.\n...\n..T"), "a corner");
        assert!(!sees("S..\n...\n.#T"), "a corner");
        assert!(sees("S...\n...T"));
        assert!(!sees("S.##\n##.T"), "it runs through a corner");
        assert!(sees("S.#\n#.T"), "from cell to cell across the middle");
        assert!(!sees("S#..\n...T"));
    }

    #[test]
    fn lines_straight_up_and_to_where_one_stands() {
        assert!(sees("S\n.\nT"));
        assert!(!sees("S\n#\nT"));
        let grid = Grid::from_text(".").unwrap().grid;
        let cell = Cell { column: 0, row: 0 };
        assert!(line_of_sight(&grid, cell, cell));
        assert!(!line_of_sight(&grid, cell, Cell { column: 3, row: 9 }), "outside");
    }
}
