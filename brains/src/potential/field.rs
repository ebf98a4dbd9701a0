//! Potentials, and the direction down from them.

use baudbot_geometry::{Point, Vector, math};
use serde::Deserialize;

/// One potential, Eq. (6.1): an ellipse of hills or, with a negative α, of valleys.
///
/// ```text
/// φ(x, y) = α exp(−((x − x_p) / β)² − ((y − y_p) / γ)²)
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Potential {
    /// The place x_p along x, in metres.
    pub x_m: f64,
    /// The place y_p along y, in metres.
    pub y_m: f64,
    /// α: its height; negative attracts.
    pub alpha: f64,
    /// β: how far it reaches along x, in metres.
    pub beta_m: f64,
    /// γ: how far it reaches along y, in metres.
    pub gamma_m: f64,
}

/// The sum of potentials, Eq. (6.2).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Field {
    /// The potentials whose sum the field is.
    pub potentials: Vec<Potential>,
}

impl Potential {
    /// The height of the potential at a place.
    pub fn height(&self, at: Point) -> f64 {
        let (u, v) = ((at.x - self.x_m) / self.beta_m, (at.y - self.y_m) / self.gamma_m);
        self.alpha * math::exp(-u * u - v * v)
    }

    /// The gradient of the potential at a place, per metre.
    pub fn gradient(&self, at: Point) -> Vector {
        let (x, y) = (at.x - self.x_m, at.y - self.y_m);
        let height = self.height(at);
        Vector::new(
            -2.0 * x / (self.beta_m * self.beta_m) * height,
            -2.0 * y / (self.gamma_m * self.gamma_m) * height,
        )
    }

    /// The centre of the hill.
    pub fn center(&self) -> Point {
        Point::new(self.x_m, self.y_m)
    }
}

impl Field {
    /// The height of the field at a place.
    pub fn height(&self, at: Point) -> f64 {
        self.potentials.iter().map(|potential| potential.height(at)).sum()
    }

    /// The gradient of the field at a place, per metre.
    pub fn gradient(&self, at: Point) -> Vector {
        self.potentials.iter().fold(Vector::zeros(), |sum, potential| sum + potential.gradient(at))
    }

