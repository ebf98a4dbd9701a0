//! The choice of the next region, and the way there and through it.
//!
//! Regions are taken as they come: the next one is that of which a corner is nearest along a path. That is not the shortest
//! way through all of them, which would be a travelling salesman's.
//!
//! All is planned in parts, as a step of a brain has little time.

use std::collections::VecDeque;
use std::task::{Poll, ready};

use baudbot_geometry::Point;

use super::regions::{Region, Rows};
use crate::navigation::{Floor, Path};
use crate::planning::{Cell, ThetaStar};

/// A path into a region and through it that is being planned.
#[derive(Clone, Debug)]
pub(super) struct Passage {
    from: Point,
    /// The places at which the regions can be entered, the nearest first as the crow flies.
    entries: Vec<Entry>,
    tried: usize,
    best: Option<Best>,
}

/// A corner of a region.
#[derive(Clone, Debug)]
struct Entry {
    straight_m: f64,
    region: usize,
    /// The rows from there on; of each first the near end.
    rows: Vec<[Point; 2]>,
}

/// The entry that is nearest of those that were tried.
#[derive(Clone, Debug)]
struct Best {
    region: usize,
    length_m: f64,
    /// The path so far.
    points: Vec<Point>,
    /// Rows that it does not have yet, in the direction in which they are driven.
    rows: VecDeque<[Point; 2]>,
}

impl Passage {
    /// A `Passage` from this place to one of these regions.
    pub(super) fn new(floor: &Floor, regions: &[Region], rows: Rows, rows_apart: usize, from: Point) -> Self {
        let points = |row: [Cell; 2]| row.map(|cell| floor.grid().center(cell));
        let of_region = |(region, each): (usize, &Region)| {
            corners(each, rows, rows_apart).map(|rows| {
                let rows: Vec<_> = rows.into_iter().map(points).collect();
                Entry { straight_m: (rows[0][0] - from).norm(), region, rows }
            })
        };
        let mut entries: Vec<_> = regions.iter().enumerate().flat_map(of_region).collect();
        entries.sort_by(|a, b| a.straight_m.total_cmp(&b.straight_m));
        Self { from, entries, tried: 0, best: None }
    }

    /// Goes on, looking at no more cells than are `left`. When it is ready it has the path, and the place of its region in
    /// the list; `None` if no path leads to any.
    pub(super) fn plan(
        &mut self,
        floor: &Floor,
        search: &mut ThetaStar,
        left: &mut usize,
    ) -> Poll<Option<(usize, Path)>> {
        while let Some(entry) = self.entries.get(self.tried) {
            let is_longer = |best: &Best| entry.straight_m >= best.length_m;
            if self.best.as_ref().is_some_and(is_longer) {
                break;
            }
            let found = ready!(floor.seek(search, self.from, entry.rows[0][0], left));
            self.tried += 1;
            let Ok(points) = found else { continue };
            let length_m = points.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
            if self.best.as_ref().is_none_or(|best| length_m < best.length_m) {
                let rows = to_and_fro(&entry.rows);
                self.best = Some(Best { region: entry.region, length_m, points, rows });
            }
        }
        // No other entry can be nearer.
        self.tried = self.entries.len();
        let Some(best) = &mut self.best else { return Poll::Ready(None) };
        while let Some([from, to]) = best.rows.front() {
            if let Some(last) = best.points.last() {
                let between = ready!(floor.seek(search, *last, *from, left));
                best.points.extend(between.unwrap_or_default());
            }
            best.points.push(*to);
            best.rows.pop_front();
        }
        Poll::Ready(Some((best.region, Path::new(std::mem::take(&mut best.points)))))
    }
}

/// Every second row is driven back.
fn to_and_fro(rows: &[[Point; 2]]) -> VecDeque<[Point; 2]> {
    let turned = |(i, &[near, far]): (usize, &[Point; 2])| if i % 2 == 0 { [near, far] } else { [far, near] };
    rows.iter().enumerate().map(turned).collect()
}

/// The rows of a region from each of its four corners: first the near end of a row, then its far one.
fn corners(region: &Region, rows: Rows, apart: usize) -> [Vec<[Cell; 2]>; 4] {
    let up = region.rows(rows, apart);
    let down: Vec<_> = up.iter().rev().copied().collect();
    let other_side = |rows: &[[_; 2]]| rows.iter().map(|&[from, to]| [to, from]).collect();
    [other_side(&up), other_side(&down), up, down]
}
