//! Around what is on no map: the planned path is the nominal path of Section 6.2.2, and a potential field bends it. A moving obstacle is one that is new.
//!
//! ```text
//! Φ(r) = −exp(−|r − g|² / 2L²) + Σᵢ α exp(−|r − oᵢ|² / β²)        Wahde 2016, Eqs. (6.1), (6.2)
//! ```
//!
//! The goal g moves along the path of the grid, the look-ahead distance L in front of the robot: there its pull is greatest. Each oᵢ is the nearest
//! point of an object that the laser sees, a wall of the map or something that walks. The direction is that of (6.3), the steering that of (6.4) to
//! (6.7).
//!
//! Deviations: the notes leave the detection of moving obstacles open. Here points of a scan are something new if they are farther from every wall of the map
//! than a body's radius. While nothing new is near, there is no field, and the robot follows the path as it does without.

use baudbot_brain::{Body, Turn};
use baudbot_geometry::{Point, Vector, math};
use serde::Deserialize;

use crate::navigation::Floor;
use crate::parameter::{ParameterError, check_not_negative, check_positive, for_body};
use crate::potential::{Field, Potential};
use crate::process::Beliefs;
use crate::vfh::sight::{self, Seen, Sight};

/// The hills of what is seen.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// α: the height of each hill; the goal is as deep as 1. Without hills, 0, the path is followed blindly.
    pub alpha: f64,
    /// β: how far each hill reaches, in metres. By default a diameter of the body.
    pub reach_m: Option<f64>,
    /// Objects that are farther away have no hill, in metres.
    pub far_m: f64,
    /// Its lasers.
    pub sight: sight::Parameters,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { alpha: 1.0, reach_m: None, far_m: 1.5, sight: sight::Parameters::default() }
    }
}

/// The objects of the last scan.
#[derive(Clone, Debug)]
pub(super) struct Around {
    sight: Sight,
    alpha: f64,
    reach_m: f64,
    far_m: f64,
    radius_m: f64,
    look_ahead_m: f64,
    seen_ns: u64,
    /// The nearest points of objects.
    objects: Vec<Point>,
    /// Whether one of them is on no map.
    has_news: bool,
}

impl Around {
    /// An `Around` of a robot with this body, for paths with this look-ahead distance, in metres.
    ///
    /// # Errors
    /// If a parameter is invalid, or the robot has no laser.
    pub(super) fn new(p: &Parameters, body: &Body, look_ahead_m: f64) -> Result<Self, ParameterError> {
        let reach_m = p.reach_m.unwrap_or_else(|| for_body(0.4, body.radius_m));
        check_positive([("field.reach_m", reach_m), ("field.far_m", p.far_m)])?;
        check_not_negative([("field.alpha", p.alpha)])?;
        let sight = Sight::new(&p.sight, body)?;
        if !sight.tells_walkers() {
            let problem = "the robot needs lasers for it, and no other sensors in `sight.names`";
            return Err(ParameterError::value("field", problem));
        }
        let (alpha, far_m, radius_m) = (p.alpha, p.far_m, body.radius_m);
        let (objects, has_news) = (Vec::new(), false);
        Ok(Self { sight, alpha, reach_m, far_m, radius_m, look_ahead_m, seen_ns: 0, objects, has_news })
    }

    /// Takes in the scans of a turn.
    pub(super) fn look(&mut self, turn: &Turn, beliefs: &Beliefs, floor: &Floor) {
        for seen in self.sight.look(turn, beliefs) {
            self.take(&seen, floor);
        }
        // What was seen long ago may be elsewhere.
        if turn.at_ns.saturating_sub(self.seen_ns) > STALE_NS {
            (self.objects, self.has_news) = (Vec::new(), false);
        }
    }

    /// Objects are runs of rays whose ends are near each other.
    fn take(&mut self, seen: &Seen, floor: &Floor) {
        (self.seen_ns, self.objects, self.has_news) = (seen.at_ns, Vec::new(), false);
        let world_from_laser = seen.world_from_robot.compose(&seen.scan.robot_from_laser);
        let mut before: Option<(Point, bool)> = None;
        let mut nearest_m = f64::INFINITY;
        for (i, &distance_m) in seen.scan.distances_m.iter().enumerate() {
            if distance_m.is_nan() || distance_m > self.far_m {
                continue;
            }
            let bearing_rad = seen.scan.bearing_rad(i);
            let ray = Vector::new(math::cos(bearing_rad), math::sin(bearing_rad)) * distance_m;
            let end = world_from_laser.transform(Point::origin() + ray);
            let is_new = floor.wall_m(end) > self.radius_m;
            let goes_on = |(other, was_new): (Point, bool)| {
                is_new == was_new && (end - other).norm() < 2.0 * self.radius_m
            };
            if !before.is_some_and(goes_on) {
                self.objects.push(end);
                nearest_m = distance_m;
            } else if distance_m < nearest_m {
                nearest_m = distance_m;
                self.objects.pop();
                self.objects.push(end);
            }
            self.has_news |= is_new;
            before = Some((end, is_new));
        }
    }