    /// The direction down, Eq. (6.3), of length 1; nowhere where the gradient is 0, which (6.3) leaves open.
    pub fn direction(&self, at: Point) -> Vector {
        let gradient = self.gradient(at);
        let length = math::hypot(gradient.x, gradient.y);
        if length > 0.0 { -gradient / length } else { Vector::zeros() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn potential([x_m, y_m, alpha, beta_m, gamma_m]: [f64; 5]) -> Potential {
        Potential { x_m, y_m, alpha, beta_m, gamma_m }
    }

    /// The goal at (2, 0) and a wedge of three, which Fig. 6.13 shows and leaves open.
    pub(crate) fn wedge() -> Field {
        let hills = [[1.0, 0.0], [0.8, 0.3], [0.8, -0.3]];
        let hills = hills.map(|[x, y]| potential([x, y, 0.6, 0.25, 0.25]));
        let goal = potential([2.0, 0.0, -1.0, 3.0, 3.0]);
        Field { potentials: [goal].into_iter().chain(hills).collect() }
    }

    fn waypoint(x_m: f64, y_m: f64) -> Potential {
        potential([x_m, y_m, -1.2, 0.45, 0.45])
    }

    fn alone(start: Point) -> (Point, Option<f64>) {
        follow(&[], start, 0.1, 60.0)
    }

    /// A point that follows the field at 0.2 m/s: where it is after so long, and when it came within 0.05 m of the goal.
    /// Waypoints attract one after the other; each goes when the point is within `removed_m`.
    fn follow(waypoints: &[Potential], start: Point, removed_m: f64, for_s: f64) -> (Point, Option<f64>) {
        let (mut at, dt_s, mut waypoints) = (start, 0.01, waypoints);
        for step in 0..(for_s / dt_s) as u32 {
            if math::hypot(at.x - 2.0, at.y) < 0.05 {
                return (at, Some(f64::from(step) * dt_s));
            }
            if let [next, later @ ..] = waypoints {
                let offset = next.center() - at;
                waypoints = if math::hypot(offset.x, offset.y) < removed_m { later } else { waypoints };
            }
            let mut field = wedge();
            field.potentials.extend(waypoints.first());
            at += field.direction(at) * 0.2 * dt_s;
        }
        (at, None)
    }

    /// (6.1), (6.2).
    #[test]
    fn a_potential_has_the_height_and_the_gradient_of_its_equation() {
        let one = potential([0.0, 0.0, 3.0, 2.0, 4.0]);
        let at = Point::new(1.0, 2.0);
        assert!((one.height(at) - 1.8195919791).abs() < 1e-10);
        let gradient = one.gradient(at);
        assert!((gradient.x + 0.9097959896).abs() < 1e-10 && (gradient.y + 0.4548979948).abs() < 1e-10);
    }

    /// The local minimum of Fig. 6.13.
    #[test]
    fn the_wedge_has_a_minimum_in_front_of_it_and_the_goal_behind_it() {
        let field = wedge();
        for (x, minimum) in [(0.385244, true), (0.937204, false), (2.000010, true)] {
            let slope = |x: f64| field.gradient(Point::new(x, 0.0)).x;
            let (before, after) = (slope(x - 2e-6), slope(x + 2e-6));
            assert!(before * after < 0.0 && (before < 0.0) == minimum, "{x}: {before} {after}");
        }
        assert!((field.height(Point::new(0.385244, 0.0)) + 0.728925).abs() < 1e-6);
        let aside = field.height(Point::new(0.385244, 0.01));
        assert!(aside > field.height(Point::new(0.385244, 0.0)), "a minimum across, too");
    }

    #[test]
    fn who_comes_along_the_axis_locks_and_who_comes_from_aside_does_not() {
        let (at, reached_s) = alone(Point::new(-1.0, 0.0));
        assert!(reached_s.is_none() && (at.x - 0.3852).abs() < 0.002 && at.y.abs() < 0.002, "{at}");
        for (start, wanted_s) in [((-1.0, 1.0), 16.99), ((0.0, 1.5), 12.35)] {
            let (_, reached_s) = alone(Point::new(start.0, start.1));
            let reached_s = reached_s.expect("it gets there");
            assert!((reached_s - wanted_s).abs() < 0.02, "{start:?}: {reached_s}");
        }
    }

    #[test]
    fn of_81_starts_29_lock() {
        let locks = (-40..=40_i32).filter(|&i| alone(Point::new(-1.0, 0.05 * f64::from(i))).1.is_none());
        let locks: Vec<_> = locks.collect();
        assert_eq!(locks.len(), 29);
        assert!(locks.iter().all(|i| i.abs() <= 14));
    }

    #[test]
    fn waypoints_lead_round_the_wedge_if_they_are_removed_in_time() {
        let two = [waypoint(0.45, 0.75), waypoint(1.2, 0.75)];
        let (_, reached_s) = follow(&two, Point::new(-1.0, 0.0), 0.1, 60.0);
        assert!((reached_s.expect("it gets there") - 17.70).abs() < 0.02, "{reached_s:?}");
        // Never removed, the first one holds it for good.
        let (at, reached_s) = follow(&two, Point::new(-1.0, 0.0), 0.0, 100.0);
        assert!(reached_s.is_none() && (at.x - 0.467).abs() < 0.002 && (at.y - 0.745).abs() < 0.002, "{at}");
    }

    /// (6.3).
    #[test]
    fn where_there_is_no_slope_there_is_no_direction() {
        let field = Field { potentials: vec![potential([1.0, 1.0, 2.0, 1.0, 1.0])] };
        assert_eq!(field.direction(Point::new(1.0, 1.0)), Vector::zeros());
        assert_eq!(Field::default().direction(Point::origin()), Vector::zeros());
    }
}
