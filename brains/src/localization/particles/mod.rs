//! Monte Carlo localization: many poses at once, of which those survive that explain the scans.
//!
//! Each particle has a pose and a weight. A motion of the odometry is split into a turn, a way and a turn, and each
//! particle goes them with errors of its own, of the variances
//!
//! ```text
//! turns: α₁ rot² + α₂ trans²        way: α₃ trans² + α₄ (rot₁² + rot₂²)
//! ```
//!
//! A scan multiplies each weight by the product, over some beams, of
//!
//! ```text
//! (1 − z) exp(−(δ − d)² / 2s²) + z        s² = noise_m² + (noise_ratio · d)²
//! ```
//!
//! where z is how often a beam says nothing about the map. When few particles have most of the weight, all are resampled,
//! each in proportion to its weight, with one random number for all. If recent scans fit worse than earlier ones,
//! some of the new particles are put anywhere in the map, so that a robot that was carried away is found again. Thrun,
//! Burgard and Fox, *Probabilistic Robotics*, 2005: tables 5.6, 4.4 and 8.3. It is not in the notes.
//!
//! *Deviations.*
//!
//! - Backwards is a way of less than nothing, not a turn about, a way and a turn back.
//! - The beams of a scan are not independent, so `noise_m` is much more than the laser's noise.
//! - The weight of a scan is the likelihood of one beam, in the geometric mean; the product over all of them falls so
//!   deep that it would put all particles anywhere at once.
//! - The mean of two places is neither of them. The estimate is the mean of the particles near the place with the most
//!   weight.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use baudbot_geometry::{Pose, angle, math};
use nalgebra::{Matrix3, Vector3};

use super::map::{Map, VirtualLaser};
use crate::Chance;
use crate::estimate::Estimate;
use crate::scan::Scan;

/// The number of particles, and their expectations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// The number of particles, at least 1.
    pub particles: usize,
    /// Beams of a scan that are held against the map, about.
    pub beams: usize,
    /// α₁ to α₄: rad² per rad², rad² per m², m² per m², m² per rad².
    pub alphas: [f64; 4],
    /// Standard deviation of a beam, in metres.
    pub noise_m: f64,
    /// The additional deviation for each metre of the distance.
    pub noise_ratio: f64,
    /// z: part of the beams that do not depend on the map, in (0, 1).
    pub outliers: f64,
    /// Particles are drawn again when the effective number falls below this part of them.
    pub resample_below: f64,
    /// The rate at which earlier fits of scans are forgotten, in parts a scan. 0: no particle is ever put anywhere.
    pub slow: f64,
    /// The rate at which recent fits are forgotten; larger.
    pub fast: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            particles: 500,
            beams: 43,
            alphas: [0.01, 0.01, 0.005, 0.005],
            noise_m: 0.1,
            noise_ratio: 0.01,
            outliers: 0.05,
            resample_below: 0.5,
            slow: 0.02,
            fast: 0.2,
        }
    }
}

/// A pose that the robot may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// Robot in the world.
    pub world_from_robot: Pose,
    /// The probability; those of all particles add up to 1.
    pub weight: f64,
}

/// The poses at which the robot may be.
#[derive(Clone, Debug, PartialEq)]
pub struct Particles {
    parameters: Parameters,
    particles: Vec<Particle>,
    /// The fits of scans, in the long run and of late; `None` before the first.
    fits: Option<Fits>,
    chance: Chance,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Fits {
    slow: f64,
    fast: f64,
}

impl Particles {
    /// Particles drawn from an estimate.
    #[must_use]
    pub fn around(estimate: &Estimate, parameters: Parameters, mut chance: Chance) -> Self {
        let root = estimate.covariance.cholesky().map_or_else(Matrix3::zeros, |cholesky| cholesky.l());
        let Pose { position, heading } = estimate.world_from_robot;
        let draw = |chance: &mut Chance| {
            let off = root * Vector3::from_fn(|_, _| chance.normal());
            Pose::new(position.x + off.x, position.y + off.y, angle::wrap(heading + off.z))
        };
        let poses = (0..parameters.particles.max(1)).map(|_| draw(&mut chance)).collect();
        Self::new(poses, parameters, chance)
    }

    /// Particles anywhere in the box around a map, for a robot that does not know where it is.
    #[must_use]
    pub fn everywhere(map: &Map, parameters: Parameters, mut chance: Chance) -> Self {
        let poses = (0..parameters.particles.max(1)).map(|_| anywhere(map, &mut chance)).collect();
        Self::new(poses, parameters, chance)
    }

