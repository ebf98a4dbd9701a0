//! What a robot's sensors see, as scans.

use baudbot_client::{Body, Sensor, Turn};
use baudbot_geometry::{Pose, math};
use serde::Deserialize;

use crate::scan::Scan;

/// What no data sheet says.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// Names of sensors of the kinds `laser`, `sonar` and `ir`. Without them it is all lasers, of a robot without a laser all
    /// sonars, and of one without these all infra-red sensors.
    pub names: Vec<String>,
    /// How wide a laser opens, in radians; negative if it sweeps clockwise.
    pub laser_opening_rad: Option<f64>,
    /// How wide a sonar or an infra-red sensor opens, in radians.
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
    /// c₂.
    pub c2: f64,
}

/// The sensors of a robot that see how far away something is.
#[derive(Clone, Debug, PartialEq)]
pub struct Sight {
    eyes: Vec<(usize, Eye)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Eye {
    Laser { opening_rad: f64 },
    Sonar { cone_rad: f64 },
    Infrared { cone_rad: f64, constants: Infrared },
}

impl Sight {
    /// That of a robot with this body.
    ///
    /// # Errors
    /// If it has no such sensor, or something is missing that its data sheet does not say, in words.
    pub fn new(parameters: &Parameters, body: &Body) -> Result<Self, String> {
        let sensors = chosen(parameters, body)?;
        let eyes = sensors.into_iter().map(|i| Ok((i, eye(parameters, &body.sensors[i])?)));
        Ok(Self { eyes: eyes.collect::<Result<_, String>>()? })
    }

    /// What has just been seen, and when: the instant of the sample, or that of the turn.
    pub fn scans(&self, turn: &Turn) -> Vec<(u64, Scan)> {
        let seen = |&(i, eye): &(usize, Eye)| {
            let sensor = turn.body.sensors.get(i)?;
            let reading = turn.readings.get(i)?.as_ref().filter(|reading| reading.readable)?;
            let at_ns = reading.sampled_at_ns.unwrap_or(turn.at_ns);
            let scan = match eye {
                Eye::Laser { .. } => Scan::of(sensor, reading)?,
                Eye::Sonar { cone_rad } => cone(sensor, cone_rad, *reading.values.first()?)?,
                Eye::Infrared { cone_rad, constants } => {
                    cone(sensor, cone_rad, constants.distance_m(*reading.values.first()?))?
                }
            };
            Some((at_ns, scan))
        };
        self.eyes.iter().filter_map(seen).collect()
    }
}

impl Infrared {
    /// How far away something is by a reading, in metres: (3.13) the other way round, for a ray straight ahead. Rays aside
    /// reflect less, so the true distance is rather less than more. Where nothing is, it is infinite.
    fn distance_m(&self, reading: f64) -> f64 {
        let above = reading - self.c2;
        if above > 0.0 { math::sqrt(self.c1_m2 / above) } else { f64::INFINITY }
    }
}

/// The sensors that count, by their places on the data sheet.
fn chosen(parameters: &Parameters, body: &Body) -> Result<Vec<usize>, String> {
    let find = |name: &String| {
        let sensor = body.sensor_index(name).filter(|&i| KINDS.contains(&body.sensors[i].kind.as_str()));
        sensor.ok_or_else(|| {
            format!("sight.names: robot `{}` has no laser, sonar or ir called `{name}`", body.name)
        })
    };
    if !parameters.names.is_empty() {
        return parameters.names.iter().map(find).collect();
    }
    let of_kind = |kind: &&str| -> Vec<usize> {
        let sensors = body.sensors.iter().enumerate();
        sensors.filter(|(_, sensor)| sensor.kind == *kind && fixed(sensor)).map(|(i, _)| i).collect()
    };
    let found = KINDS.iter().map(of_kind).find(|sensors| !sensors.is_empty());
    found.ok_or_else(|| format!("robot `{}` has no sensor of kind `laser`, `sonar` or `ir`", body.name))
}

/// Whether a sensor sits on the body and not on a turret.
fn fixed(sensor: &Sensor) -> bool {
    sensor.mount.as_ref().is_some_and(|mount| mount.turret.is_none())
}

fn eye(parameters: &Parameters, sensor: &Sensor) -> Result<Eye, String> {
    let (name, range) = (&sensor.name, sensor.range_m.filter(|range_m| range_m.is_finite()));
    if range.is_none() || !fixed(sensor) {
        return Err(format!("sight: sensor `{name}` has no range, or no place on the body"));
    }
    let cone_rad = parameters.cone_rad.unwrap_or(CONE_RAD);
    if !(cone_rad > 0.0 && cone_rad <= std::f64::consts::PI) {
        return Err(format!("sight.cone_rad: must be above 0 and at most π, is {cone_rad}"));
    }
    match sensor.kind.as_str() {
        "laser" => {
            let opening_rad = parameters.laser_opening_rad.filter(|rad| rad.is_finite() && *rad != 0.0);
            let missing = || format!("sight.laser_opening_rad: must be given for laser `{name}`, and not 0");
            Ok(Eye::Laser { opening_rad: opening_rad.ok_or_else(missing)? })
        }
        "sonar" => Ok(Eye::Sonar { cone_rad }),
        _ => {
            let constants = parameters.ir.filter(|ir| ir.c1_m2 > 0.0 && ir.c2.is_finite());
            let missing = || format!("sight.ir: c1_m2 and c2 of (3.13) must be given for sensor `{name}`");
            Ok(Eye::Infrared { cone_rad, constants: constants.ok_or_else(missing)? })
        }
    }
}

/// The scan of a sensor that says one distance: it may be anywhere across its cone.
fn cone(sensor: &Sensor, opening_rad: f64, distance_m: f64) -> Option<Scan> {
    let (range_m, mount) = (sensor.range_m?, sensor.mount?);
    let seen = distance_m > 0.0 && distance_m < range_m;
    let distance_m = if seen { distance_m } else { f64::INFINITY };
    let robot_from_laser = Pose::new(mount.x_m, mount.y_m, mount.heading_rad);
    Some(Scan { robot_from_laser, opening_rad, range_m, distances_m: vec![distance_m; CONE_RAYS] })
}

/// From the one that sees best to the one that sees least.
const KINDS: [&str; 3] = ["laser", "sonar", "ir"];
/// How wide a sonar or an infra-red sensor opens if nobody says so, in radians.
const CONE_RAD: f64 = 0.5;
/// Rays across such a cone.
const CONE_RAYS: usize = 7;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_body::{body, turn};

