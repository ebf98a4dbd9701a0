//! The places from which something can be seen that is still dark.

use std::collections::BTreeSet;

use crate::mapping::frontier::Dark;
use crate::mapping::{Cell, Occupancy};

/// The nearest dark cell that can be seen from each cell of a grid, of those that are looked for.
pub(super) struct Outlook<'a> {
    grid: &'a Occupancy,
    wanted: Vec<Cell>,
    /// In the order of the grid's cells, the number of the wanted cell.
    seen: Vec<Option<u32>>,
}

impl<'a> Outlook<'a> {
    /// An `Outlook` over the places from which these cells can be seen within so many metres.
    pub(super) fn new(grid: &'a Occupancy, dark: &Dark<'_>, wanted: Vec<Cell>, view_m: f64) -> Self {
        let [columns, rows] = grid.size();
        let mut seen: Vec<Option<u32>> = vec![None; columns * rows];
        for (number, &cell) in wanted.iter().enumerate() {
            dark.light(cell, view_m, |place| {
                let squared = |number: u32| wanted[number as usize].distance_squared(grid.cell_of(place));
                let number = number as u32;
                if seen[place].is_none_or(|old| squared(number) < squared(old)) {
                    seen[place] = Some(number);
                }
            });
        }
        Self { grid, wanted, seen }
    }

    /// The cells that can be seen from a cell.
    pub(super) fn from(&self, cell: Cell) -> Option<Cell> {
        let number = self.seen[self.grid.place(cell)?]?;
        Some(self.wanted[number as usize])
    }
}

/// One of the cells in each square of so many cells a side.
pub(super) fn sparse(cells: &[Cell], side: i32) -> Vec<Cell> {
    let mut squares = BTreeSet::new();
    let is_first = |cell: &&Cell| squares.insert((cell.column.div_euclid(side), cell.row.div_euclid(side)));
    cells.iter().filter(is_first).copied().collect()
}
