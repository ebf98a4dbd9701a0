//! Scan matching with an occupancy grid, by the distances of points from lines: A. Censi, *An ICP variant using a
//! point-to-line metric*, ICRA 2008. The lines are those of a grid's cells, as P. Biber's and W. Straßer's normal
//! distributions are in *The normal distributions transform*, IROS 2003.
//!
//! Each occupied cell knows where rays have ended in it on average. The ends of a cell and of those around it have a mean
//! m and a direction in which they vary the least, n: the line through m across n is what is there. With xᵢ(p) the end of
//! ray i of a robot at the pose p, and its line, it minimises
//!
//! ```text
//! Σ min(rᵢ², T²) / s² + (p − p₀)ᵀ Σ₀⁻¹ (p − p₀)      rᵢ = nᵢ · (xᵢ(p) − mᵢ)
//! ```
//!
//! over p by Levenberg's and Marquardt's method, from the guess p₀ with covariance Σ₀. A ray that ends where no line is
//! counts as one at the distance T, so that what has come or gone bends the result little. The covariance of the result is
//! the inverse of Σ gᵢ gᵢᵀ / s² + Σ₀⁻¹, where gᵢ is the derivative of rᵢ: along a corridor the guess decides.
//!
//! If too few rays fit there, all poses of a window around the guess are tried, a cell apart, and the descent begins again
//! at the best: correlative matching (E. Olson, *Real-time correlative scan matching*, ICRA 2009, with one resolution).

use baudbot_geometry::{Direction, Point, Pose, Vector, angle, math};
use nalgebra::{Matrix3, Vector3};

use crate::estimate::Estimate;
use crate::mapping::{Occupancy, Occupied};
use crate::scan::Scan;

/// The outcome of matching a scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Match {
    /// The scan was taken here.
    Found(Estimate),
    /// The map knows too little of where its rays end.
    New,
    /// The scan fits nowhere near the guess.
    Poor,
}

/// Matches a scan with a map, around a guess. A scan is poor if fewer than `least_fit` of its rays, as a part of those that
/// end where the map knows anything, end beside something.
#[must_use]
pub fn find(grid: &Occupancy, scan: &Scan, guess: &Estimate, least_fit: f64) -> Match {
    let problem = Problem::new(grid, scan, guess);
    let mut best = problem.descend(guess.world_from_robot);
    let Some(mut fit) = problem.fit(&best.pose) else { return Match::New };
    if fit < ENOUGH {
        let other = problem.descend(problem.search());
        if let Some(better) = problem.fit(&other.pose).filter(|better| *better > fit) {
            (best, fit) = (other, better);
        }
    }
    if fit < least_fit {
        return Match::Poor;
    }
    let covariance = best.curvature.try_inverse().unwrap_or(guess.covariance);
    Match::Found(Estimate { world_from_robot: best.pose, covariance })
}

struct Problem<'a> {
    grid: &'a Occupancy,
    /// The ends of rays, in the robot's frame, in metres.
    ends: Vec<Vector>,
    guess: &'a Estimate,
    /// The inverse covariance Σ₀⁻¹ of the guess.
    certainty: Matrix3<f64>,
    /// Standard deviations of the guess's position, in metres, and heading, in radians.
    deviations: (f64, f64),
}

/// The sum at a pose, and its derivatives.
#[derive(Clone, Copy)]
struct At {
    pose: Pose,
    cost: f64,
    slope: Vector3<f64>,
    curvature: Matrix3<f64>,
}

impl<'a> Problem<'a> {
    fn new(grid: &'a Occupancy, scan: &Scan, guess: &'a Estimate) -> Self {
        let forward = scan.robot_from_laser.direction();
        let end = |i: usize| {
            let distance_m = scan.distances_m[i];
            let direction = forward.rotate(Direction::from_angle(scan.bearing_rad(i)));
            let end = scan.robot_from_laser.position.coords + direction.vector() * distance_m;
            (distance_m <= scan.range_m).then_some(end)
        };
        let ends = (0..scan.distances_m.len()).filter_map(end).collect();
        let deviations = (guess.position_sd_m() + LEAST_SD_M, guess.heading_sd_rad() + LEAST_SD_RAD);
        let least = Vector3::new(LEAST_SD_M, LEAST_SD_M, LEAST_SD_RAD);
        let covariance = guess.covariance + Matrix3::from_diagonal(&least.component_mul(&least));
        let certainty = covariance.try_inverse().unwrap_or_else(Matrix3::zeros);
        Self { grid, ends, guess, certainty, deviations }
    }

