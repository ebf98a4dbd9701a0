//! The view of a robot's sensors, as scans.

use std::f64::consts::PI;

use baudbot_brain::{Body, Sensor, SensorKind, Turn};
use baudbot_geometry::{Pose, math};
use serde::Deserialize;

use crate::parameter::ParameterError;
use crate::process::{Awaited, Beliefs};
use crate::scan::Scan;
use crate::scanner::Scanner;

/// Figures that no data sheet gives.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// Names of sensors of the kinds `laser`, `sonar` and `ir`. Without them it is all lasers, of a robot without a laser all
    /// sonars, and of one without these all infra-red sensors.
    pub names: Vec<String>,
    /// The opening of a sonar or an infra-red sensor, in radians, if it is not as in its data sheet.
    pub cone_rad: Option<f64>,
    /// The constants of the infra-red sensors' readings c₁ / d² + c₂ (3.13).
    pub ir: Option<Infrared>,
}

/// Constants of (3.13).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Infrared {
    /// c₁, in square metres.
    pub c1_m2: f64,
    /// The constant c₂.
    pub c2: f64,
}

/// The sensors of a robot that see how far away something is.
#[derive(Clone, Debug, PartialEq)]
pub struct Sight {
    lasers: Vec<Scanner>,
    /// The others, by their places on the data sheet.
    cones: Vec<(usize, Cone)>,
}

/// A scan, and whence it was taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Seen {
    /// The instant, in nanoseconds.
    pub at_ns: u64,
    /// The view: all of it at that instant.
    pub scan: Scan,
    /// The robot's pose then.
    pub world_from_robot: Pose,
}

/// A sensor that measures one distance.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cone {
    opening_rad: f64,
    /// The parameters of an infra-red sensor; the readings of a sonar are metres.
    infrared: Option<Infrared>,
}

impl Sight {
    /// A `Sight` of a robot with this body.
    ///
    /// # Errors
    /// If it has no such sensor, or something is missing that its data sheet does not state.
    pub fn new(parameters: &Parameters, body: &Body) -> Result<Self, ParameterError> {
        let mut sight = Self { lasers: Vec::new(), cones: Vec::new() };
        for i in chosen(parameters, body)? {
            let sensor = &body.sensors[i];
            let problem = || {
                let problem = format_args!(
                    "sensor `{}` has no range, no place on the body, or rays that are not level",
                    sensor.name
                );
                ParameterError::value("sight", problem)
            };
            fixed(sensor).ok_or_else(problem)?;
            if sensor.kind == SensorKind::Laser {
                sight.lasers.push(Scanner::new(body, &sensor.name, usize::MAX)?);
            } else {
                sight.cones.push((i, cone(parameters, sensor)?));
            }
        }
        Ok(sight)
    }

    /// The scans that can be placed by now. The scan of a laser waits until the odometry has come to the end of its sweep; a
    /// brain that has a pose and no odometry takes it as it is.
    pub fn look(&mut self, turn: &Turn, beliefs: &Beliefs) -> Vec<Seen> {
        let mut seen = Vec::new();
        for laser in &mut self.lasers {
            laser.hear(turn);
            let taken = std::iter::from_fn(|| match &beliefs.odometry {
                Some(odometry) => laser.take(odometry),
                None => laser.take_as_is(),
            });
            seen.extend(taken.filter_map(|(at_ns, scan)| placed(at_ns, scan, beliefs)));
        }
        let heard = self.cones.iter().filter_map(|(i, cone)| cone.scan(turn, *i));
        seen.extend(heard.filter_map(|(at_ns, scan)| placed(at_ns, scan, beliefs)));
        seen
    }

    /// The sensor that it waits for if it has seen nothing since this instant, in nanoseconds, and since when.
    pub fn awaited(&self, turn: &Turn, beliefs: &Beliefs, seen_ns: u64) -> Option<Awaited> {
        let laser = self.lasers.iter().map(|laser| laser.awaited(beliefs.odometry.as_ref()));
        let cone = || {
            let sensor = turn.body.sensors.get(self.cones.first()?.0)?.name.clone();
            Some(Awaited { sensor, since_ns: seen_ns })
        };
        laser.min_by_key(|awaited| awaited.since_ns).or_else(cone)
    }

