//! A grid of few large convex cells, and ways that run straight on through them: Fig. 6.6.
//!
//! The notes show such a grid and cite an algorithm for it, which they leave out as too complex. Here the free
//! cells of a fine [`Grid`] are merged into rectangles. Two of them are neighbours if they share a part of a side:
//! a door. Dijkstra's algorithm finds a path from cell to cell, and within these cells the path is pulled tight,
//! which is the notes' last step: changes of direction within cells, so that the path becomes as short as its cells
//! allow.
//!
//! Deviations: a slanted wall has stairs of small cells along it, as all cells are rectangles along the axes. The
//! nodes of Dijkstra's algorithm are the ends and the middles of the doors, and an edge is the straight line
//! between two of them in the same cell. With one node a cell, as in the notes, how far it is across a large cell
//! does not depend on where one enters and leaves: in an office, ways then were up to a third longer than need be.

use baudbot_geometry::grid::{Cell, Rectangle};
use baudbot_geometry::{Bounds, Point, Segment};

use super::crossing::Crossing;
use super::funnel::tighten;
use super::grid::Grid;
use super::plan::{End, PlanError};
use super::rectangles::merge;

/// The free part of a [`Grid`], covered with convex cells.
#[derive(Clone, Debug, PartialEq)]
pub struct CellGrid {
    grid: Grid,
    cells: Vec<Bounds>,
    owners: Vec<Option<usize>>,
    doors: Vec<Vec<Door>>,
}

/// A passage from a cell to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Door {
    /// The cell behind it, by its place in [`CellGrid::cells`].
    pub to: usize,
    /// The side that both cells share, from its left end to its right one as one leaves.
    pub side: Segment,
}

/// A path through a [`CellGrid`].
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    /// The cells that it runs through, by their places in [`CellGrid::cells`].
    pub cells: Vec<usize>,
    /// A plain way through these cells: by their centres and the middles of the doors between them.
    pub by_centers: Vec<Point>,
    /// The shortest path from start to target within the cells: where it bends, and its ends.
    pub points: Vec<Point>,
    /// Length of the shortest path, in metres.
    pub length_m: f64,
}

impl CellGrid {
    /// Merges the free cells of a grid. What is free keeps the clearance that the grid was made with.
    pub fn new(grid: Grid) -> Self {
        let (rectangles, owners) = merge(&grid);
        let cells = rectangles.iter().map(|rectangle| bounds(&grid, rectangle)).collect();
        let mut doors = vec![Vec::new(); rectangles.len()];
        for (from, rectangle) in rectangles.iter().enumerate() {
            for (to, side) in sides(&grid, &owners, rectangle) {
                let back = Segment { start: side.end, end: side.start };
                doors[from].push(Door { to, side });
                doors[to].push(Door { to: from, side: back });
            }
        }
        Self { grid, cells, owners, doors }
    }

    /// The cells, as boxes; they touch and do not overlap.
    pub fn cells(&self) -> &[Bounds] {
        &self.cells
    }

    /// The doors of a cell, to all its neighbours.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn doors(&self, cell: usize) -> &[Door] {
        &self.doors[cell]
    }

    /// The cell that a point lies in; `None` if it is blocked or outside.
    pub fn cell_at(&self, point: Point) -> Option<usize> {
        self.owners[self.grid.number(self.grid.cell_at(point)?)]
    }

    /// A short way from point to point: the shortest within the cells that Dijkstra's algorithm finds.
    ///
    /// # Errors
    /// If an end is outside the grid or blocked, or no path leads from one to the other.
    pub fn route(&self, start: Point, target: Point) -> Result<Route, PlanError> {
        let (start_cell, from) = self.end(End::Start, start)?;
        let (target_cell, to) = self.end(End::Target, target)?;
        let cells = Crossing::new(self, [(from, start), (to, target)]).cells();
        let cells = cells.ok_or(PlanError::Unreachable { start: start_cell, target: target_cell })?;
        let doors: Vec<_> = cells.windows(2).filter_map(|pair| self.door(pair[0], pair[1])).collect();
        let points = tighten(start, &doors, target);
        let length_m = points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
        Ok(Route { by_centers: self.by_centers(start, &cells, &doors, target), cells, points, length_m })
    }

    fn by_centers(&self, start: Point, cells: &[usize], doors: &[Segment], target: Point) -> Vec<Point> {
        let mut path = vec![start];
        for (i, door) in doors.iter().enumerate() {
            path.push(middle(door));
            if i + 1 < doors.len() {
                path.push(self.cells[cells[i + 1]].center());
            }
        }
        path.push(target);
        path
    }

    /// The fine cell and the cell that an end of a path lies in.
    fn end(&self, end: End, point: Point) -> Result<(Cell, usize), PlanError> {
        let cell = self.grid.cell_at(point).ok_or(PlanError::OffMap { end, point })?;
        let owner = self.owners[self.grid.number(cell)];
        Ok((cell, owner.ok_or(PlanError::Blocked { end, cell })?))
    }

    fn door(&self, from: usize, to: usize) -> Option<Segment> {
        self.doors[from].iter().find(|door| door.to == to).map(|door| door.side)
    }
}

/// The point half-way along.
pub(super) fn middle(side: &Segment) -> Point {
    side.start + (side.end - side.start) * 0.5
}

/// A rectangle of fine cells as a box. Neighbours compute a common corner from the same cell, so it has the same
/// bits.
fn bounds(grid: &Grid, rectangle: &Rectangle) -> Bounds {
    Bounds { min: grid.corner(rectangle.first), max: grid.corner(rectangle.last().offset(1, 1)) }
}

/// The doors through the right and the upper side of a rectangle.
fn sides(grid: &Grid, owners: &[Option<usize>], rectangle: &Rectangle) -> Vec<(usize, Segment)> {
    let (least, Cell { column, row }) = (rectangle.first, rectangle.last().offset(1, 1));
    let extent = grid.extent();
    let owner = |cell: Cell| owners[grid.number(cell)].filter(|_| grid.is_free(cell));
    let mut sides = Vec::new();
    if column < extent.columns {
        let rows = runs(least.row..row, |row| owner(Cell { column, row }));
        sides.extend(rows.into_iter().map(|(to, from_row, to_row)| {
            let (start, end) = (Cell { column, row: to_row }, Cell { column, row: from_row });
            (to, Segment { start: grid.corner(start), end: grid.corner(end) })
        }));
    }
    if row < extent.rows {
        let columns = runs(least.column..column, |column| owner(Cell { column, row }));
        sides.extend(columns.into_iter().map(|(to, from_column, to_column)| {
            let (start, end) = (Cell { column: from_column, row }, Cell { column: to_column, row });
            (to, Segment { start: grid.corner(start), end: grid.corner(end) })
        }));
    }
    sides
}

/// Places in a row that belong to the same owner: the owner, the first of them, and the one after the last.
fn runs(places: std::ops::Range<i32>, owner: impl Fn(i32) -> Option<usize>) -> Vec<(usize, i32, i32)> {
    let mut runs: Vec<(usize, i32, i32)> = Vec::new();
    for place in places {
        let Some(owner) = owner(place) else { continue };
        match runs.last_mut() {
            Some((last, _, end)) if *last == owner && *end == place => *end += 1,
            _ => runs.push((owner, place, place + 1)),
        }
    }
    runs
}

#[cfg(test)]
mod tests;
