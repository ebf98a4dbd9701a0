//! Whether a straight line between two cells is free.

use super::Cell;

/// Whether all cells are free that the straight line from centre to centre touches, be it at a corner: its
/// supercover. It is found in whole numbers, so nothing is lost to rounding.
#[must_use]
pub fn line_of_sight(from: Cell, to: Cell, is_free: impl Fn(Cell) -> bool) -> bool {
    let columns = u64::from(to.column.abs_diff(from.column));
    let rows = u64::from(to.row.abs_diff(from.row));
    let (right, up) = (to.column.cmp(&from.column) as i32, to.row.cmp(&from.row) as i32);
    let mut cell = from;
    // Borders between columns and rows that have been crossed.
    let (mut across, mut along) = (0, 0);
    while is_free(cell) {
        if cell == to {
            return true;
        }
        let (beside, above) = (cell.offset(right, 0), cell.offset(0, up));
        // Places on the line of the next border of each kind, both times 2 columns rows.
        let (next_column, next_row) = ((2 * across + 1) * rows, (2 * along + 1) * columns);
        if next_column == next_row {
            if !(is_free(beside) && is_free(above)) {
                return false;
            }
            cell = cell.offset(right, up);
            (across, along) = (across + 1, along + 1);
        } else if next_column < next_row {
            (cell, across) = (beside, across + 1);
        } else {
            (cell, along) = (above, along + 1);
        }
    }
    false
}