    /// Whether it can distinguish walking people from things that stand. The arcs of sensors that give one distance come and go
    /// with each turn of the robot, and where two of them overlap.
    pub fn tells_walkers(&self) -> bool {
        self.cones.is_empty()
    }

    /// Waiting scans are not of interest any more.
    pub fn forget(&mut self) {
        self.lasers.iter_mut().for_each(Scanner::forget);
    }
}

/// A scan with the pose from which it was taken; `None` if that is not known.
fn placed(at_ns: u64, scan: Scan, beliefs: &Beliefs) -> Option<Seen> {
    let estimate = match &beliefs.odometry {
        Some(odometry) => odometry.at(at_ns),
        None => beliefs.pose,
    };
    Some(Seen { at_ns, scan, world_from_robot: estimate?.world_from_robot })
}

impl Cone {
    /// The reading of this sensor, and when it was taken: the instant of the sample, or that of the turn. It may be anywhere
    /// across the cone.
    fn scan(&self, turn: &Turn, sensor: usize) -> Option<(u64, Scan)> {
        let (reading, sensor) = (turn.readings.get(sensor)?.as_ref()?, turn.body.sensors.get(sensor)?);
        let value = *reading.values.first().filter(|_| reading.readable)?;
        let (range_m, robot_from_laser) = fixed(sensor)?;
        let distance_m = self.infrared.map_or(value, |constants| constants.distance_m(value, range_m));
        let is_seen = distance_m.is_nan() || (distance_m > 0.0 && distance_m < range_m);
        let distances_m = vec![if is_seen { distance_m } else { f64::INFINITY }; CONE_RAYS];
        let scan = Scan { robot_from_laser, opening_rad: self.opening_rad, range_m, distances_m };
        Some((reading.sampled_at_ns.unwrap_or(turn.at_ns), scan))
    }
}

impl Infrared {
    /// The distance of an object by a reading, in metres: (3.13) the other way round, for a ray straight ahead. Rays
    /// aside reflect less, so the true distance is rather less than more. Where nothing is, it is infinite. The reading
    /// is the mean of the sensor's rays (3.12): one that is less than that of a whole hit at the range, and more than
    /// nothing, is of something that a few rays meet at an unknown distance.
    fn distance_m(&self, reading: f64, range_m: f64) -> f64 {
        let least = self.c1_m2 / (range_m * range_m) + self.c2;
        if reading.is_nan() {
            f64::NAN
        } else if reading >= least {
            math::sqrt(self.c1_m2 / (reading - self.c2))
        } else if reading > NOTHING * least {
            f64::NAN
        } else {
            f64::INFINITY
        }
    }
}

/// The sensors that count, by their places on the data sheet.
fn chosen(parameters: &Parameters, body: &Body) -> Result<Vec<usize>, ParameterError> {
    let find = |name: &String| {
        let sensor = body.sensor_index(name).filter(|&i| KINDS.contains(&body.sensors[i].kind));
        sensor.ok_or_else(|| {
            let problem = format_args!("robot `{}` has no laser, sonar or ir called `{name}`", body.name);
            ParameterError::value("sight.names", problem)
        })
    };
    if !parameters.names.is_empty() {
        return parameters.names.iter().map(find).collect();
    }
    let of_kind = |kind: &SensorKind| -> Vec<usize> {
        let sensors = body.sensors.iter().enumerate();
        let is_fixed = |sensor: &Sensor| sensor.mount.is_some_and(|mount| mount.is_fixed_and_level());
        sensors.filter(|(_, sensor)| sensor.kind == *kind && is_fixed(sensor)).map(|(i, _)| i).collect()
    };
    let found = KINDS.iter().map(of_kind).find(|sensors| !sensors.is_empty());
    found.ok_or_else(|| {
        let problem = format!("robot `{}` has no sensor of kind `laser`, `sonar` or `ir`", body.name);
        ParameterError::Other(problem)
    })
}

/// The range and the place of a sensor with level rays that sits on the body and not on a turret.
fn fixed(sensor: &Sensor) -> Option<(f64, Pose)> {
    let mount = sensor.mount.filter(|mount| mount.is_fixed_and_level())?;
    let range_m = sensor.range_m.filter(|range_m| range_m.is_finite())?;
    Some((range_m, Pose::new(mount.x_m, mount.y_m, mount.heading_rad)))
}