    fn new(poses: Vec<Pose>, parameters: Parameters, chance: Chance) -> Self {
        let weight = 1.0 / poses.len() as f64;
        let particle = |world_from_robot| Particle { world_from_robot, weight };
        Self { parameters, particles: poses.into_iter().map(particle).collect(), fits: None, chance }
    }

    /// All particles.
    #[must_use]
    pub fn particles(&self) -> &[Particle] {
        &self.particles
    }

    /// The number of particles of equal weight that would be as good: (Σw)² / Σw².
    #[must_use]
    pub fn effective(&self) -> f64 {
        1.0 / self.particles.iter().map(|particle| particle.weight * particle.weight).sum::<f64>()
    }

    /// Moves them all by the odometry's motion of the robot since the last time: its new frame in its old one.
    pub fn advance(&mut self, then_from_now: &Pose) {
        let [first, displacement, second] = turn_way_turn(then_from_now);
        let [a1, a2, a3, a4] = self.parameters.alphas;
        let sd_of_turn = |turn: f64| math::sqrt(a1 * turn * turn + a2 * displacement * displacement);
        let (sd_first, sd_second) = (sd_of_turn(first), sd_of_turn(second));
        let sd_displacement =
            math::sqrt(a3 * displacement * displacement + a4 * (first * first + second * second));
        for particle in &mut self.particles {
            let first = first + sd_first * self.chance.normal();
            let displacement = displacement + sd_displacement * self.chance.normal();
            let second = second + sd_second * self.chance.normal();
            let (sin, cos) = math::sin_cos(first);
            let moved = Pose::new(displacement * cos, displacement * sin, first + second);
            particle.world_from_robot = particle.world_from_robot.compose(&moved);
        }
    }

    /// Weighs them by a scan that was taken where they are now, and resamples them if that is due.
    ///
    /// # Panics
    /// If the scan has no rays.
    pub fn see(&mut self, map: &Map, scan: &Scan) {
        let scan = scan.thinned(self.parameters.beams);
        let logs = self.logs_of_likelihoods(map, &scan);
        let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut fit = 0.0;
        for (particle, log) in self.particles.iter_mut().zip(&logs) {
            fit += particle.weight * math::exp(log / scan.distances_m.len() as f64);
            particle.weight *= math::exp(log - most);
        }
        let sum: f64 = self.particles.iter().map(|particle| particle.weight).sum();
        let even = 1.0 / self.particles.len() as f64;
        // The sum may be 0 where the most likely particle had no weight left.
        self.particles.iter_mut().for_each(|p| p.weight = if sum > 0.0 { p.weight / sum } else { even });
        let strangers = self.strangers(fit);
        if strangers > 0.0 || self.effective() < self.parameters.resample_below * self.particles.len() as f64
        {
            self.resample(map, strangers);
        }
    }

    /// The pose of the place where most of them are, and how they are spread there.
    #[must_use]
    pub fn estimate(&self) -> Estimate {
        let mut cells = BTreeMap::new();
        for particle in &self.particles {
            *cells.entry(cell(&particle.world_from_robot)).or_insert(0.0) += particle.weight;
        }
        let heaviest = cells.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(cell, _)| cell);
        let (seed, _) = spread(&self.particles, |pose| Some(cell(pose)) == heaviest);
        let (world_from_robot, covariance) = spread(&self.particles, |pose| is_near(&seed, pose));
        Estimate { world_from_robot, covariance }
    }

    /// The fraction of all weight that is near an estimate.
    #[must_use]
    pub fn share(&self, estimate: &Estimate) -> f64 {
        let near = |particle: &&Particle| is_near(&estimate.world_from_robot, &particle.world_from_robot);
        self.particles.iter().filter(near).map(|particle| particle.weight).sum()
    }

    fn logs_of_likelihoods(&self, map: &Map, scan: &Scan) -> Vec<f64> {
        let Parameters { noise_m, noise_ratio, outliers, .. } = self.parameters;
        let laser = VirtualLaser::like(scan);
        let mut virtual_m = vec![0.0; laser.rays()];
        let log = |particle: &Particle| {
            laser.look(map, &particle.world_from_robot, &mut virtual_m);
            let beam = |(measured, expected): (&f64, &f64)| {
                if measured.is_nan() {
                    return 0.0;
                }
                let (measured, expected) = (measured.min(scan.range_m), expected.min(scan.range_m));
                let variance = noise_m * noise_m + noise_ratio * noise_ratio * measured * measured;
                let off = expected - measured;
                math::ln((1.0 - outliers) * math::exp(-0.5 * off * off / variance) + outliers)
            };
            scan.distances_m.iter().zip(&virtual_m).map(beam).sum()
        };
        self.particles.iter().map(log).collect()
    }

