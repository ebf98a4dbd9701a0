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
    /// Its motion, in m/s and rad/s.
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

    /// How far at most the sensor goes, in metres, in so many seconds of the first `within_s`. Its robot goes ahead on a
    /// straight line that turns with it.
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
    /// Where the sensor is at an instant in the middle.
    pose: Pose,
    /// No ray starts farther from there, in metres.
    pub(crate) stray_m: f64,
    /// By no more has the fan turned from there, in radians.
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
        let none = [0.0; MOST_RAYS];
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

    /// Where the sensor is at an instant in the middle.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.pose
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

    /// Where the rays start, x and y, and where they go, cosines and sines.
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
        let (from, body) = (carried.robot, carried.body);
        let relative = &bundle.fan.relative()[bundle.rays.clone()];
        let (xs, ys) = (bundle.x.iter_mut(), bundle.y.iter_mut());
        let (coss, sins) = (bundle.cos.iter_mut(), bundle.sin.iter_mut());
        let mut takes_care = false;
        for (((((x, y), to_cos), to_sin), relative), &after_s) in
            xs.zip(ys).zip(coss).zip(sins).zip(relative).zip(after_s)
        {
            let mut pose = Lane::new(from.heading + body.turn * after_s);
            pose.x = from.position.x + body.forward * after_s * pose.cos;
            pose.y = from.position.y + body.forward * after_s * pose.sin;
            if let Some(turret) = &carried.turret {
                pose = pose.compose(turret);
            }
            let pose = pose.compose(&carried.sensor);
            takes_care |= pose.takes_care;
            (*x, *y) = (pose.x, pose.y);
            *to_cos = pose.cos * relative.cos - pose.sin * relative.sin;
            *to_sin = pose.sin * relative.cos + pose.cos * relative.sin;
        }
        takes_care
    }
}

/// A pose with its direction at hand.
#[derive(Clone, Copy)]
struct Lane {
    x: f64,
    y: f64,
    heading: f64,
    cos: f64,
    sin: f64,
    takes_care: bool,
}

impl Lane {
    /// At the origin, with a heading that is yet to be wrapped: [`angle::wrap`] of less than a turn.
    #[inline(always)]
    fn new(angle: f64) -> Self {
        let turns = if angle > PI { TAU } else { 0.0 };
        let turns = if angle <= -PI { -TAU } else { turns };
        let heading = angle - turns;
        let (sin, cos) = trigonometry::sin_cos(heading);
        let is_small = (angle > -9.0) & (angle < 9.0);
        Self {
            x: 0.0,
            y: 0.0,
            heading,
            cos,
            sin,
            takes_care: !is_small | trigonometry::is_near_axis(heading),
        }
    }

    /// [`Pose::compose`].
    #[inline(always)]
    fn compose(self, other: &Pose) -> Self {
        let (x, y) = (other.position.x, other.position.y);
        let to = Self::new(self.heading + other.heading);
        Self {
            x: self.x + (self.cos * x - self.sin * y),
            y: self.y + (self.sin * x + self.cos * y),
            takes_care: self.takes_care | to.takes_care,
            ..to
        }
    }
}

/// So many rays are taken from a robot within a tick, or within a part of it.
const MOST_RAYS: usize = 128;

/// A generous bound on the relative rounding errors here.
const ROUNDING: f64 = 1e-12;
