//! A floor in regions that can be covered in rows.
//!
//! A line sweeps across the grid, column by column or row by row. As long as it meets the same stretches of free cells, each
//! of these is a region that grows. Where a stretch parts, or two join, regions end and others begin; and also where an end
//! of a stretch jumps, so that no strip is left beside a step in a wall (that is not in Choset and Pignon).

use baudbot_geometry::grid::Cell;

use crate::planning::Grid;

/// Stretches of free cells, line after line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Region {
    first_line: usize,
    /// One on each line.
    stretches: Vec<Stretch>,
}

/// The direction of rows.
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
    /// Row by row the stretches of free cells, each with the part that it belongs to.
    rows: Vec<Vec<(Stretch, u32)>>,
}

impl Parts {
    /// The `Parts` of this grid.
    pub fn new(grid: &Grid) -> Self {
        let rows = stretches(grid, Rows::AlongX);
        let mut joined = Joined::default();
        let mut below: Option<&Vec<Stretch>> = None;
        for row in &rows {
            joined.add(below.map_or(&[], Vec::as_slice), row);
            below = Some(row);
        }
        let mut parts = joined.parts().into_iter();
        let with_part = |row: Vec<Stretch>| row.into_iter().zip(parts.by_ref()).collect();
        Self { rows: rows.into_iter().map(with_part).collect() }
    }

    /// The part of a cell of the grid; a blocked one has none.
    pub fn of(&self, cell: Cell) -> Option<u32> {
        let (row, place) = (usize::try_from(cell.row).ok()?, usize::try_from(cell.column).ok()?);
        let mut stretches = self.rows.get(row)?.iter();
        stretches.find(|((from, to), _)| (*from..=*to).contains(&place)).map(|(_, part)| *part)
    }
}

/// Stretches, numbered row by row, and which of them touch: each leads to one with a lesser number, or is the first of a part.
#[derive(Default)]
struct Joined {
    leads_to: Vec<usize>,
}

impl Joined {
    /// Adds the stretches of a row, above those of the row that was added last.
    fn add(&mut self, below: &[Stretch], row: &[Stretch]) {
        let first_above = self.leads_to.len();
        let first_below = first_above - below.len();
        self.leads_to.extend(first_above..first_above + row.len());
        let (mut i, mut j) = (0, 0);
        while let (Some(&under), Some(&over)) = (below.get(i), row.get(j)) {
            if touch(under, over) {
                self.join(first_below + i, first_above + j);
            }
            if under.1 < over.1 { i += 1 } else { j += 1 }
        }
    }

    fn first(&mut self, mut stretch: usize) -> usize {
        while self.leads_to[stretch] != stretch {
            // Halves the way for those who come after.
            self.leads_to[stretch] = self.leads_to[self.leads_to[stretch]];
            stretch = self.leads_to[stretch];
        }
        stretch
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.first(a), self.first(b));
        self.leads_to[a.max(b)] = a.min(b);
    }

    /// The part of each stretch. They are numbered in the order of their first stretches.
    fn parts(&self) -> Vec<u32> {
        let (mut parts, mut count) = (Vec::with_capacity(self.leads_to.len()), 0);
        for (stretch, &before) in self.leads_to.iter().enumerate() {
            let is_first = before == stretch;
            parts.push(if is_first { count } else { parts[before] });
            count += u32::from(is_first);
        }
        parts
    }
}

/// The regions of the free cells. An end of a stretch that differs by more than `jump` cells from line to line begins
/// another region.
pub fn regions(grid: &Grid, rows: Rows, jump: usize) -> Vec<Region> {
    let (mut done, mut open): (Vec<Region>, Vec<Region>) = (Vec::new(), Vec::new());
    for (line, stretches) in stretches(grid, rows).into_iter().enumerate() {
        let before: Vec<_> =
            stretches.iter().map(|&stretch| before(&open, &stretches, stretch, jump)).collect();
        // At most one stretch continues a region.
        let mut old: Vec<_> = open.into_iter().map(Some).collect();
        open = Vec::with_capacity(stretches.len());
        for (&stretch, before) in stretches.iter().zip(before) {
            let region = before.and_then(|region| old[region].take());
            let mut region = region.unwrap_or(Region { first_line: line, stretches: Vec::new() });
            region.stretches.push(stretch);
            open.push(region);
        }
        done.extend(old.into_iter().flatten());
    }
    done.extend(open);
    done
}

impl Region {
    /// One of its cells.
    pub fn a_cell(&self, rows: Rows) -> Cell {
        rows.cell(self.first_line, self.stretches[0].0)
    }

    fn last(&self) -> Stretch {
        self.stretches[self.stretches.len() - 1]
    }
}

