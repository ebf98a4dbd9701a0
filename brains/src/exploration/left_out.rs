//! The places that an exploration leaves out, and how it reports them.

use std::collections::BTreeSet;
use std::fmt;

use baudbot_geometry::math;

use crate::mapping::disc::Disc;
use crate::mapping::frontier::{Dark, groups};
use crate::mapping::{Cell, Occupancy};

/// The areas that a finished robot knows of and has not seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LeftOut {
    /// Openings through which it saw a part of what is behind, and through which it does not fit.
    pub openings: usize,
    /// The width that they would need, in metres.
    pub width_m: f64,
    /// Openings in which something is that the laser overlooks.
    pub barred: usize,
    /// Places at which it looked from near, and which its laser does not show.
    pub unseen: usize,
    /// Places to which it did not get, though there seemed to be a way.
    pub missed: usize,
}

impl LeftOut {
    /// Whether it is nothing.
    #[must_use]
    pub const fn is_nothing(&self) -> bool {
        self.openings == 0 && self.barred == 0 && self.unseen == 0 && self.missed == 0
    }
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_nothing() {
            return f.write_str("has seen all");
        }
        let some = |count: usize, one: &str| match count {
            1 => format!("1 {one}"),
            _ => format!("{count} {one}s"),
        };
        let parts = [
            (
                self.openings,
                format!("{} narrower than {:.2} m", some(self.openings, "opening"), self.width_m),
            ),
            (self.barred, format!("{} with something low in the way", some(self.barred, "opening"))),
            (self.unseen, format!("{} that its laser does not show", some(self.unseen, "place"))),
            (self.missed, format!("{} to which it did not get in time", some(self.missed, "place"))),
        ];
        let parts: Vec<_> = parts.into_iter().filter(|(count, _)| *count > 0).map(|(_, text)| text).collect();
        write!(f, "has seen all but {}", parts.join(", "))
    }
}

/// The knowledge of the floor once there is nowhere to go any more.
pub(super) struct Rest<'a> {
    pub(super) grid: &'a Occupancy,
    pub(super) dark: &'a Dark<'a>,
    /// The cells to which there is a path, and those to which there were one if proximity had found nothing.
    pub(super) reached: &'a [Cell],
    pub(super) reached_but: &'a [Cell],
    /// The edge of the dark, without cells that were viewed in vain.
    pub(super) wanted: &'a [Cell],
    pub(super) given_up: &'a BTreeSet<Cell>,
    /// Cells to which it did not get, with those beside them.
    pub(super) missed: &'a BTreeSet<Cell>,
    pub(super) half_width_m: f64,
}

impl Rest<'_> {
    /// The areas that are left out.
    pub(super) fn left_out(&self) -> LeftOut {
        let [covered, covered_but] = [self.reached, self.reached_but].map(|reached| self.covered(reached));
        let is_in = |covered: &[bool], cell| self.grid.place(cell).is_some_and(|place| covered[place]);
        let is_covered = |cell: Cell| is_in(&covered, cell);
        let touches = |group: &[Cell], covered: &[bool]| {
            group.iter().flat_map(|cell| cell.sides()).any(|cell| is_in(covered, cell))
        };
        let (near, far): (Vec<_>, Vec<_>) =
            groups(&self.dark.edge(|_| false)).into_iter().partition(|group| touches(group, &covered));
        let is_missed = |group: &&Vec<Cell>| group.iter().any(|cell| self.missed.contains(cell));
        let missed = near.iter().chain(&far).filter(is_missed).count();
        let is_in_vain = |group: &&Vec<Cell>| group.iter().any(|cell| self.given_up.contains(cell));
        let near = near.iter().filter(|group| !is_missed(group));
        let unseen = near.filter(is_in_vain).filter(|group| self.is_wide(group)).count();
        // An area that would be open if proximity had found nothing is barred; any other is narrow.
        let could_reach = far.iter().filter(|group| touches(group, &covered_but)).flatten();
        let barred = self.beyond(could_reach, is_covered);
        let is_narrow = |cell: &&Cell| !cell.sides().any(|cell| barred.contains(&cell));
        let narrow = self.beyond(self.wanted.iter().filter(is_narrow), is_covered);
        let [barred, openings] = [barred, narrow].map(|cells| self.mouths(&cells, is_covered));
        let width_m = least_width_m(self.half_width_m, self.grid.cell_m());
        LeftOut { openings, width_m, barred, unseen, missed }
    }

    /// Whether the robot could go through this part of the edge if nothing is there.
    fn is_wide(&self, edge: &[Cell]) -> bool {
        let wide = |of: fn(&Cell) -> i32| {
            let (least, most) = (edge.iter().map(of).min(), edge.iter().map(of).max());
            f64::from(most.zip(least).map_or(0, |(most, least)| most - least + 1)) * self.grid.cell_m()
        };
        math::hypot(wide(|cell| cell.column), wide(|cell| cell.row)) >= 2.0 * self.half_width_m
    }

    /// Whether each cell is under a robot at one of these places.
    fn covered(&self, reached: &[Cell]) -> Vec<bool> {
        let [columns, rows] = self.grid.size();
        let mut covered = vec![false; columns * rows];
        let body = Disc::new(self.half_width_m / self.grid.cell_m());
        for cell in reached {
            self.grid.places(*cell, &body).for_each(|places| covered[places].fill(true));
        }
        covered
    }

    /// All that can be seen around these cells of the edge of the dark, as far as where the robot can be.
    fn beyond<'a>(
        &self,
        edge: impl Iterator<Item = &'a Cell>,
        is_covered: impl Fn(Cell) -> bool,
    ) -> BTreeSet<Cell> {
        let is_beyond = |cell: &Cell| self.is_clear(*cell) && !is_covered(*cell);
        let mut found = BTreeSet::new();
        let mut waiting: Vec<_> = edge.flat_map(|cell| cell.sides()).filter(is_beyond).collect();
        while let Some(cell) = waiting.pop() {
            if found.insert(cell) {
                waiting.extend(cell.sides().filter(is_beyond));
            }
        }
        found
    }

    /// The number of openings to these cells from places where the robot can be.
    fn mouths(&self, cells: &BTreeSet<Cell>, is_covered: impl Fn(Cell) -> bool) -> usize {
        let is_mouth = |cell: &Cell| cell.sides().any(|beside| is_covered(beside) && self.is_clear(beside));
        groups(&cells.iter().copied().filter(is_mouth).collect::<Vec<_>>()).len()
    }

    fn is_clear(&self, cell: Cell) -> bool {
        self.grid.place(cell).is_some_and(|place| self.dark.is_clear_at(place))
    }
}

/// The least width of an opening through which a path with this half width leads for sure, in metres.
pub(super) fn least_width_m(half_width_m: f64, cell_m: f64) -> f64 {
    2.0 * half_width_m + cell_m
}