    fn at(&self, pose: Pose) -> At {
        let off = self.off(&pose);
        let slope = self.certainty * off;
        let mut at = At { pose, cost: off.dot(&slope), slope, curvature: self.certainty };
        let forward = pose.direction();
        for end in &self.ends {
            let arm = forward.apply(*end);
            let end = pose.position + arm;
            let line = line(self.grid, end).map(|(mean, normal)| (normal.dot(&(end - mean)), normal));
            let Some((off_m, normal)) = line.filter(|(off_m, _)| off_m.abs() < FAR_M) else {
                at.cost += WEIGHT * FAR_M * FAR_M;
                continue;
            };
            let by_pose = Vector3::new(normal.x, normal.y, normal.y * arm.x - normal.x * arm.y);
            at.cost += WEIGHT * off_m * off_m;
            at.slope += by_pose * (WEIGHT * off_m);
            at.curvature += by_pose * by_pose.transpose() * WEIGHT;
        }
        at
    }

    /// The distance of a pose from the guess.
    fn off(&self, pose: &Pose) -> Vector3<f64> {
        let guess = &self.guess.world_from_robot;
        let moved = pose.position - guess.position;
        Vector3::new(moved.x, moved.y, angle::difference(pose.heading, guess.heading))
    }

    /// Levenberg's and Marquardt's method.
    fn descend(&self, start: Pose) -> At {
        let mut best = self.at(start);
        let mut damping = 1e-3;
        for _ in 0..MOST_STEPS {
            let damped = best.curvature + Matrix3::from_diagonal(&best.curvature.diagonal()) * damping;
            let Some(inverse) = damped.try_inverse() else { break };
            let step = inverse * best.slope;
            let Pose { position, heading } = best.pose;
            let next =
                self.at(Pose::new(position.x - step.x, position.y - step.y, angle::wrap(heading - step.z)));
            if next.cost < best.cost {
                damping *= 0.3;
                best = next;
            } else {
                damping *= 10.0;
            }
            if step.x.abs() + step.y.abs() < DONE_M && step.z.abs() < DONE_RAD {
                break;
            }
        }
        best
    }

    /// The part of the rays that end beside something, of those that end where anything is known; `None` if these are too
    /// few.
    fn fit(&self, pose: &Pose) -> Option<f64> {
        let forward = pose.direction();
        let (mut known, mut fitting) = (0, 0);
        for end in &self.ends {
            let cell = self.grid.cell(pose.position + forward.apply(*end));
            let is_occupied =
                |(columns, rows)| self.grid.state(cell.offset(columns, rows)) == Occupied::Occupied;
            if AROUND.into_iter().any(is_occupied) {
                (known, fitting) = (known + 1, fitting + 1);
            } else if self.grid.state(cell) != Occupied::Unknown {
                known += 1;
            }
        }
        let is_enough = known >= LEAST_RAYS && known as f64 >= LEAST_KNOWN * self.ends.len() as f64;
        is_enough.then(|| f64::from(fitting) / f64::from(known))
    }

