//! The ground in square cells, each with what a metre across it costs: 1 where it is open, more near hills and marks.
//!
//! A hill stands for something that the **centre** of the body keeps out of: the ellipse with the half axes β and γ. Beside
//! that a path keeps 1.5 R clear where there is room, with R the body's radius, as the ellipse may be meant for the obstacle
//! alone. A mark is where something was felt; there the body itself keeps clear.
//!
//! Prices instead of borders: of two narrow places the wider one is taken, and there is a way out of where the robot is.

use baudbot_geometry::{Bounds, Point, Vector, math};

use super::field::Potential;
use crate::planning::{Cell, Grid, cheapest};

/// The cost of a path by its places.
pub(super) struct Terrain {
    grid: Grid,
    costs: Vec<f64>,
}

/// A path to a target.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Path {
    /// The points from the robot's place at planning to the target.
    pub(super) points: Vec<Point>,
    /// The path leads through a hill or over a mark, not only out of one at its start or into one at its end: all other
    /// ways are closed.
    pub(super) is_forced: bool,
}

impl Terrain {
    /// The ground around these places, with hills, and with marks by their centres that may be wrong by so much, for a body of
    /// this radius.
    pub(super) fn new(
        places: [Point; 2],
        hills: &[Potential],
        marks: impl Iterator<Item = Point> + Clone,
        blur_m: f64,
        radius_m: f64,
    ) -> Option<Self> {
        let ends = hills.iter().flat_map(|hill| {
            let reach = Vector::new(hill.beta_m, hill.gamma_m);
            [hill.center() - reach, hill.center() + reach]
        });
        let all = places.into_iter().chain(ends).chain(marks.clone());
        let bounds = all.map(|at| Bounds { min: at, max: at }).reduce(|a, b| a.union(&b))?;
        let beside = Vector::new(1.0, 1.0) * (BESIDE * radius_m);
        let bounds = Bounds { min: bounds.min - beside, max: bounds.max + beside };
        let size_m = bounds.size().x.max(bounds.size().y);
        let grid = Grid::covering(&bounds, (CELL * radius_m).max(size_m / MOST_CELLS)).ok()?;
        let mut terrain = Self { costs: vec![1.0; grid.len()], grid };
        for hill in hills {
            terrain.add_hill(hill, radius_m);
        }
        for mark in marks {
            terrain.add_mark(mark, blur_m, radius_m);
        }
        Some(terrain)
    }

    fn add_hill(&mut self, hill: &Potential, radius_m: f64) {
        let soft_m = HILL_SOFT * radius_m;
        let reach = Vector::new(hill.beta_m + soft_m, hill.gamma_m + soft_m);
        for cell in self.grid.within(hill.center() - reach, hill.center() + reach) {
            let (depth, clear_m) = depth(hill, self.grid.center(cell));
            let cost = if depth > 0.0 { CLOSED * (1.0 + DEEP * depth) } else { near(clear_m / soft_m) };
            self.raise(cell, cost);
        }
    }

    fn add_mark(&mut self, mark: Point, blur_m: f64, radius_m: f64) {
        let (hard_m, soft_m) = (MARK_HARD * radius_m, blur_m.max(MARK_SOFT * radius_m));
        let reach = Vector::new(1.0, 1.0) * (radius_m + soft_m);
        for cell in self.grid.within(mark - reach, mark + reach) {
            let clear_m = (self.grid.center(cell) - mark).norm() - radius_m;
            let deep = (1.0 - clear_m / hard_m).min(DEEP);
            let cost =
                if deep > 0.0 { CLOSED * (1.0 + deep) } else { near((clear_m - hard_m) / (soft_m - hard_m)) };
            self.raise(cell, cost);
        }
    }

    fn raise(&mut self, cell: Cell, cost: f64) {
        let known = &mut self.costs[self.grid.number(cell)];
        *known = known.max(cost);
    }

    /// The cost of a path a metre at a place; outside of the ground it is open.
    fn cost(&self, at: Point) -> f64 {
        self.grid.cell_at(at).map_or(1.0, |cell| self.costs[self.grid.number(cell)])
    }

    /// The cost of a way along these points, in metres of open ground.
    pub(super) fn price(&self, points: &[Point]) -> f64 {
        points.windows(2).map(|pair| (pair[1] - pair[0]).norm() * self.cost(pair[1])).sum()
    }

    /// Whether a place is in a hill, or the body would be over a mark there.
    pub(super) fn is_closed(&self, at: Point) -> bool {
        self.cost(at) >= CLOSED
    }

    /// Whether there is all the room beside that one could want.
    pub(super) fn is_open(&self, at: Point) -> bool {
        self.cost(at) <= OPEN
    }

    /// The cheapest way.
    pub(super) fn path(&self, from: Point, to: Point) -> Option<Path> {
        let (start, target) = (self.grid.cell_at(from)?, self.grid.cell_at(to)?);
        let (cells, _) = cheapest(&self.grid, &self.costs, start, target).ok()?;
        let mut points: Vec<_> = cells.into_iter().map(|cell| self.grid.center(cell)).collect();
        *points.first_mut()? = from;
        points.push(to);
        let is_closed = |at: &Point| self.is_closed(*at);
        let out = points.iter().position(|at| !is_closed(at)).unwrap_or(points.len());
        let into = points.iter().rposition(|at| !is_closed(at)).map_or(0, |last| last + 1);
        let is_forced = points.get(out..into).is_none_or(|between| between.iter().any(is_closed));
        Some(Path { points, is_forced })
    }
}

