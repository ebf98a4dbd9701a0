//! Rays that are taken one after the other while a robot carries their sensor on, at constant speed and turn rate.
//!
//! [`Carried::place`] is where the sensor is at one instant; a [`Bundle`] has the rays of many instants, with the same bits,
//! computed in loops that a compiler can make vectors of.

use core::f64::consts::{PI, TAU};
use core::ops::Range;

use crate::fan::Fan;
use crate::pose::{Direction, Point, Pose};
use crate::ray::Ray;
use crate::trigonometry;
use crate::vectors::{Work, with_vectors};
use crate::wheels::Twist;
use crate::{angle, math};

/// A sensor on a robot that drives on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carried {
    /// World from robot at the instant from which time is counted.
    pub robot: Pose,
    /// The motion of the body, in m/s and rad/s.
    pub body: Twist,
    /// Robot from turret, of a sensor on one.
    pub turret: Option<Pose>,
    /// Robot from sensor; on a turret, turret from sensor.
    pub sensor: Pose,
}

impl Carried {
    /// World from sensor after so many seconds.
    #[must_use]
    pub fn place(&self, after_s: f64) -> Pose {
        let mut robot = self.robot;
        robot.heading = angle::wrap(robot.heading + self.body.turn * after_s);
        let (sin, cos) = math::sin_cos(robot.heading);
        robot.position.x += self.body.forward * after_s * cos;
        robot.position.y += self.body.forward * after_s * sin;
        let carrier = self.turret.map_or(robot, |turret| robot.compose(&turret));
        carrier.compose(&self.sensor)
    }

    /// The farthest that the sensor goes, in metres, in so many seconds of the first `within_s`. Its robot goes ahead
    /// on a straight line that turns with it.
    fn way_m(&self, seconds: f64, within_s: f64) -> f64 {
        let (forward, turn) = (self.body.forward.abs(), self.body.turn.abs());
        let turret_m = self.turret.map_or(0.0, |turret| turret.position.coords.abs().sum());
        let arm_m = forward * within_s + turret_m + self.sensor.position.coords.abs().sum();
        let way_m = (forward + turn * arm_m) * seconds;
        way_m + ROUNDING * (self.robot.position.coords.abs().sum() + arm_m)
    }
}

/// Some rays of a fan, each from where its sensor is when it is taken.
#[derive(Clone, Debug)]
pub struct Bundle<'a> {
    fan: &'a Fan,
    rays: Range<usize>,
    /// The sensor's pose at an instant in the middle.
    pose: Pose,
    /// No ray starts farther from there, in metres.
    pub(crate) stray_m: f64,
    /// The most that the fan has turned from there, in radians.
    pub(crate) bent_rad: f64,
    x: [f64; MOST_RAYS],
    y: [f64; MOST_RAYS],
    cos: [f64; MOST_RAYS],
    sin: [f64; MOST_RAYS],
}

impl<'a> Bundle<'a> {
    /// No bundle has more rays.
    pub const MOST_RAYS: usize = MOST_RAYS;

    /// The rays of these places in the fan of a sensor that is carried, each taken after so many seconds.
    ///
    /// # Panics
    ///
    /// If there is no ray, or more than [`MOST_RAYS`](Self::MOST_RAYS), if there are not as many instants, or if the fan
    /// has not all of the rays.
    #[must_use]
    pub fn new(carried: &Carried, fan: &'a Fan, rays: Range<usize>, after_s: &[f64]) -> Self {
        let n = after_s.len();
        assert!(
            (1..=MOST_RAYS).contains(&n) && rays.len() == n && rays.end <= fan.len(),
            "an instant for each ray"
        );
        let middle_s = after_s[n / 2];
        let bounds = after_s.iter().fold((middle_s, middle_s), |(from, to), &s| {
            (if s < from { s } else { from }, if s > to { s } else { to })
        });
        let seconds = (bounds.1 - middle_s).max(middle_s - bounds.0);
        let within_s = bounds.0.abs().max(bounds.1.abs());
        // A ray that is not there is nowhere.
        let none = [f64::NAN; MOST_RAYS];
        let mut bundle = Self {
            fan,
            rays,
            pose: carried.place(middle_s),
            stray_m: carried.way_m(seconds, within_s),
            bent_rad: carried.body.turn.abs() * seconds,
            x: none,
            y: none,
            cos: none,
            sin: none,
        };
        if with_vectors(Fill { bundle: &mut bundle, carried, after_s }) {
            bundle.fill_one_by_one(carried, after_s);
        }
        bundle
    }

