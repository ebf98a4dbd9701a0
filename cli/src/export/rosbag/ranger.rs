//! Sensors that measure one distance, as ROS wants them: in metres.
//!
//! A sonar gives its distance. An IR sensor gives a reading or a voltage that falls with the distance; a program of a
//! robot's looks the distance up in the sensor's curve, and so does this: the farthest distance from a wide wall
//! straight ahead at which the sensor would read that on average. Where the curve has a hump, as those of Sharp's
//! sensors have, nearer distances are ambiguous.

use baudbot_sim::sensor::{Device, Infrared, InfraredModel, Mount, VoltageRanger};

use super::messages::{Radiation, RangeReading};

/// A sensor of one distance.
pub(super) struct Ranger {
    radiation: Radiation,
    field_of_view_rad: f64,
    /// The least distance and the most.
    range_m: [f64; 2],
    curve: Curve,
}

/// The function from a reading to a distance.
enum Curve {
    /// The reading is a distance.
    Distance,
    /// Distances, increasing, with what is read there.
    Points(Vec<(f64, f64)>),
}

impl Ranger {
    /// The ranger of a sensor that measures one distance, and sits at a place of the body that does not change.
    pub(super) fn of(device: &Device) -> Option<Self> {
        is_fixed(device.mount()?).then_some(())?;
        match device {
            Device::Sonar(sonar) => Some(Self {
                radiation: Radiation::Ultrasound,
                field_of_view_rad: sonar.fan.opening_rad(),
                range_m: [sonar.min_m, sonar.max_m],
                curve: Curve::Distance,
            }),
            Device::Infrared(infrared) => Some(Self {
                radiation: Radiation::Infrared,
                field_of_view_rad: infrared.fan.opening_rad(),
                range_m: [0.0, infrared.range_m],
                curve: Curve::of(infrared.range_m, reading(infrared)?),
            }),
            Device::VoltageRanger(ranger) => Some(Self::of_voltage(ranger)),
            Device::Laser(_)
            | Device::LineCamera(_)
            | Device::Camera(_)
            | Device::Encoders(_)
            | Device::StepCounter(_)
            | Device::Odometer(_)
            | Device::OpticalFlow(_)
            | Device::Compass(_)
            | Device::Accelerometer(_)
            | Device::Gyroscope(_)
            | Device::Gps(_)
            | Device::Whisker(_)
            | Device::Bumper(_)
            | Device::Photoresistor(_)
            | Device::Light(_)
            | Device::Field(_)
            | Device::Microphone(_)
            | Device::Floor(_)
            | Device::Battery(_)
            | Device::StrainGauge(_)
            | Device::IrBeacons(_) => None,
        }
    }

    fn of_voltage(ranger: &VoltageRanger) -> Self {
        let curve = Curve::of(ranger.range_m, |distance_m| ranger.voltage_at(distance_m));
        let nearest_m = curve.nearest_m();
        Self {
            radiation: Radiation::Infrared,
            field_of_view_rad: ranger.fan.opening_rad(),
            range_m: [nearest_m, ranger.range_m],
            curve,
        }
    }

    /// The message of a reading. What is out of range is endless, as the enhancement proposal 117 of ROS wants it.
    pub(super) fn reading(&self, value: f64) -> RangeReading {
        let [least_m, most_m] = self.range_m;
        let distance_m = match &self.curve {
            Curve::Distance => Some(value).filter(|&distance_m| distance_m < most_m),
            Curve::Points(points) => farthest(points, value),
        };
        RangeReading {
            radiation: self.radiation,
            field_of_view_rad: self.field_of_view_rad,
            range_m: [least_m, most_m],
            distance_m: distance_m.unwrap_or(f64::INFINITY),
        }
    }
}

/// Whether its place on the robot does not change.
pub(super) fn is_fixed(mount: &Mount) -> bool {
    mount.turret.is_none()
}

impl Curve {
    fn of(range_m: f64, read: impl Fn(f64) -> f64) -> Self {
        let distance = |i: u32| range_m * f64::from(i) / f64::from(POINTS);
        Self::Points((0..=POINTS).map(|i| (distance(i), read(distance(i)))).collect())
    }

    /// The distance behind the last hump: nearer distances look like farther ones.
    fn nearest_m(&self) -> f64 {
        match self {
            Self::Distance => 0.0,
            Self::Points(points) => {
                let top = points.iter().map(|point| point.1).fold(f64::NEG_INFINITY, f64::max);
                points.iter().rfind(|point| point.1 == top).map_or(0.0, |point| point.0)
            }
        }
    }
}

