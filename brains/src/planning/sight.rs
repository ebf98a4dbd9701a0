//! Whether a straight line between two cells is free.

use super::grid::{Cell, Grid};

/// Whether all cells are free that the straight line from centre to centre touches, be it at a corner: its
/// supercover. It is found in whole numbers, so nothing is lost to rounding.
pub fn line_of_sight(grid: &Grid, from: Cell, to: Cell) -> bool {
    let columns = to.column.abs_diff(from.column);
    let rows = to.row.abs_diff(from.row);
    let (right, up) = (to.column > from.column, to.row > from.row);
    let mut cell = from;
    // Borders between columns and rows that have been crossed.
    let (mut across, mut along) = (0, 0);
    while grid.is_free(cell) {
        if cell == to {
            return true;
        }
        let beside = Cell { column: step(cell.column, right), ..cell };
        let above = Cell { row: step(cell.row, up), ..cell };
        // Where on the line the next border of each kind lies, both times 2 columns rows.
        let (next_column, next_row) = ((2 * across + 1) * rows, (2 * along + 1) * columns);
        if next_column == next_row {
            if !(grid.is_free(beside) && grid.is_free(above)) {
                return false;
            }
            cell = Cell { column: beside.column, row: above.row };
            (across, along) = (across + 1, along + 1);
        } else if next_column < next_row {
            (cell, across) = (beside, across + 1);
        } else {
            (cell, along) = (above, along + 1);
        }
    }
    false
}

/// The next number up or down; below 0 it wraps to one far outside of any grid.
fn step(number: usize, up: bool) -> usize {
    if up { number + 1 } else { number.wrapping_sub(1) }
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
