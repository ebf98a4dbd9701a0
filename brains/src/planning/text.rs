//! Grids as text, for examples and tests.

use baudbot_geometry::Point;
use baudbot_geometry::grid::Cell;

use super::grid::{Grid, GridError};

/// A grid that was drawn as text, with the marks that are in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sketch {
    /// The grid, with cells of 1 m and its origin at (0, 0).
    pub grid: Grid,
    /// The cell of the one `S`.
    pub start: Result<Cell, GridError>,
    /// The cell of the one `T`.
    pub target: Result<Cell, GridError>,
}

impl Grid {
    /// Reads a grid of which each line is a row, the first line row 0: `#` is blocked, `.` is free, and so are `S`
    /// and `T`, start and target. As rows go upwards and lines downwards, the picture stands on its head.
    ///
    /// # Errors
    /// Names the line that is no row, or as [`Grid::new`].
    pub fn from_text(text: &str) -> Result<Sketch, GridError> {
        let lines: Vec<_> = text.lines().collect();
        let columns = lines.first().map_or(0, |line| line.chars().count());
        let mut grid = Self::new(columns, lines.len(), 1.0, Point::origin())?;
        let (mut starts, mut targets) = (Vec::new(), Vec::new());
        for (row, line) in lines.iter().enumerate() {
            let cells = line.chars().count();
            if cells != columns {
                return Err(GridError::Ragged { line: row + 1, found: cells, expected: columns });
            }
            for (column, found) in line.chars().enumerate() {
                // A grid has fewer cells than an i32 can count.
                let cell = Cell { column: column as i32, row: row as i32 };
                match found {
                    '.' => {}
                    '#' => grid.block(cell),
                    'S' => starts.push(cell),
                    'T' => targets.push(cell),
                    _ => return Err(GridError::Character { line: row + 1, column: column + 1, found }),
                }
            }
        }
        Ok(Sketch { grid, start: one('S', &starts), target: one('T', &targets) })
    }
}

fn one(mark: char, cells: &[Cell]) -> Result<Cell, GridError> {
    match cells {
        [cell] => Ok(*cell),
        _ => Err(GridError::Marks { mark, found: cells.len() }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sketch_is_read_line_by_line() {
        let sketch = Grid::from_text("S.#\n..T\n").unwrap();
        assert_eq!((sketch.grid.columns(), sketch.grid.rows()), (3, 2));
        assert_eq!(sketch.start, Ok(Cell { column: 0, row: 0 }));
        assert_eq!(sketch.target, Ok(Cell { column: 2, row: 1 }));
        let blocked: Vec<_> = sketch.grid.cells().filter(|&cell| !sketch.grid.is_free(cell)).collect();
        assert_eq!(blocked, [Cell { column: 2, row: 0 }]);
    }

    #[test]
    fn what_is_no_sketch_is_refused_with_its_line() {
        let text = |text| Grid::from_text(text).unwrap_err().to_string();
        assert_eq!(text("..\n.x"), "line 2, column 2: `x` is not a cell; write `.`, `#`, `S` or `T`");
        assert_eq!(text("..\n..\n..."), "line 3 has 3 cells, the first line 2");
        assert_eq!(text(""), "a grid has 1 to 16777216 cells, not 0 columns by 0 rows");
        let two = Grid::from_text("SS").unwrap();
        assert_eq!(two.start.unwrap_err().to_string(), "there must be one `S`; there are 2");
        assert_eq!(two.target, Err(GridError::Marks { mark: 'T', found: 0 }));
    }
}