    /// The sensor's pose at an instant in the middle.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// No ray starts farther from the pose, in metres.
    #[must_use]
    pub fn stray_m(&self) -> f64 {
        self.stray_m
    }

    /// The fan that the rays are of.
    #[must_use]
    pub fn fan(&self) -> &'a Fan {
        self.fan
    }

    /// The places of the rays in the fan.
    #[must_use]
    pub fn places(&self) -> Range<usize> {
        self.rays.clone()
    }

    /// Ray `i` of the bundle, counted from 0.
    ///
    /// # Panics
    ///
    /// If there is no such ray.
    #[must_use]
    pub fn ray(&self, i: usize) -> Ray {
        let direction = Direction { cos: self.cos[i], sin: self.sin[i] };
        Ray { origin: Point::new(self.x[i], self.y[i]), direction }
    }

    /// The rays' origins, x and y, and their directions, cosines and sines.
    pub(crate) fn columns(&self) -> [&[f64]; 4] {
        let n = self.rays.len();
        [&self.x[..n], &self.y[..n], &self.cos[..n], &self.sin[..n]]
    }

    fn fill_one_by_one(&mut self, carried: &Carried, after_s: &[f64]) {
        for (i, &after_s) in after_s.iter().enumerate() {
            let pose = carried.place(after_s);
            let direction = pose.direction().rotate(self.fan.relative()[self.rays.start + i]);
            (self.x[i], self.y[i]) = (pose.position.x, pose.position.y);
            (self.cos[i], self.sin[i]) = (direction.cos, direction.sin);
        }
    }
}

/// [`Bundle::fill_one_by_one`], operation for operation.
struct Fill<'a, 'b> {
    bundle: &'a mut Bundle<'b>,
    carried: &'a Carried,
    after_s: &'a [f64],
}

impl Work for Fill<'_, '_> {
    /// Whether the angle of any takes more care than is taken here.
    type Output = bool;

    #[inline(always)]
    fn work(self) -> bool {
        let Self { bundle, carried, after_s } = self;
        let n = after_s.len();
        let (from, body) = (carried.robot, carried.body);
        let relative = &bundle.fan.relative()[bundle.rays.clone()];
        let mut headings = [0.0; MOST_RAYS];
        let mut poses = Poses {
            x: &mut bundle.x[..n],
            y: &mut bundle.y[..n],
            heading: &mut headings[..n],
            cos: &mut bundle.cos[..n],
            sin: &mut bundle.sin[..n],
            is_straight: body.turn == 0.0,
            take_care: false,
        };
        // One loop for each step: shorter ones are better made vectors of.
        for (heading, after_s) in poses.heading.iter_mut().zip(after_s) {
            *heading = from.heading + body.turn * after_s;
        }
        poses.turn();
        for ((x, cos), after_s) in poses.x.iter_mut().zip(&*poses.cos).zip(after_s) {
            *x = from.position.x + body.forward * after_s * cos;
        }
        for ((y, sin), after_s) in poses.y.iter_mut().zip(&*poses.sin).zip(after_s) {
            *y = from.position.y + body.forward * after_s * sin;
        }
        if let Some(turret) = &carried.turret {
            poses.compose(turret);
        }
        poses.compose(&carried.sensor);
        for ((cos, sin), relative) in poses.cos.iter_mut().zip(poses.sin.iter_mut()).zip(relative) {
            Direction { cos: *cos, sin: *sin } = Direction { cos: *cos, sin: *sin }.rotate(*relative);
        }
        poses.take_care
    }
}

