//! Points to be visited in turn.

use baudbot_geometry::Point;

use crate::parameter::{ParameterError, check_positive};

/// A list of goals, and which of them is next.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Goals {
    points: Vec<Point>,
    reached_m: f64,
    again: bool,
    next: usize,
}

impl Goals {
    /// Goals of the description's field `name`, `[x, y]` in metres, each reached within `reached_m`; after the last comes the
    /// first if it goes round `again`.
    ///
    /// # Errors
    /// If there is none, or a number is invalid.
    pub(crate) fn new(
        name: &str,
        points_m: &[[f64; 2]],
        reached_m: f64,
        again: bool,
    ) -> Result<Self, ParameterError> {
        if points_m.is_empty() {
            return Err(ParameterError::value(name, "has no point"));
        }
        if let Some(i) = points_m.iter().position(|point| !point.iter().all(|m| m.is_finite())) {
            return Err(ParameterError::value(format_args!("{name}[{i}]"), "must be two finite numbers"));
        }
        check_positive([("reached_m", reached_m)])?;
        let points = points_m.iter().map(|&[x, y]| Point::new(x, y)).collect();
        Ok(Self { points, reached_m, again, next: 0 })
    }

    /// All goals.
    pub(crate) fn points(&self) -> &[Point] {
        &self.points
    }

    /// Each is reached within this distance, in metres.
    pub(crate) fn reached_m(&self) -> f64 {
        self.reached_m
    }

    /// The goals that are left of this round.
    pub(crate) fn left(&self) -> &[Point] {
        self.points.get(self.next..).unwrap_or_default()
    }

    /// The next goal, by its place in the list.
    pub(crate) fn next(&self) -> usize {
        self.next
    }

    /// Whether it ends at the next one.
    pub(crate) fn is_last(&self) -> bool {
        self.next + 1 == self.points.len() && !self.again
    }

    /// Whether all have been reached.
    pub(crate) fn has_arrived(&self) -> bool {
        self.next >= self.points.len()
    }

    /// Begins again if it had arrived; a tour that was interrupted goes on.
    pub(crate) fn begin(&mut self) {
        if self.has_arrived() {
            self.next = 0;
        }
    }

    /// The goal of a robot that is here, past those that it has reached; `None` if it has arrived, or if all goals of a
    /// round are within reach of each other, which it would go round for ever.
    pub(crate) fn from(&mut self, here: Point) -> Option<Point> {
        for _ in 0..self.points.len() {
            let goal = self.points.get(self.next)?;
            if (goal - here).norm() > self.reached_m {
                return Some(*goal);
            }
            self.next += 1;
            if self.again && self.next == self.points.len() {
                self.next = 0;
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_are_passed_when_they_are_reached() {
        let mut goals = Goals::new("goals_m", &[[1.0, 0.0], [2.0, 0.0]], 0.1, false).unwrap();
        assert_eq!(goals.from(Point::new(0.0, 0.0)), Some(Point::new(1.0, 0.0)));
        assert_eq!(goals.from(Point::new(0.95, 0.0)), Some(Point::new(2.0, 0.0)));
        assert!(goals.is_last() && !goals.has_arrived());
        assert_eq!(goals.from(Point::new(2.0, 0.05)), None);
        assert!(goals.has_arrived() && goals.left().is_empty());
        goals.begin();
        assert_eq!(goals.left().len(), 2);
    }

    #[test]
    fn a_round_begins_again() {
        let mut goals = Goals::new("goals_m", &[[1.0, 0.0], [2.0, 0.0]], 0.1, true).unwrap();
        for goal in [1.0, 2.0, 1.0] {
            let next = goals.from(Point::new(goal, 0.01)).expect("there is always another");
            assert!((next.x - (3.0 - goal)).abs() < 1e-9, "{next}");
        }
        let mut close = Goals::new("goals_m", &[[1.0, 0.0], [1.05, 0.0]], 0.1, true).unwrap();
        assert_eq!(close.from(Point::new(1.0, 0.0)), None);
    }

    #[test]
    fn what_makes_no_sense_is_said() {
        let problem = |points: &[[f64; 2]], reached_m| {
            Goals::new("goals_m", points, reached_m, false).unwrap_err().to_string()
        };
        assert_eq!(problem(&[], 0.1), "goals_m: has no point");
        assert_eq!(problem(&[[0.0, 0.0], [f64::NAN, 0.0]], 0.1), "goals_m[1]: must be two finite numbers");
        assert_eq!(problem(&[[0.0, 0.0]], 0.0), "reached_m: must be positive, is 0");
    }
}
