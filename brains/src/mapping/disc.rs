//! Discs of cells, row by row.

use baudbot_geometry::math;

/// The cells whose centres are within some distance of that of one cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Disc {
    /// The distance of each row from the middle one, and the number of its cells on each side of its own middle.
    pub(crate) rows: Vec<(i32, i32)>,
}

impl Disc {
    /// A `Disc` with this radius, in cells.
    pub(crate) fn new(radius: f64) -> Self {
        let most = math::floor(radius) as i32;
        let is_in = |row: i32, column: i32| f64::from(row * row + column * column) <= radius * radius;
        let half = |row: i32| (0..=most).rev().find(|&column| is_in(row, column));
        Self { rows: (-most..=most).filter_map(|row| Some((row, half(row)?))).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_as_long_as_the_disc_is_wide_there() {
        assert_eq!(Disc::new(0.9).rows, [(0, 0)]);
        assert_eq!(Disc::new(1.5).rows, [(-1, 1), (0, 1), (1, 1)]);
        assert_eq!(
            Disc::new(5.0).rows.iter().map(|(_, half)| half).sum::<i32>(),
            35,
            "3, 4, 4, 4 and 5, to and fro"
        );
    }
}
