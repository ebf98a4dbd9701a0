//! Free cells of a grid, merged into few rectangles.
//!
//! Row by row, the first free cell that belongs to no rectangle yet becomes the corner of one. It is grown as far
//! to the right and then up as it goes, or first up and then to the right: whichever is larger. Rectangles are
//! convex, they do not overlap, and together they are all that is free.

use baudbot_geometry::grid::{Growth, Rectangle, cover};

use super::grid::Grid;

/// Rectangles, and for each cell of the grid to which of them it belongs.
pub(super) fn merge(grid: &Grid) -> (Vec<Rectangle>, Vec<Option<usize>>) {
    let mut rest: Vec<_> = grid.cells().map(|cell| grid.is_free(cell)).collect();
    let rectangles: Vec<_> = cover(&mut rest, grid.columns(), Growth::Larger).collect();
    let mut owners = vec![None; grid.len()];
    for (i, rectangle) in rectangles.iter().enumerate() {
        for cell in rectangle.cells() {
            owners[grid.number(cell)] = Some(i);
        }
    }
    (rectangles, owners)
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