fn cone(parameters: &Parameters, sensor: &Sensor) -> Result<Cone, ParameterError> {
    // The opening of a sensor cannot be derived from one ray.
    let of_sheet = sensor.opening_rad.filter(|opening_rad| *opening_rad > 0.0).map(|rad| rad.min(PI));
    let opening_rad = parameters.cone_rad.or(of_sheet).unwrap_or(CONE_RAD);
    if !(opening_rad > 0.0 && opening_rad <= PI) {
        return Err(ParameterError::range("sight.cone_rad", "above 0 and at most π", opening_rad));
    }
    if sensor.kind == SensorKind::Sonar {
        return Ok(Cone { opening_rad, infrared: None });
    }
    let constants = parameters.ir.filter(|ir| ir.c1_m2 > 0.0 && ir.c2.is_finite());
    let missing = || {
        let problem = format_args!("c1_m2 and c2 of (3.13) must be given for sensor `{}`", sensor.name);
        ParameterError::value("sight.ir", problem)
    };
    Ok(Cone { opening_rad, infrared: Some(constants.ok_or_else(missing)?) })
}

/// The kinds of sensors, the most informative first.
const KINDS: [SensorKind; 3] = [SensorKind::Laser, SensorKind::Sonar, SensorKind::Infrared];
/// The opening of a sonar or an infra-red sensor without a figure for it, in radians.
const CONE_RAD: f64 = 0.5;
/// Less than this part of a whole hit at its range is what an infra-red sensor reads of nothing.
const NOTHING: f64 = 0.1;
/// Rays across such a cone.
const CONE_RAYS: usize = 7;

#[cfg(test)]
mod tests {
    use baudbot_brain::Sweep;

    use super::*;
    use crate::estimate::Estimate;
    use crate::odometry::{self, Odometry};
    use crate::test_body::{body, turn};

    fn parameters(toml: &str) -> Parameters {
        toml::from_str(toml).unwrap()
    }

    #[test]
    fn readings_become_scans() {
        let body = body(&[("left", "ir", 0.5), ("ahead", "ir", 0.0), ("right", "ir", -0.5)]);
        let mut sight = Sight::new(&parameters("ir = { c1_m2 = 0.03, c2 = 0.1 }"), &body).unwrap();
        let pose = Pose::new(1.0, 2.0, 0.0);
        // (3.13) at 0.5 m is 0.12 + 0.1; nothing within a metre is less than 0.13.
        let turn = turn(&body, 7, &[Some(&[0.22]), Some(&[0.11]), Some(&[0.0])]);
        let [left, ahead, right] = &sight.look(&turn, &standing(pose))[..] else { panic!("three scans") };
        assert!((left.scan.distances_m[3] - 0.5).abs() < 1e-12 && left.scan.robot_from_laser.heading == 0.5);
        assert!(ahead.scan.distances_m[3].is_nan(), "a few rays meet something");
        assert_eq!((right.at_ns, right.scan.distances_m[0]), (7, f64::INFINITY));
        assert_eq!((left.world_from_robot, right.world_from_robot), (pose, pose));
    }

    fn standing(world_from_robot: Pose) -> Beliefs {
        Beliefs { pose: Some(Estimate::exact(world_from_robot)), ..Beliefs::default() }
    }

    fn laser_of_3_rays() -> Body {
        let mut body = body(&[("urg", "laser", 0.0)]);
        body.sensors[0].components[0].count = 3;
        body.sensors[0].opening_rad = Some(2.0);
        body.sensors[0].sweep = Some(Sweep { duration_ns: 200_000_000, clockwise: false });
        body
    }

    /// The robot drives along x at 0.1 m/s, and its odometer has a reading ten times a second.
    fn odometry(until_ns: u64) -> Odometry {
        let parameters = odometry::Parameters {
            half_track_m: 0.2,
            m_per_count: [1e-4; 2],
            modulus: None,
            variance_m2_per_m: 0.0,
            past_ns: 10_000_000_000,
            calibration: odometry::Calibration::NONE,
        };
        let mut odometry = Odometry::new(parameters, 0, Estimate::exact(Pose::new(0.0, 0.0, 0.0)));
        for at_ns in (0..=until_ns).step_by(100_000_000) {
            odometry.odometer(at_ns, Pose::new(0.1 * at_ns as f64 * 1e-9, 0.0, 0.0));
        }
        odometry
    }