    /// The direction down, if something new is near.
    pub(super) fn heading_rad(&self, here: Point, target: Point) -> Option<f64> {
        if !self.has_news || self.alpha == 0.0 {
            return None;
        }
        let potential = |at: Point, alpha: f64, reach_m: f64| Potential {
            x_m: at.x,
            y_m: at.y,
            alpha,
            beta_m: reach_m,
            gamma_m: reach_m,
        };
        let goal = potential(target, -1.0, math::sqrt(2.0) * self.look_ahead_m);
        let hills = self.objects.iter().map(|&object| potential(object, self.alpha, self.reach_m));
        let down = Field { potentials: [goal].into_iter().chain(hills).collect() }.direction(here);
        (down != Vector::zeros()).then(|| math::atan2(down.y, down.x))
    }
}

/// Objects are forgotten after half a second without a scan, in nanoseconds.
const STALE_NS: u64 = 500_000_000;

#[cfg(test)]
mod tests {
    use baudbot_geometry::Pose;

    use super::*;
    use crate::navigation::Method;
    use crate::scan::Scan;
    use crate::test_body::body;

    /// A robot of 0.2 m in the middle of a room of 6 m, that sees a disc of 0.2 m.
    fn around(disc: Point) -> Around {
        let walls =
            [[-3.0, -3.0, 3.0, -3.0], [3.0, -3.0, 3.0, 3.0], [3.0, 3.0, -3.0, 3.0], [-3.0, 3.0, -3.0, -3.0]];
        let floor = Floor::new(&walls, 0.1, 0.3, Method::ThetaStar).unwrap();
        let parameters = Parameters { far_m: 4.0, ..Parameters::default() };
        let mut around = Around::new(&parameters, &body(&[("laser", "laser", 0.0)]), 0.4).unwrap();
        let mut scan = Scan {
            robot_from_laser: Pose::new(0.0, 0.0, 0.0),
            opening_rad: 4.0,
            range_m: 4.0,
            distances_m: vec![f64::INFINITY; 401],
        };
        for i in 0..401 {
            let bearing_rad = scan.bearing_rad(i);
            let ray = Vector::new(math::cos(bearing_rad), math::sin(bearing_rad));
            let wall_m = 3.0 / ray.x.abs().max(ray.y.abs());
            let along = ray.dot(&disc.coords);
            let aside2 = disc.coords.norm_squared() - along * along;
            let disc_m = (aside2 < 0.04 && along > 0.0).then(|| along - math::sqrt(0.04 - aside2));
            scan.distances_m[i] = disc_m.unwrap_or(wall_m);
        }
        let seen = Seen { at_ns: 1, scan, world_from_robot: Pose::new(0.0, 0.0, 0.0) };
        around.take(&seen, &floor);
        around
    }

    #[test]
    fn without_a_laser_there_is_no_field() {
        let error = Around::new(&Parameters::default(), &body(&[("left", "sonar", 0.0)]), 0.4).unwrap_err();
        assert!(error.to_string().starts_with("field: the robot needs lasers"), "{error}");
        let none = Parameters { far_m: 0.0, ..Parameters::default() };
        let error = Around::new(&none, &body(&[("laser", "laser", 0.0)]), 0.4).unwrap_err();
        assert_eq!(error.to_string(), "field.far_m: must be positive, is 0");
    }

    /// A moving obstacle beside the nominal path of Section 6.2.2.
    #[test]
    fn something_that_walks_is_one_hill_and_walls_alone_are_no_news() {
        let away = around(Point::new(-2.0, 0.0));
        assert!(!away.has_news && away.heading_rad(Point::origin(), Point::new(0.4, 0.0)).is_none());
        let ahead = around(Point::new(0.8, 0.1));
        let near: Vec<_> = ahead.objects.iter().filter(|at| at.coords.norm() < 2.0).collect();
        assert!(
            near.len() == 1 && (near[0].coords.norm() - (0.65_f64.sqrt() - 0.2)).abs() < 1e-3,
            "{near:?}"
        );
    }

    /// The pull of the goal at its distance L is e^(−1/2) / L, the push of a hill at its distance d is 2d e^(−d²/β²) / β².
    #[test]
    fn the_direction_is_that_of_both_forces() {
        let ahead = around(Point::new(0.5, 0.5));
        let down = ahead.heading_rad(Point::origin(), Point::new(0.4, 0.0)).unwrap();
        let d = 0.5_f64.sqrt() - 0.2;
        let push = 2.0 * d / 0.16 * (-d * d / 0.16).exp() * 0.5_f64.sqrt();
        let pull = (-0.5_f64).exp() / 0.4;
        assert!((down - (-push).atan2(pull - push)).abs() < 0.02, "{down}");
    }
}