    /// The fraction of the particles that are to be put anywhere, after a scan with this fit.
    fn strangers(&mut self, fit: f64) -> f64 {
        let Parameters { slow, fast, .. } = self.parameters;
        let fits = self.fits.get_or_insert(Fits { slow: fit, fast: fit });
        fits.slow += slow * (fit - fits.slow);
        fits.fast += fast * (fit - fits.fast);
        if slow > 0.0 { (1.0 - fits.fast / fits.slow).max(0.0) } else { 0.0 }
    }

    /// Draws as many as there are: evenly along their weights, but for some strangers.
    fn resample(&mut self, map: &Map, strangers: f64) {
        let even = 1.0 / self.particles.len() as f64;
        let start = self.chance.uniform();
        let (mut i, mut sum) = (0, self.particles[0].weight);
        let mut drawn = Vec::with_capacity(self.particles.len());
        for k in 0..self.particles.len() {
            let mark = (k as f64 + start) * even;
            while sum < mark && i + 1 < self.particles.len() {
                i += 1;
                sum += self.particles[i].weight;
            }
            let is_stranger = strangers > 0.0 && self.chance.happens(strangers);
            let pose = if is_stranger {
                anywhere(map, &mut self.chance)
            } else {
                self.particles[i].world_from_robot
            };
            drawn.push(Particle { world_from_robot: pose, weight: even });
        }
        self.particles = drawn;
    }
}

/// A motion as a turn, a way and another turn. Where there is hardly a way its direction means nothing.
fn turn_way_turn(then_from_now: &Pose) -> [f64; 3] {
    let Pose { position, heading } = then_from_now;
    let displacement = math::hypot(position.x, position.y);
    if displacement < 1e-3 {
        return [0.0, displacement, *heading];
    }
    let forwards = if position.x < 0.0 { -1.0 } else { 1.0 };
    let first = math::atan2(forwards * position.y, forwards * position.x);
    [first, forwards * displacement, angle::difference(*heading, first)]
}

/// Any pose in the box around a map; the origin if the map is empty.
fn anywhere(map: &Map, chance: &mut Chance) -> Pose {
    let Some(bounds) = map.index().bounds() else { return Pose::new(0.0, 0.0, 0.0) };
    let size = bounds.size();
    let (x, y) = (bounds.min.x + size.x * chance.uniform(), bounds.min.y + size.y * chance.uniform());
    Pose::new(x, y, angle::wrap(TAU * chance.uniform()))
}

/// The mean of some of the particles, and their covariance. The mean of headings is that of their directions.
fn spread(particles: &[Particle], is_one: impl Fn(&Pose) -> bool) -> (Pose, Matrix3<f64>) {
    let some = || particles.iter().filter(|particle| is_one(&particle.world_from_robot));
    let (mut sum, mut place, mut facing) = (0.0, Vector3::zeros(), Vector3::zeros());
    for Particle { world_from_robot: Pose { position, heading }, weight } in some() {
        let (sin, cos) = math::sin_cos(*heading);
        sum += weight;
        place += Vector3::new(position.x, position.y, 0.0) * *weight;
        facing += Vector3::new(cos, sin, 0.0) * *weight;
    }
    let mean = Pose::new(place.x / sum, place.y / sum, math::atan2(facing.y, facing.x));
    let mut covariance = Matrix3::zeros();
    for Particle { world_from_robot, weight } in some() {
        let off = world_from_robot.position - mean.position;
        let turn = angle::difference(world_from_robot.heading, mean.heading);
        let error = Vector3::new(off.x, off.y, turn);
        covariance += error * error.transpose() * (*weight / sum);
    }
    (mean, covariance)
}

/// Whether two poses may be one.
fn is_near(a: &Pose, b: &Pose) -> bool {
    (a.position - b.position).norm() < NEAR_M && angle::difference(a.heading, b.heading).abs() < NEAR_RAD
}

/// The cell of a coarse grid of poses.
fn cell(pose: &Pose) -> [i64; 3] {
    let place = |value: f64, size: f64| math::floor(value / size) as i64;
    [place(pose.position.x, NEAR_M), place(pose.position.y, NEAR_M), place(pose.heading, NEAR_RAD)]
}

/// The distance within which particles belong together, in metres.
const NEAR_M: f64 = 0.5;

/// The angle within which particles belong together, in radians.
const NEAR_RAD: f64 = 0.5;

#[cfg(test)]
mod tests;
