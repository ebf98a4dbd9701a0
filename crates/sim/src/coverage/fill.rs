//! The free cells: those that a point can reach from the robots' starts, cell by cell.
//!
//! Nothing looks whether a cell's centre is inside a solid polygon, but for the first cells: to get into a
//! polygon, a step would have to cross its outline. Pillars have no outline of segments, so their cells are
//! taken out first.
//!
//! Wherever a rounding could matter, at a corner that two walls share or at a wall that runs through the
//! centres of cells, a step that comes as near as a millionth of a cell's side to a wall is taken to cross
//! it. So no path leaks through a wall; a centre on a wall is on neither side of it, and not free.

use alloc::vec;
use alloc::vec::Vec;
use core::mem;

use baudbot_geometry::grid::{Cell, Grid, MARGIN};
use baudbot_geometry::{Circle, Point, Segment, Shape, polygon};

use super::bits::Bits;
use crate::arena::Arena;

/// The cells that can be reached.
pub(super) fn free(arena: &Arena, grid: &Grid, starts: &[Point]) -> Bits {
    let mut barriers = Barriers::new(arena, grid);
    let mut found = Bits::new(grid.cells.count());
    let mut open = Vec::new();
    for &start in starts {
        let first = first_cells(arena, grid, start).into_iter().filter_map(|cell| grid.cells.number(cell));
        first.for_each(|number| barriers.enter(number, &mut open));
    }
    while let Some(number) = open.pop() {
        found.insert(number);
        barriers.enter_beside(number, &mut open);
    }
    found
}

/// The cell that a robot starts in; if something stands between the robot and that cell's centre, those of
/// the eight around it to which the way is free.
fn first_cells(arena: &Arena, grid: &Grid, start: Point) -> Vec<Cell> {
    let own = grid.cell_at(start);
    let in_reach =
        |cell: &Cell| grid.cells.contains(*cell) && is_in_sight(arena, grid, start, grid.center(*cell));
    if in_reach(&own) {
        return [own].into();
    }
    let around = (-1..=1).flat_map(|row| (-1..=1).map(move |column| own.offset(column, row)));
    around.filter(in_reach).collect()
}

/// Whether neither a wall nor a pillar is between the start and the centre, which is in no solid polygon.
fn is_in_sight(arena: &Arena, grid: &Grid, start: Point, center: Point) -> bool {
    let line = Segment { start, end: center };
    let step = in_grid(grid, &line);
    // Twice as large as it need be, and a cell more: walls within the margin are among those visited.
    let around =
        Circle { center: start + (center - start) * 0.5, radius: (center - start).norm() + grid.cell_m };
    let mut free = true;
    arena.index().near(&around, |shape| {
        let is_between = match shape {
            Shape::Segment(i) => meets(&in_grid(grid, &arena.index().segments()[i]), &step),
            Shape::Circle(i) => arena.index().circles()[i].overlaps_segment(&line),
        };
        free &= !is_between;
    });
    free && !arena.polygons().iter().any(|shape| shape.solid && polygon::contains(&shape.points, center))
}

/// The barriers between the cells, which are known by their numbers.
struct Barriers {
    columns: usize,
    cells: Vec<Sides>,
}

#[derive(Clone, Copy, Default)]
struct Sides {
    /// A wall is between its centre and that of the next one in the row, or there is none.
    right: bool,
    /// A wall is between its centre and that of the one above, or there is none.
    above: bool,
    /// The cell's centre is in a pillar, or the cell has been entered.
    closed: bool,
}

impl Barriers {
    fn new(arena: &Arena, grid: &Grid) -> Self {
        let columns = grid.cells.columns as usize;
        let mut cells = vec![Sides::default(); grid.cells.count()];
        for row in cells.chunks_mut(columns) {
            row[columns - 1].right = true;
        }
        for cell in cells.iter_mut().rev().take(columns) {
            cell.above = true;
        }
        for circle in arena.index().circles() {
            grid.in_disc(circle, |range| cells[range].iter_mut().for_each(|cell| cell.closed = true));
        }
        let mut barriers = Self { columns, cells };
        for wall in arena.index().segments() {
            barriers.add(grid, wall);
        }
        barriers
    }

    fn add(&mut self, grid: &Grid, wall: &Segment) {
        let wall = in_grid(grid, wall);
        let blocks = |cell, rightwards| {
            let number = grid.cells.number(cell)?;
            meets(&wall, &step(cell, rightwards)).then_some(number)
        };
        // A wall meets a step in one of the two cells that the step joins.
        grid.along(&wall, |cell| {
            for number in [cell, cell.offset(-1, 0)].into_iter().filter_map(|cell| blocks(cell, true)) {
                self.cells[number].right = true;
            }
            for number in [cell, cell.offset(0, -1)].into_iter().filter_map(|cell| blocks(cell, false)) {
                self.cells[number].above = true;
            }
        });
    }

    /// Adds a cell to those that are open, unless it is closed; now it is.
    fn enter(&mut self, number: usize, open: &mut Vec<usize>) {
        if !mem::replace(&mut self.cells[number].closed, true) {
            open.push(number);
        }
    }

    /// Enters the cells to which one can go from a cell.
    fn enter_beside(&mut self, number: usize, open: &mut Vec<usize>) {
        let here = self.cells[number];
        if !here.right {
            self.enter(number + 1, open);
        }
        if !here.above {
            self.enter(number + self.columns, open);
        }
        if number > 0 && !self.cells[number - 1].right {
            self.enter(number - 1, open);
        }
        if number >= self.columns && !self.cells[number - self.columns].above {
            self.enter(number - self.columns, open);
        }
    }
}

/// The step from a cell's centre to that of the cell on its right, or else of the one above. In the grid frame.
fn step(cell: Cell, rightwards: bool) -> Segment {
    let start = Point::new(f64::from(cell.column) + 0.5, f64::from(cell.row) + 0.5);
    let end =
        if rightwards { Point::new(start.x + 1.0, start.y) } else { Point::new(start.x, start.y + 1.0) };
    Segment { start, end }
}

/// Whether a wall comes within the margin of a step; both are in the grid frame.
fn meets(wall: &Segment, step: &Segment) -> bool {
    let is_near = |segment: &Segment, point| segment.distance_squared(point) <= MARGIN * MARGIN;
    wall.touches(step)
        || [step.start, step.end].into_iter().any(|point| is_near(wall, point))
        || [wall.start, wall.end].into_iter().any(|point| is_near(step, point))
}

fn in_grid(grid: &Grid, segment: &Segment) -> Segment {
    Segment { start: grid.grid_from_world(segment.start), end: grid.grid_from_world(segment.end) }
}
