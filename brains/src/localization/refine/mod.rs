//! Scan matching by robust least squares: the pose that a scan was taken from, and how sure that is.
//!
//! It minimises, over poses p near a guess p₀ with covariance Σ₀,
//!
//! ```text
//! Σ ρ((δᵢ(p) − dᵢ) / sᵢ) + (p − p₀)ᵀ Σ₀⁻¹ (p − p₀)      ρ(r) = κ² ln(1 + r²/κ²)
//! sᵢ² = noise_m² + (noise_ratio · dᵢ)²
//! ```
//!
//! by Levenberg's and Marquardt's method, with the weights 1 / (1 + r²/κ²) of Cauchy's loss ρ: a person in front of the
//! laser bends the result little. Where a ray along u from the laser at o hits a surface with the normal n
//!
//! ```text
//! ∂δ/∂o = −n / (n·u)      ∂δ/∂φ = −(n·Jm + δ n·Ju) / (n·u)
//! ```
//!
//! with m from the robot's centre to the laser, and J a quarter turn to the left. The covariance of the result is the
//! inverse of Σ wᵢ gᵢ gᵢᵀ / sᵢ² + Σ₀⁻¹, where gᵢ is the derivative of δᵢ: where walls do not say where along a corridor
//! the robot is, the guess still does.
//!
//! A ray that sees nothing within the range counts as one of that length, so a virtual wall in front of it costs
//! something. One minimum is not all: unless nearly all rays fit at once, poses drawn around the guess are starts as well,
//! and the least sum wins.
//!
//! This is not in the notes, whose random search is in [`laser`](super::laser). Cauchy's scale κ is first large, then
//! small: from afar all rays must pull, in the end only those that fit.

use baudbot_geometry::{Pose, Vector, angle, math};
use nalgebra::{Matrix3, Vector3};

use super::Tried;
use super::map::{Echo, Map, VirtualLaser};
use crate::Chance;
use crate::estimate::Estimate;
use crate::scan::Scan;

/// Parameters of the laser and of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Standard deviation of each distance, in metres.
    pub noise_m: f64,
    /// The additional deviation for each metre of the distance.
    pub noise_ratio: f64,
    /// Starts besides the guess, at most, drawn from the guess's covariance.
    pub starts: usize,
    /// No more starts are tried when this part of the rays fits; above 1 to try them all.
    pub enough: f64,
    /// Virtual scans at most from each start.
    pub scans: usize,
    /// The number of virtual scans of all starts after which no other start is tried: a match must end while it is of
    /// use.
    pub all_scans: usize,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { noise_m: 0.005, noise_ratio: 0.01, starts: 8, enough: 0.98, scans: 40, all_scans: 120 }
    }
}

/// The end of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refined {
    /// The best pose, and how sure it is if it is the right minimum.
    pub estimate: Estimate,
    /// Part of the rays that fit there within three standard deviations; well below 1 where the map is wrong, or the
    /// pose.
    pub fit: f64,
    /// Virtual scans that were made.
    pub scans: usize,
}

/// Searches from a guess for the pose at which a laser in this map sees the scan. The guess's covariance must be at
/// least that of the possible error of the pose.
///
/// # Panics
/// If the scan has no rays.
#[must_use]
pub fn refine(
    map: &Map,
    scan: &Scan,
    guess: &Estimate,
    parameters: &Parameters,
    chance: &mut Chance,
) -> Refined {
    refine_watched(map, scan, guess, parameters, chance, |_| ())
}

/// The same search, which reports each pose that it tries: first the guess, and where a start goes on with the narrow
/// loss its pose again.
///
/// # Panics
/// If the scan has no rays.
#[must_use]
pub fn refine_watched(
    map: &Map,
    scan: &Scan,
    guess: &Estimate,
    parameters: &Parameters,
    chance: &mut Chance,
    mut watch: impl FnMut(&Tried),
) -> Refined {
    let problem = Problem::new(map, scan, guess, parameters);
    let mut best = problem.descend(guess.world_from_robot, 0, &mut watch);
    let mut scans = best.scans;
    for start in 1..=parameters.starts {
        if problem.fit(&best.at) >= parameters.enough || scans >= parameters.all_scans {
            break;
        }
        let found = problem.descend(problem.draw(chance), start, &mut watch);
        scans += found.scans;
        if found.at.cost < best.at.cost {
            best = found;
        }
    }
    let covariance = best.at.curvature.try_inverse().unwrap_or(guess.covariance);
    let estimate = Estimate { world_from_robot: best.at.pose, covariance };
    Refined { estimate, fit: problem.fit(&best.at), scans }
}

struct Problem<'a> {
    map: &'a Map,
    scan: &'a Scan,
    laser: VirtualLaser,
    guess: &'a Estimate,
    /// The inverse covariance Σ₀⁻¹ of the guess.
    certainty: Matrix3<f64>,
    parameters: &'a Parameters,
}

/// The sum at a pose, and its derivatives.
struct Look {
    pose: Pose,
    cost: f64,
    /// Half the gradient.
    gradient: Vector3<f64>,
    /// Half the second derivative, without that of the residuals.
    curvature: Matrix3<f64>,
    fitting: usize,
}

/// The way down from one start.
struct Descent {
    at: Look,
    scans: usize,
}

impl<'a> Problem<'a> {
    fn new(map: &'a Map, scan: &'a Scan, guess: &'a Estimate, parameters: &'a Parameters) -> Self {
        // Nothing is so sure that it cannot be weighed against a scan.
        let covariance = guess.covariance + Matrix3::identity() * LEAST_VARIANCE;
        let certainty = covariance.try_inverse().unwrap_or_else(Matrix3::zeros);
        Self { map, scan, laser: VirtualLaser::like(scan), guess, certainty, parameters }
    }