    #[test]
    fn a_scan_waits_for_the_odometry_of_its_end() {
        let body = laser_of_3_rays();
        let mut sight = Sight::new(&Parameters::default(), &body).unwrap();
        let knowing = |until_ns| Beliefs { odometry: Some(odometry(until_ns)), ..Beliefs::default() };
        let early = turn(&body, 300_000_000, &[Some(&[0.5, 0.5, 0.5])]);
        assert_eq!(sight.look(&early, &knowing(400_000_000)), []);
        let later = turn(&body, 600_000_000, &[None]);
        let [seen] = &sight.look(&later, &knowing(600_000_000))[..] else { panic!("one scan") };
        assert_eq!(seen.at_ns, 500_000_000);
        assert!((seen.world_from_robot.position.x - 0.05).abs() < 1e-12, "{seen:?}");
        // The ray ahead was taken half of the sweep before, a centimetre back.
        assert!((seen.scan.distances_m[1] - 0.49).abs() < 1e-3, "{seen:?}");
        assert_eq!(sight.look(&later, &knowing(600_000_000)), [], "only once");
    }

    #[test]
    fn a_scan_without_an_instant_ended_when_it_came() {
        let body = laser_of_3_rays();
        let mut sight = Sight::new(&Parameters::default(), &body).unwrap();
        let mut turn = turn(&body, 500_000_000, &[Some(&[0.5, 0.5, 0.5])]);
        turn.readings[0].as_mut().unwrap().sampled_at_ns = None;
        let beliefs = Beliefs { odometry: Some(odometry(500_000_000)), ..Beliefs::default() };
        assert_eq!(sight.look(&turn, &beliefs)[0].at_ns, 500_000_000);
        let [seen] = &sight.look(&turn, &standing(Pose::new(1.0, 2.0, 0.0)))[..] else { panic!("one scan") };
        assert_eq!((seen.at_ns, &seen.scan.distances_m[..]), (500_000_000, &[0.5; 3][..]), "as it is");
        sight.lasers[0].hear(&turn);
        sight.forget();
        turn.readings[0] = None;
        assert_eq!(sight.look(&turn, &beliefs), []);
    }

    #[test]
    fn the_best_kind_of_sensor_is_taken_unless_some_are_named() {
        let body = body(&[("front", "ir", 0.0), ("ping", "sonar", 0.0), ("back", "sonar", 3.0)]);
        let seen = |toml: &str| Sight::new(&parameters(toml), &body).map(|sight| sight.cones.len());
        assert_eq!(seen(""), Ok(2));
        assert_eq!(seen("names = [\"front\"]\nir = { c1_m2 = 0.03, c2 = 0.1 }"), Ok(1));
        let problem = |toml: &str| seen(toml).unwrap_err().to_string();
        assert_eq!(
            problem("names = [\"eye\"]"),
            "sight.names: robot `alice` has no laser, sonar or ir called `eye`"
        );
        assert_eq!(
            problem("names = [\"front\"]"),
            "sight.ir: c1_m2 and c2 of (3.13) must be given for sensor `front`"
        );
        assert!(problem("cone_rad = 0.0").starts_with("sight.cone_rad: must be above 0"));
    }

    #[test]
    fn what_a_data_sheet_lacks_is_said() {
        let mut body = body(&[("urg", "laser", 0.0)]);
        body.sensors[0].opening_rad = None;
        let problem = Sight::new(&Parameters::default(), &body).unwrap_err().to_string();
        let lacks = "laser: the data sheet of `urg` does not say how wide it opens: is the server older?";
        assert_eq!(problem, lacks);
        let problem =
            Sight::new(&Parameters::default(), &crate::test_body::body(&[])).unwrap_err().to_string();
        assert_eq!(problem, "robot `alice` has no sensor of kind `laser`, `sonar` or `ir`");
    }
}
