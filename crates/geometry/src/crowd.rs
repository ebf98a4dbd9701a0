//! Discs that move, such as robots, and those of them that are near a place.
//!
//! The plane is divided into square cells, and each disc is listed in that of its centre. The lists are made afresh
//! whenever the discs have moved, in a time proportional to their number. Cells have no place of their own in memory:
//! a number that is computed from column and row says in which of the lists a cell's discs are, which other cells
//! may share. So a few discs that have strayed cost nothing, and a crowd may be anywhere.

use alloc::vec::Vec;

use crate::bounds::Bounds;
use crate::circle::Circle;
use crate::math;

/// Discs that move.
#[derive(Clone, Debug, Default)]
pub struct Crowd {
    discs: Vec<Circle>,
    /// Cells to a metre.
    cells_per_m: f64,
    /// The largest radius of the discs that are listed by cells.
    widest: f64,
    /// The number of bits by which a cell's number is shifted down to be that of its list.
    shift: u32,
    /// The beginning of each list in `members`; one more at the end.
    starts: Vec<u32>,
    members: Vec<u32>,
    /// Discs that are so large that every search looks at them.
    large: Vec<u32>,
    /// Each disc's list, while the lists are made.
    lists: Vec<u32>,
}

impl Crowd {
    /// The bytes that it has on the heap.
    #[must_use]
    pub fn heap_bytes(&self) -> usize {
        let numbers = [&self.starts, &self.members, &self.large, &self.lists];
        let numbers: usize = numbers.into_iter().map(Vec::capacity).sum();
        self.discs.capacity() * size_of::<Circle>() + numbers * size_of::<u32>()
    }

    /// Forgets the discs, and takes these. Needs no new memory if there are not more of them than before.
    pub fn rebuild(&mut self, discs: impl IntoIterator<Item = Circle>) {
        self.discs.clear();
        self.discs.extend(discs);
        self.large.clear();
        self.starts.clear();
        if self.discs.len() <= FEW {
            self.large.extend(0..self.discs.len() as u32);
            return;
        }
        let cell = self.cell();
        self.cells_per_m = 1.0 / cell;
        self.widest = 0.0;
        let lists = self.discs.len().next_power_of_two();
        self.shift = u64::BITS - lists.trailing_zeros();
        self.starts.resize(lists + 1, 0);
        self.lists.clear();
        for (i, disc) in self.discs.iter().enumerate() {
            if disc.radius > cell {
                self.large.push(i as u32);
                self.lists.push(u32::MAX);
                continue;
            }
            self.widest = if disc.radius > self.widest { disc.radius } else { self.widest };
            let list = self.list(self.place(disc.center.x), self.place(disc.center.y));
            self.lists.push(list as u32);
            self.starts[list] += 1;
        }
        self.list_members();
    }

    /// Finds the beginning of each list from the numbers of their discs, and puts each disc into its list.
    fn list_members(&mut self) {
        let mut end = 0;
        for start in &mut self.starts {
            end += *start;
            *start = end;
        }
        self.members.clear();
        self.members.resize(end as usize, 0);
        // The discs go from behind, so that each list begins where it should when all are in, and its discs ascend.
        for (i, &list) in self.lists.iter().enumerate().rev() {
            if let Some(start) = self.starts.get_mut(list as usize) {
                *start -= 1;
                self.members[*start as usize] = i as u32;
            }
        }
    }

    /// The side of a cell, in metres: of as many cells as discs where these are spread evenly, within limits that
    /// their size sets.
    fn cell(&self) -> f64 {
        let number = self.discs.len() as f64;
        let mean = self.discs.iter().map(|disc| disc.radius).sum::<f64>() / number;
        let bounds = self.discs.iter().map(|disc| Bounds { min: disc.center, max: disc.center });
        let size = bounds.reduce(|a, b| a.union(&b)).map(|all| all.size()).unwrap_or_default();
        let even = math::sqrt(size.x * size.y / number);
        let cell = if even > MOST_RADII * mean { MOST_RADII * mean } else { even };
        let cell = if cell > LEAST_RADII * mean { cell } else { LEAST_RADII * mean };
        if cell > 0.0 && cell.is_finite() { cell } else { 1.0 }
    }

    /// The discs, in the order in which they were given.
    #[must_use]
    pub fn discs(&self) -> &[Circle] {
        &self.discs
    }