/// Poses side by side, with their directions at hand.
struct Poses<'a> {
    x: &'a mut [f64],
    y: &'a mut [f64],
    heading: &'a mut [f64],
    cos: &'a mut [f64],
    sin: &'a mut [f64],
    /// Whether all have the same heading.
    is_straight: bool,
    /// Whether the direction of any is not right.
    take_care: bool,
}

impl Poses<'_> {
    /// [`Pose::compose`].
    #[inline(always)]
    fn compose(&mut self, other: &Pose) {
        let (ahead, left) = (other.position.x, other.position.y);
        for ((x, cos), sin) in self.x.iter_mut().zip(&*self.cos).zip(&*self.sin) {
            *x += cos * ahead - sin * left;
        }
        for ((y, cos), sin) in self.y.iter_mut().zip(&*self.cos).zip(&*self.sin) {
            *y += sin * ahead + cos * left;
        }
        for heading in &mut *self.heading {
            *heading += other.heading;
        }
        if other.heading == 0.0 {
            // The directions stay as they are, but for that of a negative zero.
            self.sin.iter_mut().for_each(|sin| *sin += 0.0);
        } else {
            self.turn();
        }
    }

    /// Wraps the headings and finds the directions: [`angle::wrap`] of what is less than a turn outside.
    #[inline(always)]
    fn turn(&mut self) {
        let mut take_care = self.take_care;
        for heading in &mut *self.heading {
            let angle = *heading;
            let turns = if angle > PI { TAU } else { 0.0 };
            let turns = if angle <= -PI { -TAU } else { turns };
            *heading = angle - turns;
            let is_small = (angle > -9.0) & (angle < 9.0);
            take_care |= !is_small;
        }
        if self.is_straight {
            let (sin, cos) = math::sin_cos(self.heading[0]);
            self.sin.fill(sin);
            self.cos.fill(cos);
            self.take_care = take_care;
            return;
        }
        for ((heading, cos), sin) in self.heading.iter().zip(&mut *self.cos).zip(&mut *self.sin) {
            let is_near_axis;
            (*sin, *cos, is_near_axis) = trigonometry::sin_cos(*heading);
            take_care |= is_near_axis;
        }
        self.take_care = take_care;
    }
}

/// The most rays that are taken from a robot within a tick, or within a part of it.
const MOST_RAYS: usize = 128;

/// A generous bound on the relative rounding errors here.
const ROUNDING: f64 = 1e-12;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bundle_has_the_poses_of_its_instants_also_along_the_axes() {
        let fan = Fan::new(4.0, 100);
        let after_s: [f64; 100] = core::array::from_fn(|i| 1e-4 * i as f64);
        let headings = [0.0, 0.3, PI / 2.0, -PI / 2.0, PI, -PI, PI.next_down(), 1e-300, -0.0];
        let turret = Pose::new(0.1, -0.2, PI / 2.0);
        for heading in headings {
            for turn in [0.0, -0.0, 1e-9, -0.7] {
                for turret in [None, Some(turret)] {
                    let carried = Carried {
                        robot: Pose::new(1.0, 2.0, heading),
                        body: Twist { forward: 0.5, turn },
                        turret,
                        sensor: Pose::new(0.05, 0.01, 0.0),
                    };
                    let bundle = Bundle::new(&carried, &fan, 0..100, &after_s);
                    let mut slow = bundle.clone();
                    slow.fill_one_by_one(&carried, &after_s);
                    let bits = |bundle: &Bundle<'_>| {
                        bundle
                            .columns()
                            .map(|column| column.iter().map(|x| x.to_bits()).collect::<alloc::vec::Vec<_>>())
                    };
                    assert_eq!(bits(&bundle), bits(&slow), "{carried:?}");
                }
            }
        }
    }
}