/// The region that goes on with this stretch of the next line, by its place; `None` if it is a new one.
fn before(open: &[Region], stretches: &[Stretch], stretch: Stretch, jump: usize) -> Option<usize> {
    let mut below = (0..open.len()).filter(|&i| touch(open[i].last(), stretch));
    let only = below.next().filter(|_| below.next().is_none())?;
    let last = open[only].last();
    let above = stretches.iter().filter(|other| touch(last, **other)).count();
    let is_smooth = last.0.abs_diff(stretch.0) <= jump && last.1.abs_diff(stretch.1) <= jump;
    (above == 1 && is_smooth).then_some(only)
}

/// Free cells side by side on a line: the first place and the last.
type Stretch = (usize, usize);

/// Whether stretches of two lines that are next to each other have places in common.
fn touch(a: Stretch, b: Stretch) -> bool {
    a.0 <= b.1 && b.0 <= a.1
}

/// The stretches of free cells on each line.
fn stretches(grid: &Grid, rows: Rows) -> Vec<Vec<Stretch>> {
    let lines = grid.blocked().chunks(grid.columns());
    match rows {
        Rows::AlongX => lines.map(along).collect(),
        Rows::AlongY => across(lines, grid.columns()),
    }
}

/// The stretches of a row.
fn along(blocked: &[bool]) -> Vec<Stretch> {
    let (mut found, mut at) = (Vec::new(), 0);
    let next = |from: usize, what: bool| blocked[from..].iter().position(|&blocked| blocked == what);
    while let Some(free) = next(at, false) {
        let first = at + free;
        at = next(first, true).map_or(blocked.len(), |cells| first + cells);
        found.push((first, at - 1));
    }
    found
}

/// The stretches of each column, from the rows.
fn across<'a>(rows: impl Iterator<Item = &'a [bool]>, columns: usize) -> Vec<Vec<Stretch>> {
    let mut found: Vec<Vec<Stretch>> = vec![Vec::new(); columns];
    let before_all = vec![true; columns];
    let (mut before, mut count) = (before_all.as_slice(), 0);
    for (place, row) in rows.enumerate() {
        for (column, (was_blocked, is_blocked)) in before.iter().zip(row).enumerate() {
            if was_blocked != is_blocked {
                turn(&mut found[column], place, *is_blocked);
            }
        }
        (before, count) = (row, place + 1);
    }
    for (stretches, _) in found.iter_mut().zip(before).filter(|(_, is_blocked)| !**is_blocked) {
        turn(stretches, count, true);
    }
    found
}

/// Notes that a column becomes blocked, or free, at this place.
fn turn(stretches: &mut Vec<Stretch>, place: usize, is_blocked: bool) {
    match stretches.last_mut() {
        Some((_, last)) if is_blocked => *last = place - 1,
        _ => stretches.push((place, place)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::Moves;

    fn grid(text: &str) -> Grid {
        Grid::from_text(text).unwrap().grid
    }

    /// The first line of each region, and the number of its lines.
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

    /// A grid with so many blocked cells in a hundred.
    fn random_grid(chance: &mut crate::Chance, percent: u32) -> Grid {
        let [columns, rows] = [(); 2].map(|()| 1 + (chance.uniform() * 20.0) as usize);
        let mut grid = Grid::new(columns, rows, 1.0, baudbot_geometry::Point::origin()).unwrap();
        for cell in grid.extent().cells() {
            if chance.uniform() * 100.0 < f64::from(percent) {
                grid.block(cell);
            }
        }
        grid
    }

    #[test]
    fn parts_are_those_that_a_search_from_cell_to_cell_fills() {
        let mut chance = crate::Chance::new(1, "parts");
        for percent in [0, 10, 30, 40, 50, 70, 100].repeat(20) {
            let grid = random_grid(&mut chance, percent);
            let mut numbers = vec![None; grid.len()];
            let mut number = 0;
            for cell in grid.cells().filter(|&cell| grid.is_free(cell)) {
                let (mut open, before) = (vec![cell], number);
                while let Some(cell) = open.pop() {
                    if numbers[grid.number(cell)].is_none() {
                        numbers[grid.number(cell)] = Some(before);
                        number = before + 1;
                        open.extend(Moves::Four.neighbours(&grid, cell).map(|(next, _)| next));
                    }
                }
            }
            let parts = Parts::new(&grid);
            let found: Vec<_> = grid.cells().map(|cell| parts.of(cell)).collect();
            assert_eq!(found, numbers, "{grid:?}");
        }
    }

    #[test]
    fn beyond_the_grid_is_no_part() {
        let parts = Parts::new(&grid("..\n.."));
        for (column, row) in [(-1, 0), (0, -1), (2, 0), (0, 2)] {
            assert_eq!(parts.of(Cell { column, row }), None);
        }
    }
}