/// The farthest distance with this reading, on straight lines between the points; none if that is beyond the last.
fn farthest(points: &[(f64, f64)], value: f64) -> Option<f64> {
    let last = points.iter().rposition(|point| point.1 >= value);
    let Some(i) = last else {
        // A value above the whole curve stands for the nearest distance.
        let top = points.iter().copied().reduce(|a, b| if b.1 >= a.1 { b } else { a })?;
        return Some(top.0);
    };
    let (near_m, more) = points[i];
    let (far_m, less) = *points.get(i + 1)?;
    Some(near_m + (far_m - near_m) * (more - value) / (more - less))
}

/// The mean reading of an IR sensor for a wide wall straight ahead; nothing if it measures the light around it.
fn reading(infrared: &Infrared) -> Option<impl Fn(f64) -> f64> {
    let is_lit = !matches!(infrared.model, InfraredModel::Ambient { .. });
    is_lit.then_some(|distance_m: f64| match &infrared.model {
        InfraredModel::Phenomenological { c1_m2, c2 } => {
            let of_ray = |i: usize| {
                let cos_kappa = infrared.fan.cos_kappa(i);
                let ray_m = distance_m / cos_kappa;
                let is_near = cos_kappa > 0.0 && ray_m < infrared.range_m;
                if is_near { (cos_kappa * (c1_m2 / (ray_m * ray_m) + c2)).min(1.0) } else { 0.0 }
            };
            (0..infrared.fan.len()).map(of_ray).sum::<f64>() / infrared.fan.len() as f64
        }
        InfraredModel::Lookup(lookup) => lookup.moments(distance_m, 0.0).0,
        InfraredModel::Ambient { .. } => 0.0,
    })
}

/// The points of a curve: steps of a millimetre for a sensor with a range of half a metre.
const POINTS: u32 = 500;

#[cfg(test)]
mod tests {
    use baudbot_scenario::parse;

    use super::*;

    /// This sensor, on a robot.
    fn device(sensor: &str) -> Device {
        let body = "body = { radius_m = 0.2, mass_kg = 3, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }";
        let toml = format!("[[robots]]\nname = \"r\"\n{body}\nsensors.s = {{ {sensor} }}\n");
        let scenario = parse(&toml).unwrap_or_else(|error| panic!("{error}"));
        scenario.robots[0].sensors.iter().next().unwrap().device.clone()
    }

    fn told(sensor: &str, value: f64) -> RangeReading {
        Ranger::of(&device(sensor)).unwrap().reading(value)
    }

    #[test]
    fn a_reading_becomes_the_distance_at_which_it_is_read() {
        let sharp = "preset = \"gp2d12\", mount = {}";
        let least_m = told(sharp, 1.0).range_m[0];
        assert!(least_m > 0.04 && least_m < 0.11, "{least_m}: behind the hump");
        let Device::VoltageRanger(ranger) = device(sharp) else { panic!("it is one") };
        for distance_m in [0.12, 0.2, 0.35, 0.5, 0.7] {
            let found_m = told(sharp, ranger.voltage_at(distance_m)).distance_m;
            assert!((found_m - distance_m).abs() < 0.002, "{distance_m} became {found_m}");
        }
        assert_eq!(told(sharp, 0.0).distance_m, f64::INFINITY);
        let ir =
            "kind = \"ir\", mount = {}, opening_rad = 0.5, rays = 1, range_m = 0.2, c1_m2 = 0.001, c2 = 0.0";
        // (3.13) with one ray: 0.001 / 0.1².
        assert!((told(ir, 0.1).distance_m - 0.1).abs() < 1e-4);
        assert_eq!(told(ir, 0.0).distance_m, f64::INFINITY);
        let sonar = "kind = \"sonar\", mount = {}, opening_rad = 0.5, rays = 3, min_m = 0.03, max_m = 3.0";
        assert_eq!(told(sonar, 1.25).distance_m, 1.25);
        assert_eq!(told(sonar, 3.0).distance_m, f64::INFINITY);
    }

    #[test]
    fn what_measures_light_or_turns_about_is_none() {
        let ambient = "kind = \"ir\", mount = {}, opening_rad = 0.5, rays = 5, range_m = 0.2, ambient_saturation_lux = 500.0";
        assert!(Ranger::of(&device(ambient)).is_none());
        assert!(Ranger::of(&device("kind = \"compass\"")).is_none());
    }
}
