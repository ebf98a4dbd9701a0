//! The density of obstacles by direction, and the blocked directions.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use baudbot_geometry::{Point, Pose, Vector, angle, math};

/// The range of obstacles that count, and their weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Cells that are farther away do not count, in metres.
    pub radius_m: f64,
    /// r_(r+s): the robot's radius and the room that is to be kept beside it, in metres.
    pub wide_m: f64,
    /// A free direction becomes blocked only if there is less room than that by so much, in metres.
    pub slack_m: f64,
    /// τ_low: a direction with less than this becomes free.
    pub low: f64,
    /// τ_high: a direction with more than this becomes blocked.
    pub high: f64,
}

/// Directions around the robot along the axes of the believed pose's frame, in sectors of equal width; the first one begins at
/// 0 rad. Which of them are blocked.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    blocked: Vec<bool>,
}

impl Histogram {
    /// All directions free, in so many sectors.
    pub fn new(sectors: usize) -> Self {
        Self { blocked: vec![false; sectors] }
    }

    /// The binary polar histogram, sector by sector.
    pub fn blocked(&self) -> &[bool] {
        &self.blocked
    }

    /// Goes on by one step, for a robot that is here among these obstacles; with hysteresis, (7).
    pub fn update(&mut self, here: Point, obstacles: impl Iterator<Item = Point>, window: &Window) {
        let obstacles: Vec<_> = obstacles.collect();
        let density = |wide_m| primary(self.blocked.len(), here, &obstacles, window.radius_m, wide_m);
        let (wide, narrow) = (density(window.wide_m), density(window.wide_m - window.slack_m));
        for (i, blocked) in self.blocked.iter_mut().enumerate() {
            *blocked = if *blocked { wide[i] >= window.low } else { narrow[i] > window.high };
        }
    }

    /// The masked polar histogram: blocked is also what is beyond an obstacle that a robot with this turn radius in metres
    /// cannot turn past. One that turns on the spot, with radius 0, can turn past each.
    pub fn masked(
        &self,
        world_from_robot: &Pose,
        obstacles: impl Iterator<Item = Point>,
        turn_radius_m: f64,
        window: &Window,
    ) -> Vec<bool> {
        if turn_radius_m <= 0.0 {
            return self.blocked.clone();
        }
        let robot_from_world = world_from_robot.inverse();
        // The limits of its turn to the right and to the left.
        let (mut right_rad, mut left_rad) = (-PI, PI);
        for obstacle in obstacles.map(|obstacle| robot_from_world.transform(obstacle)) {
            let bearing_rad = math::atan2(obstacle.y, obstacle.x);
            let center = Vector::new(0.0, turn_radius_m.copysign(bearing_rad));
            let is_near = obstacle.coords.norm() <= window.radius_m;
            if is_near && (obstacle.coords - center).norm() < turn_radius_m + window.wide_m {
                if bearing_rad < 0.0 {
                    right_rad = f64::max(right_rad, bearing_rad);
                } else {
                    left_rad = f64::min(left_rad, bearing_rad);
                }
            }
        }
        let sectors = self.blocked.len();
        let aside = |i| angle::difference(middle_rad(i, sectors), world_from_robot.heading);
        let masked = self.blocked.iter().enumerate();
        masked.map(|(i, &blocked)| blocked || aside(i) < right_rad || aside(i) > left_rad).collect()
    }
}

/// The direction in the middle of a sector, in radians.
fn middle_rad(sector: usize, sectors: usize) -> f64 {
    (sector as f64 + 0.5) * TAU / sectors as f64
}

/// The primary polar histogram: of each cell the direction β (1) and the weight m = c² (a − b d²) (2), with certainty c = 1
/// and a = 1, b = 1 / radius². A cell is as wide as the robot, γ = arcsin(r / d) to both sides (4), and counts in all sectors
/// that it then reaches (6).
fn primary(sectors: usize, here: Point, obstacles: &[Point], radius_m: f64, wide_m: f64) -> Vec<f64> {
    let mut density = vec![0.0; sectors];
    for obstacle in obstacles {
        let offset = obstacle - here;
        let distance_m = offset.norm();
        if distance_m > radius_m {
            continue;
        }
        let weight = 1.0 - (distance_m / radius_m) * (distance_m / radius_m);
        let wide_rad = half_width_rad(wide_m, distance_m);
        // The first sector whose middle is not before the right end, and all up to the left end.
        let place = |rad: f64| rad / TAU * sectors as f64 - 0.5;
        let middle_rad = math::atan2(offset.y, offset.x);
        let (first, last) =
            (math::ceil(place(middle_rad - wide_rad)), math::floor(place(middle_rad + wide_rad)));
        for i in first as i64..=last as i64 {
            let density = &mut density[i.rem_euclid(sectors as i64) as usize];
            *density = f64::max(*density, weight);
        }
    }
    density
}

