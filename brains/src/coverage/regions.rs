//! A floor in regions that can be covered in rows.
//!
//! A line sweeps across the grid, column by column or row by row. As long as it meets the same stretches of free cells, each
//! of these is a region that grows. Where a stretch parts, or two join, regions end and others begin; and also where an end
//! of a stretch jumps, so that no strip is left beside a step in a wall (that is not in Choset and Pignon).

use baudbot_geometry::grid::{Cell, Rectangle};

use crate::planning::{Grid, Moves};

/// Stretches of free cells, line after line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Region {
    first_line: usize,
    /// The first and the last place on each line.
    stretches: Vec<(usize, usize)>,
}

/// Which way rows run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// Along the x axis.
    AlongX,
    /// Along the y axis.
    AlongY,
}

impl Rows {
    fn cell(self, line: usize, place: usize) -> Cell {
        match self {
            Self::AlongX => Cell { column: place as i32, row: line as i32 },
            Self::AlongY => Cell { column: line as i32, row: place as i32 },
        }
    }

    /// How many lines there are, and how many places on each.
    fn size(self, grid: &Grid) -> (usize, usize) {
        match self {
            Self::AlongX => (grid.rows(), grid.columns()),
            Self::AlongY => (grid.columns(), grid.rows()),
        }
    }
}

impl Region {
    /// The ends of rows that are at most `apart` cells from each other, from the first line to the last, both included.
    pub fn rows(&self, rows: Rows, apart: usize) -> Vec<[Cell; 2]> {
        let last = self.stretches.len() - 1;
        let gaps = last.div_ceil(apart.max(1));
        let line = |i: usize| (i * last + gaps / 2).checked_div(gaps).unwrap_or(0);
        let row = |i: usize| {
            let (from, to) = self.stretches[line(i)];
            [from, to].map(|place| rows.cell(self.first_line + line(i), place))
        };
        (0..=gaps).map(row).collect()
    }
}

/// The free cells of a grid in parts: from each cell of a part ways lead to all others of it, and to no others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parts {
    cells: Rectangle,
    /// Of each cell the part it belongs to, row by row.
    numbers: Vec<Option<u32>>,
}

impl Parts {
    /// Those of this grid.
    pub fn new(grid: &Grid) -> Self {
        let mut parts = Self { cells: grid.extent(), numbers: vec![None; grid.len()] };
        let mut number = 0;
        for cell in grid.cells().filter(|&cell| grid.is_free(cell)) {
            if parts.of(cell).is_none() {
                parts.fill(grid, cell, number);
                number += 1;
            }
        }
        parts
    }

    /// To which part a cell of the grid belongs; a blocked one to none.
    pub fn of(&self, cell: Cell) -> Option<u32> {
        self.numbers[self.cells.number(cell)?]
    }

    fn fill(&mut self, grid: &Grid, from: Cell, number: u32) {
        let mut open = vec![from];
        while let Some(cell) = open.pop() {
            if self.numbers[grid.number(cell)].replace(number).is_none() {
                open.extend(Moves::Four.neighbours(grid, cell).map(|(next, _)| next));
            }
        }
    }
}

/// The regions of the free cells. An end of a stretch that differs by more than `jump` cells from line to line begins
/// another region.
pub fn regions(grid: &Grid, rows: Rows, jump: usize) -> Vec<Region> {
    let (lines, _) = rows.size(grid);
    let (mut done, mut open): (Vec<Region>, Vec<Region>) = (Vec::new(), Vec::new());
    for line in 0..lines {
        let stretches = stretches(grid, rows, line);
        let mut next = Vec::new();
        for &stretch in &stretches {
            let region = match before(&open, &stretches, stretch, jump) {
                Some(i) => {
                    let mut region = open[i].clone();
                    region.stretches.push(stretch);
                    region
                }
                None => Region { first_line: line, stretches: vec![stretch] },
            };
            next.push(region);
        }
        // Those that do not go on.
        let goes_on = |old: &Region| next.iter().any(|new| new.starts_as(old));
        done.extend(open.into_iter().filter(|old| !goes_on(old)));
        open = next;
    }
    done.extend(open);
    done
}

impl Region {
    /// One of its cells.
    pub fn a_cell(&self, rows: Rows) -> Cell {
        rows.cell(self.first_line, self.stretches[0].0)
    }

    /// Whether this one is the other, a line later.
    fn starts_as(&self, old: &Self) -> bool {
        self.first_line == old.first_line && self.stretches.starts_with(&old.stretches)
    }