/// The depth of a place in a hill, from 0 at the ellipse to 1 at its centre, and its distance outside of it, in
/// metres: 0 within, and of an ellipse that is no circle in the first order.
fn depth(hill: &Potential, at: Point) -> (f64, f64) {
    let offset = at - hill.center();
    let scaled = Vector::new(offset.x / hill.beta_m, offset.y / hill.gamma_m);
    let u = scaled.norm();
    if u < 1.0 {
        return (1.0 - u, 0.0);
    }
    let slope = math::hypot(scaled.x / hill.beta_m, scaled.y / hill.gamma_m) / u;
    (0.0, (u - 1.0) / slope)
}

/// The cost of nearness: `part` is 1 where it does not matter any more.
fn near(part: f64) -> f64 {
    1.0 + NARROW * (1.0 - part).max(0.0)
}

/// Ground beside all that is known, in radii of the body.
const BESIDE: f64 = 12.0;
/// Side of a cell, in radii of the body.
const CELL: f64 = 0.2;
/// Cells along the longer side at most.
const MOST_CELLS: f64 = 400.0;
/// Room that is kept beside a hill's ellipse if there is some, in radii of the body.
const HILL_SOFT: f64 = 1.5;
/// Room that the body keeps beside a mark if there is some, in radii of the body ...
const MARK_SOFT: f64 = 0.75;
/// ... and in any case.
const MARK_HARD: f64 = 0.15;
/// The additional cost of the narrowest place over an open one.
const NARROW: f64 = 30.0;
/// The cost of going where no path is.
const CLOSED: f64 = 1000.0;
/// The additional cost in the middle of it.
const DEEP: f64 = 3.0;
/// Up to this cost there is room.
const OPEN: f64 = 8.0;

#[cfg(test)]
mod tests {
    use super::*;

    const BODY_M: f64 = 0.15;

    fn hill(x_m: f64, y_m: f64) -> Potential {
        Potential { x_m, y_m, alpha: 0.6, beta_m: 0.25, gamma_m: 0.25 }
    }

    fn path(hills: &[Potential], marks: &[Point]) -> Path {
        let (from, to) = (Point::new(0.0, 0.0), Point::new(2.0, 0.0));
        let terrain = Terrain::new([from, to], hills, marks.iter().copied(), 0.0, BODY_M).unwrap();
        terrain.path(from, to).unwrap()
    }

    #[test]
    fn a_way_keeps_out_of_hills_and_clear_of_marks() {
        let hills = [hill(1.0, 0.0), hill(1.0, 0.3), hill(1.0, -0.3)];
        let round = path(&hills, &[]);
        assert!(!round.is_forced && round.points[round.points.len() - 1] == Point::new(2.0, 0.0));
        let near = round.points.iter().flat_map(|at| hills.map(|hill| (at - hill.center()).norm()));
        let near_m = near.fold(f64::INFINITY, f64::min);
        assert!(near_m > 0.25 + 0.9 * HILL_SOFT * BODY_M, "{near_m}");
        let marks: Vec<_> = (-10..=10).map(|i| Point::new(1.0, 0.04 * f64::from(i))).collect();
        let round = path(&[], &marks);
        let near = round.points.iter().flat_map(|at| marks.iter().map(move |mark| (at - mark).norm()));
        let near_m = near.fold(f64::INFINITY, f64::min);
        assert!(!round.is_forced && near_m > BODY_M * (1.0 + 0.9 * MARK_SOFT), "{near_m}");
    }

    /// A hill may be meant for the obstacle alone, so the body may not fit between two that leave little room.
    #[test]
    fn of_two_gaps_the_wider_one_is_taken_though_it_is_farther_away() {
        let hills: Vec<_> =
            [-2.4, -2.0, -1.6, -1.2, 0.0, 0.6, 1.0, 1.4, 1.8, 2.2, 2.6].map(|y| hill(1.0, y)).to_vec();
        let crossed = path(&hills, &[]).points.into_iter().find(|at| at.x > 1.0).unwrap();
        assert!((crossed.y + 0.6).abs() < 0.14, "{crossed}");
    }

    #[test]
    fn where_all_is_closed_the_way_is_forced_unless_that_is_its_end_alone() {
        let ring: Vec<_> = (0..16)
            .map(|i| {
                let (sin, cos) = math::sin_cos(std::f64::consts::TAU * f64::from(i) / 16.0);
                hill(2.0 + 0.8 * cos, 0.8 * sin)
            })
            .collect();
        assert!(path(&ring, &[]).is_forced);
        assert!(!path(&[hill(2.1, 0.0)], &[]).is_forced, "the goal is in a hill");
        assert!(!path(&[hill(-0.1, 0.0)], &[]).is_forced, "the robot is in a hill");
    }
}
