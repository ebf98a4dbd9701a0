//! Free cells of a grid, merged into few rectangles.
//!
//! Row by row, the first free cell that belongs to no rectangle yet becomes the corner of one. It is grown as far
//! to the right and then up as it goes, or first up and then to the right: whichever is larger. Rectangles are
//! convex, they do not overlap, and together they are all that is free.

use super::grid::{Cell, Grid};

/// Cells from `least` to `greatest`, both included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rectangle {
    pub(super) least: Cell,
    pub(super) greatest: Cell,
}

/// Rectangles, and for each cell of the grid to which of them it belongs.
pub(super) fn merge(grid: &Grid) -> (Vec<Rectangle>, Vec<Option<usize>>) {
    let mut rectangles = Vec::new();
    let mut owners = vec![None; grid.len()];
    for cell in grid.cells() {
        let is_left = |cell: Cell| grid.is_free(cell) && owners[grid.number(cell)].is_none();
        if !is_left(cell) {
            continue;
        }
        let (wide, high) = (widest(cell, &is_left), highest(cell, &is_left));
        let rectangle = if high.area() > wide.area() { high } else { wide };
        for cell in rectangle.cells() {
            owners[grid.number(cell)] = Some(rectangles.len());
        }
        rectangles.push(rectangle);
    }
    (rectangles, owners)
}

impl Rectangle {
    fn area(&self) -> usize {
        (self.greatest.column - self.least.column + 1) * (self.greatest.row - self.least.row + 1)
    }

    fn cells(self) -> impl Iterator<Item = Cell> {
        let columns = self.least.column..=self.greatest.column;
        (self.least.row..=self.greatest.row)
            .flat_map(move |row| columns.clone().map(move |column| Cell { column, row }))
    }
}

/// The rectangle with this corner that goes right as far as it can, and then up.
fn widest(corner: Cell, is_left: &impl Fn(Cell) -> bool) -> Rectangle {
    let end = |row| (corner.column..).take_while(move |&column| is_left(Cell { column, row })).last();
    let last = end(corner.row).unwrap_or(corner.column);
    let is_row = |row: &usize| (corner.column..=last).all(|column| is_left(Cell { column, row: *row }));
    let row = (corner.row..).take_while(is_row).last().unwrap_or(corner.row);
    Rectangle { least: corner, greatest: Cell { column: last, row } }
}

/// The rectangle with this corner that goes up as far as it can, and then right.
fn highest(corner: Cell, is_left: &impl Fn(Cell) -> bool) -> Rectangle {
    let transposed = |cell: Cell| Cell { column: cell.row, row: cell.column };
    let found = widest(transposed(corner), &|cell| is_left(transposed(cell)));
    Rectangle { least: corner, greatest: transposed(found.greatest) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_grid_is_one_rectangle_and_a_wall_makes_four() {
        let count = |text| merge(&Grid::from_text(text).unwrap().grid).0.len();
        assert_eq!(count("....\n....\n...."), 1);
        assert_eq!(count("#"), 0);
        assert_eq!(count(".....\n..#..\n....."), 4);
    }

    #[test]
    fn each_free_cell_belongs_to_the_one_rectangle_that_has_it() {
        let grid = Grid::from_text("..#....\n.......\n#..##..\n...#...\n.#.....").unwrap().grid;
        let (rectangles, owners) = merge(&grid);
        for cell in grid.cells() {
            let has: Vec<_> =
                (0..rectangles.len()).filter(|&i| rectangles[i].cells().any(|c| c == cell)).collect();
            assert_eq!(has, Vec::from_iter(owners[grid.number(cell)]), "{cell:?}");
            assert_eq!(has.len(), usize::from(grid.is_free(cell)), "{cell:?}");
        }
    }
}