    /// The fraction of the useful rays that fit.
    fn fit(&self, at: &Look) -> f64 {
        let known = self.scan.distances_m.iter().filter(|distance| !distance.is_nan()).count();
        at.fitting as f64 / known.max(1) as f64
    }

    /// A pose drawn from the guess.
    fn draw(&self, chance: &mut Chance) -> Pose {
        let deviates = Vector3::from_fn(|_, _| chance.normal());
        let root = self.guess.covariance.cholesky().map_or_else(Matrix3::zeros, |cholesky| cholesky.l());
        moved(&self.guess.world_from_robot, &(root * deviates))
    }

    /// Goes down from the pose of a start, first with a wide loss and then with a narrow one.
    fn descend(&self, from: Pose, start: usize, watch: &mut impl FnMut(&Tried)) -> Descent {
        let mut tell = |look: &Look, accepted| {
            watch(&Tried { world_from_robot: look.pose, error: look.cost, accepted, start });
        };
        let each = self.parameters.scans / 2;
        let wide = self.descend_with(from, WIDE, each, &mut tell);
        let narrow = self.descend_with(wide.at.pose, NARROW, each, &mut tell);
        Descent { at: narrow.at, scans: wide.scans + narrow.scans }
    }

    fn descend_with(
        &self,
        from: Pose,
        scale: f64,
        most_scans: usize,
        tell: &mut impl FnMut(&Look, bool),
    ) -> Descent {
        let (mut at, mut scans, mut damping) = (self.look(&from, scale), 1, 1e-3);
        tell(&at, true);
        while scans < most_scans {
            let damped = at.curvature + Matrix3::from_diagonal(&at.curvature.diagonal()) * damping;
            let Some(step) = damped.cholesky().map(|damped| damped.solve(&-at.gradient)) else { break };
            let next = self.look(&moved(&at.pose, &step), scale);
            scans += 1;
            let gain = at.cost - next.cost;
            tell(&next, gain > 0.0);
            if gain > 0.0 {
                let is_flat = gain < ENOUGH * at.cost;
                at = next;
                damping = (damping * 0.2_f64).max(1e-9);
                if is_flat {
                    break;
                }
            } else {
                damping *= 5.0;
            }
            if step.norm() < SMALL_STEP || damping > 1e6 {
                break;
            }
        }
        Descent { at, scans }
    }

    fn look(&self, pose: &Pose, scale: f64) -> Look {
        let off = difference(pose, &self.guess.world_from_robot);
        let pull = self.certainty * off;
        let mut look =
            Look { pose: *pose, cost: off.dot(&pull), gradient: pull, curvature: self.certainty, fitting: 0 };
        let lever = self.laser.world_from_laser(pose).position - pose.position;
        let range_m = self.scan.range_m;
        for (measured, echo) in self.scan.distances_m.iter().zip(self.laser.echoes(self.map, pose)) {
            if measured.is_nan() {
                continue;
            }
            let measured = measured.min(range_m);
            let Parameters { noise_m, noise_ratio, .. } = self.parameters;
            let variance = noise_m * noise_m + noise_ratio * noise_ratio * measured * measured;
            let residual = echo.map_or(range_m, |echo| echo.distance_m) - measured;
            let square = residual * residual / variance;
            look.cost += scale * scale * math::ln(1.0 + square / (scale * scale));
            look.fitting += usize::from(square <= 9.0);
            let Some(slope) = echo.and_then(|echo| slope(&echo, &lever)) else { continue };
            let weight = 1.0 / ((1.0 + square / (scale * scale)) * variance);
            look.gradient += slope * (weight * residual);
            look.curvature += slope * slope.transpose() * weight;
        }
        look
    }
}

/// The derivative of an echo's distance by the pose; `None` where the ray only grazes the surface, as there it may as
/// well miss it.
fn slope(echo: &Echo, lever: &Vector) -> Option<Vector3<f64>> {
    let Echo { distance_m, normal, along } = echo;
    let facing = normal.dot(along);
    if facing.abs() < GRAZING {
        return None;
    }
    let turned = left_of(lever) + left_of(along) * *distance_m;
    Some(-Vector3::new(normal.x, normal.y, normal.dot(&turned)) / facing)
}

fn left_of(v: &Vector) -> Vector {
    Vector::new(-v.y, v.x)
}

fn moved(pose: &Pose, step: &Vector3<f64>) -> Pose {
    Pose::new(pose.position.x + step.x, pose.position.y + step.y, angle::wrap(pose.heading + step.z))
}

fn difference(to: &Pose, from: &Pose) -> Vector3<f64> {
    let off = to.position - from.position;
    Vector3::new(off.x, off.y, angle::difference(to.heading, from.heading))
}

/// Cauchy's κ at first, in standard deviations.
const WIDE: f64 = 10.0;

/// Cauchy's κ in the end, in standard deviations.
const NARROW: f64 = 2.0;

/// Cosine of the angle to the normal below which a ray grazes.
const GRAZING: f64 = 0.05;

/// A smaller gain than this part of the sum is none.
const ENOUGH: f64 = 1e-5;

/// A step that is smaller is the last, in metres and radians.
const SMALL_STEP: f64 = 1e-6;

/// A micrometre, and as many radians.
const LEAST_VARIANCE: f64 = 1e-12;

#[cfg(test)]
mod tests;