    fn parameters(toml: &str) -> Parameters {
        toml::from_str(toml).unwrap()
    }

    #[test]
    fn readings_become_scans() {
        let body = body(&[("left", "ir", 0.5), ("right", "ir", -0.5)]);
        let sight = Sight::new(&parameters("ir = { c1_m2 = 0.03, c2 = 0.1 }"), &body).unwrap();
        // (3.13) at 0.5 m is 0.12 + 0.1; nothing within a metre is less than 0.13.
        let scans = sight.scans(&turn(&body, 7, &[Some(&[0.22]), Some(&[0.11])]));
        assert_eq!(scans.len(), 2);
        assert!(
            (scans[0].1.distances_m[3] - 0.5).abs() < 1e-12 && scans[0].1.robot_from_laser.heading == 0.5
        );
        assert_eq!((scans[1].0, scans[1].1.distances_m[0]), (7, f64::INFINITY));
    }

    #[test]
    fn the_best_kind_of_sensor_is_taken_unless_some_are_named() {
        let body = body(&[("front", "ir", 0.0), ("ping", "sonar", 0.0), ("back", "sonar", 3.0)]);
        let seen = |toml: &str| Sight::new(&parameters(toml), &body).map(|sight| sight.eyes.len());
        assert_eq!(seen(""), Ok(2));
        assert_eq!(seen("names = [\"front\"]\nir = { c1_m2 = 0.03, c2 = 0.1 }"), Ok(1));
        let problem = |toml: &str| seen(toml).unwrap_err();
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
    fn a_laser_needs_its_opening() {
        let body = body(&[("urg", "laser", 0.0)]);
        let problem = Sight::new(&Parameters::default(), &body).unwrap_err();
        assert_eq!(problem, "sight.laser_opening_rad: must be given for laser `urg`, and not 0");
        let problem = Sight::new(&Parameters::default(), &crate::test_body::body(&[])).unwrap_err();
        assert_eq!(problem, "robot `alice` has no sensor of kind `laser`, `sonar` or `ir`");
    }
}
