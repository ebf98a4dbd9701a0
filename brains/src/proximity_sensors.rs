//! Detection of obstacles close ahead, by infra-red sensors and sonars. These should be mounted lower than the laser, to
//! detect obstacles that it looks over.

use baudbot_brain::{Body, Mount, Sensor, SensorKind, Turn};
use baudbot_geometry::{Direction, Point, Pose};

use crate::parameter::for_body;

/// The infra-red sensors and sonars of a robot that sit on its body and look ahead.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ProximitySensors {
    proximity: Vec<Feeler>,
    radius_m: f64,
    near: Near,
}

/// The thresholds from which on something is near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Near {
    /// The distance from a sonar within which an object on the robot's way is near, in metres.
    pub(crate) near_m: f64,
    /// An infra-red reading from which on something is near.
    pub(crate) near_reading: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Feeler {
    sensor: usize,
    robot_from_sensor: Pose,
    is_sonar: bool,
    /// Half the opening angle of its cone, in radians.
    half_rad: f64,
    /// The last reading; `None` if it does not count.
    value: Option<f64>,
}

/// The echo of a sonar: something is somewhere in its cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Echo {
    /// The sonar's pose on the robot.
    pub(crate) robot_from_sensor: Pose,
    /// Half the opening angle of its cone, in radians.
    pub(crate) half_rad: f64,
    /// The distance to it, in metres.
    pub(crate) distance_m: f64,
}

impl ProximitySensors {
    /// The `ProximitySensors` of a robot with this body; there may be none.
    pub(crate) fn new(body: &Body, near: Near) -> Self {
        let feeler = |(sensor, described): (usize, &Sensor)| Feeler {
            sensor,
            robot_from_sensor: mount(described),
            is_sonar: described.kind == SensorKind::Sonar,
            half_rad: 0.5 * described.opening_rad.unwrap_or(0.0),
            value: None,
        };
        let sensors = body.sensors.iter().enumerate();
        let proximity = sensors
            .filter(|(_, sensor)| {
                is_fixed(sensor) && matches!(sensor.kind, SensorKind::Infrared | SensorKind::Sonar)
            })
            .map(feeler);
        let proximity = proximity.filter(|feeler| looks_ahead(&feeler.robot_from_sensor)).collect();
        Self { proximity, radius_m: body.radius_m, near }
    }

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.proximity.is_empty()
    }

    /// Takes in what a turn brought.
    pub(crate) fn feel(&mut self, turn: &Turn) {
        for feeler in &mut self.proximity {
            let reading = turn.readings.get(feeler.sensor).and_then(Option::as_ref);
            let value = reading.filter(|reading| reading.readable).and_then(|new| new.values.first());
            if let Some(&value) = value {
                feeler.value = Some(value);
            }
        }
    }

    /// Earlier readings do not count any more.
    pub(crate) fn forget(&mut self) {
        self.proximity.iter_mut().for_each(|feeler| feeler.value = None);
    }

    /// Whether something is near, by the newest readings.
    pub(crate) fn is_near(&self) -> bool {
        self.is_near_but(f64::INFINITY, |_| false)
    }

    /// The same on a way that ends after so many metres, without echoes of sonars that come from obstacles whose places are known
    /// better, by the laser.
    pub(crate) fn is_near_but(&self, way_m: f64, is_known: impl Fn(&Echo) -> bool) -> bool {
        let near = Near { near_m: self.near.near_m.min(way_m), ..self.near };
        let is_known = |feeler: &Feeler| {
            let Feeler { robot_from_sensor, half_rad, .. } = *feeler;
            let is_known = |distance_m| is_known(&Echo { robot_from_sensor, half_rad, distance_m });
            feeler.is_sonar && feeler.value.is_some_and(is_known)
        };
        let feels =
            |feeler: &Feeler| feeler.value.is_some_and(|value| feeler.feels(value, self.radius_m, near));
        self.proximity.iter().any(|feeler| feels(feeler) && !is_known(feeler))
    }
}

impl Feeler {
    /// Whether what a sensor reads is near and in the way.
    fn feels(&self, value: f64, radius_m: f64, near: Near) -> bool {
        if !self.is_sonar {
            return value >= near.near_reading;
        }
        let forward = self.robot_from_sensor.direction();
        let point_in_robot = self.robot_from_sensor.position + forward.vector() * value;
        is_in_way(point_in_robot, near.near_m, radius_m + ALMOST * near.near_m)
    }
}

/// Whether it sits on the body itself and its rays are level: where one on a turret looks is not understood, and one that looks down sees the
/// floor.
fn is_fixed(sensor: &Sensor) -> bool {
    sensor.mount.is_none_or(|mount| mount.is_fixed_and_level())
}

fn mount(sensor: &Sensor) -> Pose {
    let Mount { x_m, y_m, heading_rad, .. } = sensor.mount.unwrap_or_default();
    Pose::new(x_m, y_m, heading_rad)
}

fn looks_ahead(robot_from_sensor: &Pose) -> bool {
    Direction::from_angle(robot_from_sensor.heading).cos > AHEAD_COS
}

/// The default of the distance ahead within which an object is near, for a body with this radius: three quarters of
/// the radius, both in metres.
pub(crate) fn near_m(radius_m: f64) -> f64 {
    for_body(0.15, radius_m)
}

/// Whether a point would be in a disc of this radius that is so far ahead.
pub(crate) fn is_in_way(point_in_robot: Point, ahead_m: f64, radius_m: f64) -> bool {
    let off = point_in_robot - Point::new(ahead_m, 0.0);
    point_in_robot.x > 0.0 && off.norm() < radius_m
}

/// Room that there must be beside a disc that is a little ahead, as a part of how far that is. A sonar's reading has no
/// direction within its cone: with half a cone of 0.2 rad and 0.15 m to go, 3 cm to the side.
const ALMOST: f64 = 0.2;
/// Cosine of the greatest angle at which a sensor looks ahead: 80°.
const AHEAD_COS: f64 = 0.17;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_in_the_way_is_near() {
        let near = Near { near_m: 0.15, near_reading: 0.4 };
        let feels = |heading: f64, distance_m: f64| {
            let robot_from_sensor = Pose::new(0.2 * heading.cos(), 0.2 * heading.sin(), heading);
            let feeler = Feeler { sensor: 0, robot_from_sensor, is_sonar: true, half_rad: 0.0, value: None };
            feeler.feels(distance_m, 0.2, near)
        };
        assert!(feels(0.0, 0.16) && !feels(0.0, 0.19));
        assert!(feels(1.0, 0.05) && !feels(1.0, 0.12), "ahead on the left");
        assert!(!feels(1.5, 0.05), "beside it");
    }
}
