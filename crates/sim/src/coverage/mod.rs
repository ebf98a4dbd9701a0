//! The covered part of an arena's floor: the area coverage and the sensory area coverage of Section 6.1 of Wahde's
//! "Introduction to Autonomous Robots".
//!
//! ```text
//! area coverage         = covered cells / free cells
//! sensory area coverage = sensed cells  / free cells
//! ```
//!
//! The floor is divided into square cells once ([`Floor`]). A cell is free if a way leads from a robot's
//! start to its centre; it is covered once its centre was under a robot's body, and sensed once a ray ran
//! through it.
//!
//! *Deviations.*
//!
//! - Free are the cells whose centre a point could reach. A body cannot press its rim into a corner, so a
//!   fraction of 1 may be out of its reach, the more so the larger it is.
//! - A cell is covered as a whole or not at all. Against the true area the error is of the order of the
//!   covered area's outline times half a cell's side.
//! - A ray senses every cell that it touches, though it has no width; a fan of few rays senses more than it
//!   would with smaller cells.

mod bits;
mod fill;
mod floor;

use alloc::vec::Vec;

use baudbot_geometry::{Circle, Point, Segment};
use serde::{Deserialize, Serialize};

use bits::Bits;
pub use floor::{Floor, FloorError};

/// The cells of a [`Floor`] that were covered, and those that were sensed. Both only ever become more.
///
/// It serialises small: as the lengths of runs of equal cells. The floor is derived from the scenario and is
/// not part of it; all calls on one coverage must pass the same floor. With another one nothing panics, but
/// the numbers mean nothing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Coverage {
    covered: Bits,
    sensed: Bits,
}

impl Coverage {
    /// Nothing is covered yet, and nothing sensed.
    #[must_use]
    pub fn new(floor: &Floor) -> Self {
        let none = Bits::new(floor.grid().cells.count());
        Self { covered: none.clone(), sensed: none }
    }

    /// The bytes that it has on the heap.
    pub(crate) fn heap_bytes(&self) -> usize {
        self.covered.heap_bytes() + self.sensed.heap_bytes()
    }

    /// Whether the coverage is of this floor: of as many cells, none of them one that cannot be reached.
    pub(crate) fn is_of(&self, floor: &Floor) -> bool {
        let none = Bits::new(floor.grid().cells.count());
        let is_in = |cells: &Bits| cells.words() == none.words() && cells.is_within(floor.free());
        is_in(&self.covered) && is_in(&self.sensed)
    }

    /// Covers the free cells whose centre is strictly inside the disc.
    ///
    /// It costs a few operations for each row of cells that the disc reaches.
    pub fn cover_disc(&mut self, floor: &Floor, disc: &Circle) {
        floor.grid().in_disc(disc, |cells| self.covered.insert_range(cells, floor.free()));
    }

    /// Covers the free cells whose centre is strictly inside the disc somewhere on its straight way from
    /// `before` to `after`, ends included, so that a fast robot leaves no gaps. The radius is that of
    /// `after`; walls on the way are not looked for. Area coverage (§6.1).
    pub fn cover_swept(&mut self, floor: &Floor, before: &Circle, after: &Circle) {
        let way = Segment { start: before.center, end: after.center };
        floor.grid().in_swept(&way, after.radius, |cells| self.covered.insert_range(cells, floor.free()));
    }

    /// Senses the free cells on the straight line from a sensor to what its ray meets.
    ///
    /// Half a nanometre at either end is left out: an obstacle often stands on the border of a cell, and what
    /// is behind it must not be sensed because of a rounding. Walls are not looked for. Sensory area coverage (§6.1).
    pub fn sense_ray(&mut self, floor: &Floor, from: Point, to: Point) {
        floor.grid().visit_line(from, to, HAIR_M, |number| self.sensed.insert_allowed(number, floor.free()));
    }

    /// The part of the free cells that is covered, in [0, 1].
    #[must_use]
    pub fn floor_fraction(&self, floor: &Floor) -> f64 {
        self.covered_cells() as f64 / floor.free_cells() as f64
    }

    /// The part of the free cells that is sensed, in [0, 1].
    #[must_use]
    pub fn sensed_fraction(&self, floor: &Floor) -> f64 {
        self.sensed_cells() as f64 / floor.free_cells() as f64
    }

    /// The number of covered cells.
    #[must_use]
    pub fn covered_cells(&self) -> usize {
        self.covered.count()
    }

    /// The number of sensed cells.
    #[must_use]
    pub fn sensed_cells(&self) -> usize {
        self.sensed.count()
    }

    /// The covered cells as lengths of runs, counted as in [`Floor::free_runs`].
    #[must_use]
    pub fn covered_runs(&self, floor: &Floor) -> Vec<u32> {
        self.covered.runs(floor.grid().cells.count())
    }

    /// The sensed cells as lengths of runs, counted as in [`Floor::free_runs`].
    #[must_use]
    pub fn sensed_runs(&self, floor: &Floor) -> Vec<u32> {
        self.sensed.runs(floor.grid().cells.count())
    }

    /// Whether the cell is covered. There is none beyond the grid.
    #[must_use]
    pub fn is_covered(&self, floor: &Floor, column: usize, row: usize) -> bool {
        floor.number(column, row).is_some_and(|number| self.covered.contains(number))
    }

    /// Whether the cell is sensed. There is none beyond the grid.
    #[must_use]
    pub fn is_sensed(&self, floor: &Floor, column: usize, row: usize) -> bool {
        floor.number(column, row).is_some_and(|number| self.sensed.contains(number))
    }
}

/// The part of a ray that is left out at either end: more than roundings, less than anything of interest.
const HAIR_M: f64 = 0.5e-9;