/// γ of (4). Of a cell that is nearer than the robot is wide, which has no such angle, it is a quarter of a turn.
fn half_width_rad(wide_m: f64, distance_m: f64) -> f64 {
    let sin = wide_m / distance_m.max(f64::MIN_POSITIVE);
    if sin < 1.0 { math::atan2(sin, math::sqrt(1.0 - sin * sin)) } else { FRAC_PI_2 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: Window = Window { radius_m: 2.0, wide_m: 0.5, slack_m: 0.0, low: 0.25, high: 0.5 };

    fn blocked_deg(blocked: &[bool]) -> Vec<usize> {
        (0..blocked.len()).filter(|&i| blocked[i]).map(|i| i * 360 / blocked.len()).collect()
    }

    #[test]
    fn a_cell_is_as_wide_as_the_robot() {
        let mut histogram = Histogram::new(72);
        histogram.update(Point::new(1.0, 1.0), [Point::new(2.0, 1.0)].into_iter(), &WINDOW);
        // arcsin(0.5 / 1) is 30°: the sectors whose middle is within.
        assert_eq!(blocked_deg(histogram.blocked()), [0, 5, 10, 15, 20, 25, 330, 335, 340, 345, 350, 355]);
        let mut histogram = Histogram::new(72);
        histogram.update(Point::new(1.0, 1.0), [Point::new(1.0, 1.3)].into_iter(), &WINDOW);
        let half: Vec<_> = (0..36).map(|i| 5 * i).collect();
        assert_eq!(blocked_deg(histogram.blocked()), half, "nearer than it is wide");
    }

    #[test]
    fn between_the_thresholds_all_stays_as_it_is() {
        let mut histogram = Histogram::new(72);
        // 1 - (d/2)² is 0.19, 0.36 and 0.51.
        let mut at = |distance_m: f64| {
            histogram.update(Point::origin(), [Point::new(distance_m, 0.0)].into_iter(), &WINDOW);
            histogram.blocked()[0]
        };
        assert_eq!([1.8, 1.6, 1.4, 1.6, 1.8, 1.6].map(&mut at), [false, false, true, true, false, false]);
        assert!(!at(2.1), "beyond the window");
    }

    #[test]
    fn an_opening_that_is_wide_enough_stays_while_it_becomes_a_little_narrower() {
        let window = Window { slack_m: 0.05, ..WINDOW };
        let mut histogram = Histogram::new(72);
        // Two posts on both sides of the path along the x axis.
        let mut is_blocked = |half_m: f64| {
            let posts = [Point::new(1.0, half_m), Point::new(1.0, -half_m)];
            histogram.update(Point::origin(), posts.into_iter(), &window);
            histogram.blocked()[0]
        };
        assert_eq!([0.60, 0.53, 0.45, 0.53, 0.60].map(&mut is_blocked), [false, false, true, true, false]);
    }

    #[test]
    fn who_needs_room_to_turn_cannot_turn_past_an_obstacle() {
        let mut histogram = Histogram::new(72);
        let obstacle = || [Point::new(0.3, 0.7)].into_iter();
        histogram.update(Point::origin(), obstacle(), &WINDOW);
        let pose = Pose::new(0.0, 0.0, 0.0);
        assert_eq!(histogram.masked(&pose, obstacle(), 0.0, &WINDOW), histogram.blocked());
        let masked = histogram.masked(&pose, obstacle(), 0.5, &WINDOW);
        assert!(masked[35] && !histogram.blocked()[35], "straight back to the left");
        assert!(!masked[37], "to the right it is free");
        // The obstacle is 0.36 m from the centre of the left turning circle; with a radius of 0.1 m it is 0.67 m.
        assert_eq!(histogram.masked(&pose, obstacle(), 0.1, &WINDOW), histogram.blocked());
    }
}
