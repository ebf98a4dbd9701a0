//! Approximate angles: good enough to leave out rays that a shape is far from.

use core::f64::consts::{FRAC_PI_2, PI, TAU};
use core::ops::Range;

use crate::fan::Fan;
use crate::pose::{Direction, Vector};

/// About where a few rays go.
#[derive(Clone, Copy)]
pub(super) enum Cone {
    /// Nowhere but between two of them.
    Narrow(Sides),
    /// Hardly anything is beside them.
    Wide,
}

/// The outermost of a few rays, and how far they may be from these.
#[derive(Clone, Copy)]
pub(super) struct Sides {
    middle: Direction,
    right: Direction,
    left: Direction,
    about: f64,
}

impl Cone {
    /// A `Cone` of these rays, if any, of the fan of a sensor with this heading, each turned by no more than
    /// `bent_rad`.
    pub(super) fn of(heading: f64, fan: &Fan, rays: &Range<usize>, bent_rad: f64) -> Self {
        if rays.is_empty() {
            return Self::Wide;
        }
        let (first, last) = (rays.start, rays.end - 1);
        let width = fan.kappas()[last] - fan.kappas()[first] + 2.0 * bent_rad;
        let is_narrow = width <= MOST_OF_CONE_RAD;
        if !is_narrow {
            return Self::Wide;
        }
        let forward = about_direction(heading);
        let (right, left) = (forward.rotate(fan.relative()[first]), forward.rotate(fan.relative()[last]));
        let middle = Direction { cos: right.cos + left.cos, sin: right.sin + left.sin };
        Self::Narrow(Sides { middle, right, left, about: ABOUT + bent_rad })
    }

    /// Whether two points, with so much around them, are to the right of all rays, to the left of all, or behind.
    pub(super) fn has_beside(&self, a: &Vector, b: &Vector, around: f64) -> bool {
        match self {
            Self::Narrow(sides) => sides.have_beside(a, b, around),
            Self::Wide => false,
        }
    }
}

impl Sides {
    /// Whether two points, with so much around them, are to the right of both, to the left of both, or behind.
    #[inline(always)]
    pub(super) fn have_beside(&self, a: &Vector, b: &Vector, around: f64) -> bool {
        let Self { middle, right, left, about } = self;
        let margin = |v: &Vector| around + about * (v.x.abs() + v.y.abs());
        let (a_margin, b_margin) = (margin(a), margin(b));
        let is_right = |v: &Vector, margin: f64| right.cos * v.y - right.sin * v.x < -margin;
        let is_left = |v: &Vector, margin: f64| left.cos * v.y - left.sin * v.x > margin;
        let is_behind = |v: &Vector, margin: f64| middle.cos * v.x + middle.sin * v.y < -2.0 * margin;
        (is_right(a, a_margin) & is_right(b, b_margin))
            | (is_left(a, a_margin) & is_left(b, b_margin))
            | (is_behind(a, a_margin) & is_behind(b, b_margin))
    }
}

/// The angle of (`x`, `y`) in radians, to 0.00002 (Abramowitz and Stegun, 4.4.49): enough to choose rays by.
pub(super) fn about_atan2(y: f64, x: f64) -> f64 {
    let (ax, ay) = (x.abs(), y.abs());
    let (small, large) = if ay <= ax { (ay, ax) } else { (ax, ay) };
    let t = if large > 0.0 { small / large } else { 0.0 };
    let t2 = t * t;
    let atan =
        t * (0.999_866_0 + t2 * (-0.330_299_5 + t2 * (0.180_141_0 + t2 * (-0.085_133_0 + t2 * 0.020_835_1))));
    let atan = if ay <= ax { atan } else { FRAC_PI_2 - atan };
    let atan = if x < 0.0 { PI - atan } else { atan };
    if y < 0.0 { -atan } else { atan }
}

/// The direction at an angle, to 0.0012 in each part: parabolas instead of waves.
fn about_direction(angle_rad: f64) -> Direction {
    let sin = |x: f64| {
        let y = x * (4.0 / PI - 4.0 / (PI * PI) * x.abs());
        y + 0.225 * y * (y.abs() - 1.0)
    };
    let angle_rad = wrapped(angle_rad);
    Direction { cos: sin(wrapped(angle_rad + FRAC_PI_2)), sin: sin(angle_rad) }
}

/// Into [-pi, pi], from less than a turn outside of it.
pub(super) fn wrapped(angle_rad: f64) -> f64 {
    if angle_rad > PI {
        angle_rad - TAU
    } else if angle_rad < -PI {
        angle_rad + TAU
    } else {
        angle_rad
    }
}

/// More than the errors of [`about_direction`], of the edges that are turned by it, and of rays.
const ABOUT: f64 = 0.006;

/// A cone that is wider than this, or almost, is no cone.
const MOST_OF_CONE_RAD: f64 = 3.0;