    fn last(&self) -> (usize, usize) {
        self.stretches[self.stretches.len() - 1]
    }
}

/// The region that goes on with this stretch of the next line, by its place; `None` if it is a new one.
fn before(
    open: &[Region],
    stretches: &[(usize, usize)],
    stretch: (usize, usize),
    jump: usize,
) -> Option<usize> {
    let touches = |a: (usize, usize), b: (usize, usize)| a.0 <= b.1 && b.0 <= a.1;
    let mut below = (0..open.len()).filter(|&i| touches(open[i].last(), stretch));
    let only = below.next().filter(|_| below.next().is_none())?;
    let last = open[only].last();
    let above = stretches.iter().filter(|other| touches(last, **other)).count();
    let is_smooth = last.0.abs_diff(stretch.0) <= jump && last.1.abs_diff(stretch.1) <= jump;
    (above == 1 && is_smooth).then_some(only)
}

/// The stretches of free cells on a line.
fn stretches(grid: &Grid, rows: Rows, line: usize) -> Vec<(usize, usize)> {
    let (_, places) = rows.size(grid);
    let mut found: Vec<(usize, usize)> = Vec::new();
    for place in (0..places).filter(|&place| grid.is_free(rows.cell(line, place))) {
        match found.last_mut() {
            Some((_, last)) if *last + 1 == place => *last = place,
            _ => found.push((place, place)),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(text: &str) -> Grid {
        Grid::from_text(text).unwrap().grid
    }

    /// Of each region its first line and how many lines it has.
    fn lines(text: &str, jump: usize) -> Vec<(usize, usize)> {
        let found = regions(&grid(text), Rows::AlongX, jump);
        found.iter().map(|region| (region.first_line, region.stretches.len())).collect()
    }

    #[test]
    fn a_floor_with_a_pillar_is_four_regions() {
        let text = "......\n......\n..##..\n..##..\n......";
        let mut found = lines(text, 9);
        found.sort_unstable();
        assert_eq!(found, [(0, 2), (2, 2), (2, 2), (4, 1)]);
    }

    #[test]
    fn each_free_cell_is_in_one_region() {
        let grid = grid("..#....\n.......\n#..##..\n...#...\n.#.....");
        for rows in [Rows::AlongX, Rows::AlongY] {
            let mut count = vec![0; 35];
            for region in regions(&grid, rows, 1) {
                for (i, &(from, to)) in region.stretches.iter().enumerate() {
                    for place in from..=to {
                        let cell = rows.cell(region.first_line + i, place);
                        count[grid.number(cell)] += 1;
                    }
                }
            }
            let expected: Vec<_> = grid.cells().map(|cell| i32::from(grid.is_free(cell))).collect();
            assert_eq!(count, expected, "{rows:?}");
        }
    }

    #[test]
    fn a_step_in_a_wall_begins_another_region() {
        let text = "...###\n...###\n......\n......";
        assert_eq!(lines(text, 3), [(0, 4)]);
        assert_eq!(lines(text, 2), [(0, 2), (2, 2)]);
    }

    #[test]
    fn rows_are_as_far_apart_as_they_may_be_and_begin_and_end_at_the_sides() {
        let region = Region { first_line: 5, stretches: vec![(2, 8); 8] };
        let lines = |apart| -> Vec<_> {
            region.rows(Rows::AlongY, apart).iter().map(|[from, _]| from.column).collect()
        };
        assert_eq!(lines(3), [5, 7, 10, 12]);
        assert_eq!(lines(7), [5, 12]);
        assert_eq!(lines(1).len(), 8);
        let thin = Region { first_line: 0, stretches: vec![(2, 8)] };
        let row = thin.rows(Rows::AlongX, 3);
        assert_eq!(row, [[Cell { column: 2, row: 0 }, Cell { column: 8, row: 0 }]]);
    }

    #[test]
    fn what_no_way_leads_to_is_another_part() {
        let grid = grid("..#.\n..##\n..#.");
        let parts = Parts::new(&grid);
        let found: Vec<_> = grid.cells().map(|cell| parts.of(cell)).collect();
        let (left, below, above) = (Some(0), Some(1), Some(2));
        assert_eq!(found[..4], [left, left, None, below]);
        assert_eq!(found[4..8], [left, left, None, None]);
        assert_eq!(found[8..], [left, left, None, above]);
    }
}