    /// The pose with the most evidence of a window of three standard deviations around the guess.
    fn search(&self) -> Pose {
        let Pose { position, heading } = self.guess.world_from_robot;
        let cell_m = self.grid.cell_m();
        let places = whole(3.0 * self.deviations.0 / cell_m, MOST_PLACES);
        let turns = whole(3.0 * self.deviations.1 / TURN_RAD, MOST_TURNS);
        let mut best = (f64::NEG_INFINITY, self.guess.world_from_robot);
        for turn in -turns..=turns {
            let heading = angle::wrap(heading + f64::from(turn) * TURN_RAD);
            let forward = Direction::from_angle(heading);
            let arms: Vec<_> = self.ends.iter().map(|end| forward.apply(*end)).collect();
            for (across, up) in window(places) {
                let position = position + Vector::new(f64::from(across), f64::from(up)) * cell_m;
                let sum: f64 = arms.iter().map(|arm| wall(self.grid, position + arm)).sum();
                // Among equal sums the one nearest to the guess wins.
                let sum = sum - NEARER * f64::from(across * across + up * up + turn * turn);
                if sum > best.0 {
                    best = (sum, Pose { position, heading });
                }
            }
        }
        best.1
    }
}

fn window(most: i32) -> impl Iterator<Item = (i32, i32)> {
    (-most..=most).flat_map(move |up| (-most..=most).map(move |across| (across, up)))
}

/// A whole number at least as large as `wanted`, but not larger than `most`.
fn whole(wanted: f64, most: i32) -> i32 {
    // The conversion saturates.
    (math::ceil(wanted) as i32).clamp(1, most)
}

/// 1 if the cell around a point is occupied, else 0.
fn wall(grid: &Occupancy, point: Point) -> f64 {
    f64::from(u8::from(grid.state(grid.cell(point)) == Occupied::Occupied))
}

/// The line around a point: a point of it, and the unit vector across. `None` if there is nothing, or no line.
fn line(grid: &Occupancy, point: Point) -> Option<(Point, Vector)> {
    let cell = grid.cell(point);
    let around = AROUND.into_iter().filter_map(|(columns, rows)| grid.surface(cell.offset(columns, rows)));
    let (mut count, mut sum, mut squares) = (0.0, Vector::zeros(), [0.0; 3]);
    for surface in around {
        let gap = surface - point;
        count += 1.0;
        sum += gap;
        squares = [squares[0] + gap.x * gap.x, squares[1] + gap.x * gap.y, squares[2] + gap.y * gap.y];
    }
    if count < 2.0 {
        return None;
    }
    let mean = sum / count;
    let [xx, xy, yy] = [
        squares[0] / count - mean.x * mean.x,
        squares[1] / count - mean.x * mean.y,
        squares[2] / count - mean.y * mean.y,
    ];
    // The eigenvalues of [xx xy; xy yy] are the half of their sum, more and less by `spread`.
    let (half, spread) = (0.5 * (xx + yy), math::hypot(0.5 * (xx - yy), xy));
    if half - spread > ROUND * (half + spread) {
        return None;
    }
    let along = 0.5 * math::atan2(2.0 * xy, xx - yy);
    let (sin, cos) = math::sin_cos(along);
    Some((point + mean, Vector::new(-sin, cos)))
}

/// 1 / s², for each square metre: s = 2 cm. Rays beside each other err together, so that many are worth no more than some.
const WEIGHT: f64 = 2500.0;
/// T, in metres: a ray that ends farther from a line is of something else.
const FAR_M: f64 = 0.06;
/// Points that vary across a line more than by this part of how they vary along it are no line.
const ROUND: f64 = 0.3;
/// Errors of the guess that its covariance does not know, as standard deviations.
const LEAST_SD_M: f64 = 0.01;
const LEAST_SD_RAD: f64 = 0.01;
/// A descent ends with a step of less than this.
const DONE_M: f64 = 1e-4;
const DONE_RAD: f64 = 1e-4;
const MOST_STEPS: usize = 20;
/// No search is made if this part of the rays fits.
const ENOUGH: f64 = 0.85;
/// The number of rays that must end where something is known, ...
const LEAST_RAYS: i32 = 10;
/// ... and this part of all that met something.
const LEAST_KNOWN: f64 = 0.2;
/// The window: cells to each side at most, and steps of the heading.
const MOST_PLACES: i32 = 5;
const MOST_TURNS: i32 = 6;
const TURN_RAD: f64 = 0.02;
/// The cost of a step away from the guess, in rays.
const NEARER: f64 = 0.01;
/// A cell, and those at its sides.
const AROUND: [(i32, i32); 9] =
    [(0, 0), (1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)];
