//! A point that goes down a potential field: the lower right panel of Fig. 6.12, and Fig. 6.13.
//!
//! ```text
//! r ← r + s r̂(r),   r̂ = −∇Φ / |∇Φ|        Wahde 2016, Eq. (6.3)
//! ```
//!
//! Deviations: the point turns at once, as a robot with (6.4) to (6.7) does not. Where the figure's robot is stuck, the point goes to and fro
//! around the minimum; the descent ends there.

use baudbot_geometry::Point;

use super::behavior::{Parameters, check, distance};
use crate::parameter::ParameterError;

/// The path of a point down a field.
#[derive(Clone, Debug, PartialEq)]
pub struct Descent {
    /// The points of the path, 1 cm apart.
    pub points: Vec<Point>,
    /// Whether it ends at the goal, or else where every direction leads uphill.
    pub is_at_goal: bool,
}

impl Descent {
    /// The path from a point, past the waypoints, to the goal or to where it gets no lower.
    ///
    /// # Errors
    /// If the parameters are invalid.
    pub fn new(parameters: &Parameters, from: Point) -> Result<Self, ParameterError> {
        check(parameters)?;
        let p = parameters;
        let (mut points, mut waypoints) = (vec![from], p.waypoints.as_slice());
        let (mut at, mut lowest) = (from, (f64::INFINITY, 0));
        for step in 0..MOST_STEPS {
            if distance(p.goal.center(), at) <= p.arrived_m {
                return Ok(Self { points, is_at_goal: true });
            }
            if let [next, later @ ..] = waypoints
                && distance(next.center(), at) <= p.passed_m
            {
                (waypoints, lowest) = (later, (f64::INFINITY, step));
            }
            let field = p.field(waypoints.first());
            let height = field.height(at);
            if height < lowest.0 {
                lowest = (height, step);
            }
            if step - lowest.1 >= PATIENCE {
                break;
            }
            at += field.direction(at) * STEP_M;
            points.push(at);
        }
        points.truncate(lowest.1 + 1);
        Ok(Self { points, is_at_goal: false })
    }

    /// Length of the path, in metres.
    pub fn length_m(&self) -> f64 {
        self.points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).fold(0.0, |sum, step_m| sum + step_m)
    }
}

/// s, in metres.
const STEP_M: f64 = 0.01;
/// So many steps without a new least height are the end.
const PATIENCE: usize = 100;
/// A path of a kilometre is long enough.
const MOST_STEPS: usize = 100_000;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::Description;

    fn parameters(name: &str) -> Parameters {
        let toml = crate::catalogue::described(name).unwrap().unwrap();
        let description = Description::parse(&toml).unwrap();
        let (_, table) = description.parameters_of("potential_field").next().unwrap();
        baudbot_fields::read(table.clone()).unwrap()
    }

    /// The numbers are those of `field.rs`, where the wedge has its minimum.
    #[test]
    fn in_the_wedge_of_fig_6_13_it_ends_at_the_minimum_and_from_aside_it_arrives() {
        let wedge = parameters("wedge");
        let locked = Descent::new(&wedge, Point::new(-1.0, 0.0)).unwrap();
        let end = locked.points[locked.points.len() - 1];
        assert!(!locked.is_at_goal && (end.x - 0.3852).abs() < 0.011 && end.y.abs() < 1e-9, "{end}");
        assert!(Descent::new(&wedge, Point::new(-1.0, 1.0)).unwrap().is_at_goal);
    }

    #[test]
    fn among_four_pillars_and_four_walls_it_arrives_and_stays_clear() {
        let pillars = parameters("four-pillars");
        assert_eq!(pillars.field(None).potentials.len(), 9, "the nine of Fig. 6.12");
        let mut locks = 0;
        for i in 0..=40 {
            let start = Point::new(2.2, -2.2 + 0.06 * f64::from(i));
            let descent = Descent::new(&pillars, start).unwrap();
            let clear_m = |at: &Point| {
                let pillar = |x: f64, y: f64| distance(*at, Point::new(x, y)) - 0.2;
                let walls = 3.0 - at.x.abs().max(at.y.abs());
                [pillar(1.0, 1.0), pillar(1.0, -1.0), pillar(-1.0, 1.0), pillar(-1.0, -1.0), walls]
                    .into_iter()
                    .fold(f64::INFINITY, f64::min)
            };
            let least = descent.points.iter().map(clear_m).fold(f64::INFINITY, f64::min);
            assert!(least > 0.3, "{start}: {least}");
            locks += u32::from(!descent.is_at_goal);
        }
        // Only straight behind a pillar, as seen from the goal, is there no way down.
        assert_eq!(locks, 1);
    }

    #[test]
    fn waypoints_lead_round_and_invalid_ones_are_refused() {
        let mut wedge = parameters("wedge");
        let waypoint =
            |x_m| super::super::Potential { x_m, y_m: 0.75, alpha: -1.2, beta_m: 0.45, gamma_m: 0.45 };
        wedge.waypoints = vec![waypoint(0.45), waypoint(1.2)];
        let descent = Descent::new(&wedge, Point::new(-1.0, 0.0)).unwrap();
        assert!(descent.is_at_goal && (3.2..4.0).contains(&descent.length_m()), "{}", descent.length_m());
        wedge.waypoints[1].beta_m = 0.0;
        let error = Descent::new(&wedge, Point::origin()).unwrap_err().to_string();
        assert_eq!(error, "waypoints[1].beta_m: must be positive, is 0");
    }
}
