//! Which cells are free: those that a point can reach from the robots' starts, cell by cell.
//!
//! Nothing looks whether a cell's centre is inside a solid polygon, but for the first cells: to get into a
//! polygon, a step would have to cross its outline. Pillars have no outline of segments, so their cells are
//! taken out first.
//!
//! Wherever a rounding could matter, at a corner that two walls share or at a wall that runs through the
//! centres of cells, a step that comes as near as a millionth of a cell's side to a wall is taken to cross
//! it. So no path leaks through a wall; a centre on a wall is on neither side of it, and not free.

use alloc::vec::Vec;

use baudbot_geometry::{Circle, Point, Segment, Shape, math, polygon};

use super::bits::Bits;
use super::grid::{Grid, MARGIN};
use crate::arena::Arena;

/// The cells that can be reached.
pub(super) fn free(arena: &Arena, grid: &Grid, starts: &[Point]) -> Bits {
    let barriers = Barriers::new(arena, grid);
    let mut found = Bits::new(grid.cells());
    let mut open = Vec::new();
    let mut find = |open: &mut Vec<(usize, usize)>, column, row| {
        let cell = grid.cell(column, row).filter(|&cell| !barriers.pillars.contains(cell));
        if cell.is_some_and(|cell| found.insert(cell)) {
            open.push((column, row));
        }
    };
    for &start in starts {
        for (column, row) in first_cells(arena, grid, start) {
            find(&mut open, column, row);
        }
    }
    while let Some((column, row)) = open.pop() {
        for next in barriers.steps(grid, column, row).into_iter().flatten() {
            find(&mut open, next.0, next.1);
        }
    }
    found
}

/// The cell that a robot starts in; if something stands between the robot and that cell's centre, those of
/// the eight around it to which the way is free.
fn first_cells(arena: &Arena, grid: &Grid, start: Point) -> Vec<(usize, usize)> {
    let place = grid.grid_from_world(start);
    let (column, row) = (math::floor(place.x), math::floor(place.y));
    let in_reach = |dx: f64, dy: f64| {
        let (x, y) = (column + dx, row + dy);
        let in_grid = x >= 0.0 && y >= 0.0 && x < grid.columns as f64 && y < grid.rows as f64;
        let cell = in_grid.then_some((x as usize, y as usize));
        cell.filter(|&(column, row)| is_in_sight(arena, grid, start, grid.center(column, row)))
    };
    if let Some(own) = in_reach(0.0, 0.0) {
        return [own].into();
    }
    let around = [-1.0, 0.0, 1.0].map(|dy| [-1.0, 0.0, 1.0].map(|dx| in_reach(dx, dy)));
    around.into_iter().flatten().flatten().collect()
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

/// What stands between the cells.
struct Barriers {
    /// The cells whose centre is in a pillar.
    pillars: Bits,
    /// The cells with a wall between their centre and that of the next one in the row.
    right: Bits,
    /// The cells with a wall between their centre and that of the one above.
    above: Bits,
}

impl Barriers {
    fn new(arena: &Arena, grid: &Grid) -> Self {
        let none = || Bits::new(grid.cells());
        let mut barriers = Self { pillars: none(), right: none(), above: none() };
        let all = Bits::full(grid.cells());
        for circle in arena.index().circles() {
            grid.in_disc(circle, |cells| barriers.pillars.insert_range(cells, &all));
        }
        for wall in arena.index().segments() {
            barriers.add(grid, wall);
        }
        barriers
    }

    fn add(&mut self, grid: &Grid, wall: &Segment) {
        let wall = in_grid(grid, wall);
        let blocks = |column, row, rightwards| {
            let cell = grid.cell(column, row)?;
            meets(&wall, &step(column, row, rightwards)).then_some(cell)
        };
        // A wall meets a step in one of the two cells that the step joins.
        grid.along(&wall, |column, row| {
            for column in [Some(column), column.checked_sub(1)].into_iter().flatten() {
                if let Some(cell) = blocks(column, row, true) {
                    self.right.insert(cell);
                }
            }
            for row in [Some(row), row.checked_sub(1)].into_iter().flatten() {
                if let Some(cell) = blocks(column, row, false) {
                    self.above.insert(cell);
                }
            }
        });
    }

    /// Where one can go from a cell; some of it may be beyond the grid.
    fn steps(&self, grid: &Grid, column: usize, row: usize) -> [Option<(usize, usize)>; 4] {
        let is_open = |walls: &Bits, column, row| grid.cell(column, row).is_some_and(|c| !walls.contains(c));
        let left = column.checked_sub(1).filter(|&left| is_open(&self.right, left, row));
        let below = row.checked_sub(1).filter(|&below| is_open(&self.above, column, below));
        [
            is_open(&self.right, column, row).then_some((column + 1, row)),
            is_open(&self.above, column, row).then_some((column, row + 1)),
            left.map(|left| (left, row)),
            below.map(|below| (column, below)),
        ]
    }
}

/// From a cell's centre to that of the cell on its right, or else of the one above. In the grid frame.
fn step(column: usize, row: usize, rightwards: bool) -> Segment {
    let start = Point::new(column as f64 + 0.5, row as f64 + 0.5);
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