    /// Visits, by their places, all discs that may overlap this one, and some that do not. One may be visited more
    /// than once. The order is the same in each run.
    #[inline]
    pub fn near(&self, circle: &Circle, mut visit: impl FnMut(usize)) {
        self.large.iter().for_each(|&i| visit(i as usize));
        if self.starts.is_empty() {
            return;
        }
        let reach = (circle.radius + self.widest) * (1.0 + SLACK);
        let places = |center: f64| {
            let slack = SLACK * center.abs();
            self.place(center - reach - slack)..=self.place(center + reach + slack)
        };
        let (columns, rows) = (places(circle.center.x), places(circle.center.y));
        let across = |range: &core::ops::RangeInclusive<i64>| (range.end() - range.start()) as f64 + 1.0;
        if across(&columns) * across(&rows) >= self.discs.len() as f64 {
            return self.members.iter().for_each(|&i| visit(i as usize));
        }
        for row in rows {
            for column in columns.clone() {
                let list = self.list(column, row);
                let members = self.starts[list] as usize..self.starts[list + 1] as usize;
                self.members[members].iter().for_each(|&i| visit(i as usize));
            }
        }
    }

    /// The column or row of a coordinate. The one around 0 is twice as wide as others.
    fn place(&self, coordinate: f64) -> i64 {
        (coordinate * self.cells_per_m) as i32 as i64
    }

    fn list(&self, column: i64, row: i64) -> usize {
        // Odd numbers without pattern: neighbours end up in different lists.
        let number = (column as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ (row as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
        (number >> self.shift) as usize
    }
}

/// So few are all looked at.
const FEW: usize = 4;

/// The side of a cell is at least and at most so many mean radii.
const LEAST_RADII: f64 = 4.0;
const MOST_RADII: f64 = 24.0;

/// More than rounding can make of the borders of cells.
const SLACK: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::Point;

    fn discs(number: usize) -> Vec<Circle> {
        // No two on a line, some outside of all others, one large.
        (0..number)
            .map(|i| {
                let i = i as f64;
                let away = if i as usize % 50 == 7 { 100.0 } else { 1.0 };
                let center = Point::new((i * 0.734) % 5.0 - 2.5, ((i * i * 0.31) % 4.0 - 2.0) * away);
                Circle { center, radius: if i == 3.0 { 3.0 } else { 0.03 + 0.001 * (i % 9.0) } }
            })
            .collect()
    }

    #[test]
    fn all_that_overlap_are_near() {
        let mut crowd = Crowd::default();
        for number in [0, 1, 4, 5, 300, 40] {
            crowd.rebuild(discs(number));
            assert_eq!(crowd.discs().len(), number);
            for query in discs(60) {
                let query = Circle { radius: query.radius * 4.0, ..query };
                let mut near = Vec::new();
                crowd.near(&query, |i| near.push(i));
                for (i, disc) in crowd.discs().iter().enumerate() {
                    assert!(near.contains(&i) || !disc.overlaps_circle(&query), "{i} of {number}");
                }
            }
        }
    }

    #[test]
    fn few_of_many_are_looked_at() {
        let mut crowd = Crowd::default();
        let grid = |i: usize| Point::new((i % 100) as f64 * 0.5, (i / 100) as f64 * 0.5);
        crowd.rebuild((0..10_000).map(|i| Circle { center: grid(i), radius: 0.035 }));
        let mut visits = 0;
        crowd.near(&Circle { center: Point::new(20.1, 30.2), radius: 0.12 }, |_| visits += 1);
        assert!(visits < 20, "{visits}");
    }

    #[test]
    fn a_heap_and_a_stray_are_no_trouble() {
        let mut crowd = Crowd::default();
        let heap = (0..1000).map(|i| Point::new((i % 40) as f64 * 0.08, (i / 40) as f64 * 0.08));
        let stray = Point::new(1e6, -1e6);
        crowd.rebuild(heap.chain([stray]).map(|center| Circle { center, radius: 0.035 }));
        let mut visits = 0;
        crowd.near(&Circle { center: Point::new(1.0, 1.0), radius: 0.12 }, |_| visits += 1);
        assert!(visits < 500, "{visits}");
    }

    #[test]
    fn nonsense_is_no_reason_to_panic() {
        let mut crowd = Crowd::default();
        let nowhere = Circle { center: Point::new(f64::NAN, f64::INFINITY), radius: 0.1 };
        crowd.rebuild(discs(20).into_iter().chain([nowhere]));
        crowd.near(&nowhere, |_| {});
        crowd.near(&Circle { center: Point::origin(), radius: f64::INFINITY }, |_| {});
    }
}
