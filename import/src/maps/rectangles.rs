//! Few rectangles that cover the occupied cells of a map, each of them once.

/// Which cells of a map are occupied, by rows from the top.
#[derive(Debug)]
pub(crate) struct Bitmap {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) cells: Vec<bool>,
}

/// Occupied cells with nothing free between them.
#[derive(Debug)]
pub(crate) struct Rectangle {
    pub(crate) left: usize,
    /// The first row, counted from the top.
    pub(crate) top: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

/// Rectangles that cover the occupied cells and do not overlap, or nothing if it takes more than `limit`.
///
/// From the first cell that is not covered yet a rectangle grows to the right as far as it can, then down.
/// That is not the least number, but it takes time in proportion to the number of cells.
pub(crate) fn cover(mut rest: Bitmap, limit: usize) -> Option<Vec<Rectangle>> {
    let mut rectangles = Vec::new();
    for top in 0..rest.height {
        let mut right = 0;
        while let Some(free) = rest.row(top)[right..].iter().position(|&is_occupied| is_occupied) {
            let left = right + free;
            let width = rest.row(top)[left..].iter().take_while(|&&is_occupied| is_occupied).count();
            right = left + width;
            let is_full = |row: &usize| rest.row(*row)[left..right].iter().all(|&is_occupied| is_occupied);
            let height = (top..rest.height).take_while(is_full).count();
            if rectangles.len() == limit {
                return None;
            }
            for row in top..top + height {
                rest.row_mut(row)[left..right].fill(false);
            }
            rectangles.push(Rectangle { left, top, width, height });
        }
    }
    Some(rectangles)
}

impl Bitmap {
    fn row(&self, row: usize) -> &[bool] {
        &self.cells[row * self.width..][..self.width]
    }

    fn row_mut(&mut self, row: usize) -> &mut [bool] {
        &mut self.cells[row * self.width..][..self.width]
    }
}
