//! Few rectangles that cover cells, each of them once.

use super::{Cell, Rectangle};

/// The order in which a rectangle grows from its first cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Growth {
    /// Along its row as far as it can, then row by row.
    RowFirst,
    /// So, or along its column first: whichever makes it larger.
    Larger,
}

/// Rectangles that cover the cells of `rest`, which are numbered row by row in rows of so many columns, and do not
/// overlap. What they cover is taken out of `rest`.
///
/// From the first cell that is not covered yet a rectangle grows. That does not give the least number of them, but with
/// [`Growth::RowFirst`] it takes time in proportion to the number of cells.
pub fn cover(rest: &mut [bool], columns: usize, growth: Growth) -> impl Iterator<Item = Rectangle> {
    let mut at = 0;
    core::iter::from_fn(move || {
        at += rest.get(at..)?.iter().position(|&is_left| is_left)?;
        let (left, row) = (at % columns, at / columns);
        let mut corner = Corner { rest, columns, left, row };
        let wide = corner.widest();
        let size = match growth {
            Growth::RowFirst => wide,
            Growth::Larger => {
                let high = corner.highest();
                if high.0 * high.1 > wide.0 * wide.1 { high } else { wide }
            }
        };
        corner.take(size);
        at += size.0;
        let first = Cell { column: left as i32, row: row as i32 };
        Some(Rectangle { first, columns: size.0 as i32, rows: size.1 as i32 })
    })
}

/// The first cell of a rectangle.
struct Corner<'a> {
    rest: &'a mut [bool],
    columns: usize,
    left: usize,
    row: usize,
}

impl Corner<'_> {
    /// Columns and rows of the rectangle that goes along the row as far as it can, and then row by row.
    fn widest(&self) -> (usize, usize) {
        let width = self.ahead(0).iter().take_while(|&&is_left| is_left).count();
        (width, self.rows_of(width))
    }

    /// Columns and rows of the rectangle that goes along the column as far as it can, and then column by column.
    fn highest(&self) -> (usize, usize) {
        let rows = self.rows_of(1);
        let is_left = |&column: &usize| (0..rows).all(|row| self.ahead(row)[column]);
        ((0..self.columns - self.left).take_while(is_left).count(), rows)
    }

    fn rows_of(&self, width: usize) -> usize {
        let rows = self.rest.len() / self.columns - self.row;
        (0..rows).take_while(|&row| self.ahead(row)[..width].iter().all(|&is_left| is_left)).count()
    }

    /// The cells from its column to the end of the row, so many rows on.
    fn ahead(&self, rows: usize) -> &[bool] {
        let begin = (self.row + rows) * self.columns;
        &self.rest[begin + self.left..begin + self.columns]
    }

    fn take(&mut self, (columns, rows): (usize, usize)) {
        for row in self.row..self.row + rows {
            self.rest[row * self.columns + self.left..][..columns].fill(false);
        }
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;

    fn sizes(text: &str, growth: Growth) -> Vec<(i32, i32)> {
        let columns = text.lines().next().unwrap_or_default().len();
        let cells = text.lines().flat_map(str::bytes).map(|byte| byte == b'#');
        let mut rest: Vec<_> = cells.collect();
        let found: Vec<_> = cover(&mut rest, columns, growth).collect();
        assert!(!rest.contains(&true));
        found.iter().map(|rectangle| (rectangle.columns, rectangle.rows)).collect()
    }

    #[test]
    fn rectangles_grow_along_the_row_or_to_the_larger_side() {
        let corner = "##\n#.\n#.";
        assert_eq!(sizes(corner, Growth::RowFirst), [(2, 1), (1, 2)]);
        assert_eq!(sizes(corner, Growth::Larger), [(1, 3), (1, 1)]);
        assert_eq!(sizes("###\n###", Growth::RowFirst), [(3, 2)]);
        assert_eq!(sizes("...", Growth::Larger), []);
        assert_eq!(sizes("", Growth::Larger), []);
    }
}
