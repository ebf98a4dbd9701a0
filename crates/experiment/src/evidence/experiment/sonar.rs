//! The echoes of an ultrasonic sensor.

use baudbot_geometry::math;
use baudbot_sim::World;
use serde::Deserialize;

use super::{ExperimentError, lab};
use crate::evidence::at::At;

/// A flat board that faces the sensor, at angles from the sensor's axis.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cone {
    /// The preset of the sensor.
    pub preset: String,
    /// Width of the board, in metres.
    pub width_m: f64,
}

/// A target on the sensor's axis, ever farther off.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Farthest {
    /// The preset of the sensor.
    pub preset: String,
    /// The targets, by the names that the points have.
    pub targets: Vec<Target>,
}

/// A target.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// The name of the target.
    pub name: String,
    /// The target's form.
    pub form: Form,
    /// The width of the target, in metres.
    pub width_m: f64,
    /// The height of the target, in metres: from the sensor as far down as up.
    pub height_m: f64,
}

/// The form of a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// A plate that faces the sensor.
    Plate,
    /// An upright cylinder.
    Cylinder,
}

impl Cone {
    /// The largest angle from the axis, in degrees, at which the board's middle gives an echo at this distance in
    /// metres.
    pub(super) fn run(&self, distance_m: f64) -> Result<Vec<f64>, ExperimentError> {
        let mut widest = 0.0;
        for half_degrees in 0..120 {
            let degrees = 0.5 * f64::from(half_degrees);
            let target =
                Target { name: "board".into(), form: Form::Plate, width_m: self.width_m, height_m: 2.0 };
            if hears(&self.preset, &target, distance_m, degrees.to_radians())? {
                widest = degrees;
            } else {
                break;
            }
        }
        Ok(vec![widest])
    }
}

impl Farthest {
    /// The largest distance, in metres, at which the target gives an echo in most readings.
    pub(super) fn run(&self, name: &str) -> Result<Vec<f64>, ExperimentError> {
        let Some(target) = self.targets.iter().find(|target| target.name == name) else {
            return Err(ExperimentError::At { expected: "the name of a target", at: At::Name(name.into()) });
        };
        let mut farthest = 0.0;
        for hundredths in (10..=500).step_by(5) {
            let distance_m = 0.01 * f64::from(hundredths);
            if hears(&self.preset, target, distance_m, 0.0)? {
                farthest = distance_m;
            }
        }
        Ok(vec![farthest])
    }
}

/// Whether a sensor gets an echo of a target, in more than half of ten readings.
fn hears(preset: &str, target: &Target, distance_m: f64, off_axis_rad: f64) -> Result<bool, ExperimentError> {
    // The robot stands in the origin with the sensor on its rim, and the sensor looks at the target's middle.
    let toml = format!(
        "step_ms = 100.0\nsubsteps = 100\n[arena]\n{}\n[[robots]]\nname = \"robot\"\n{}\n\
         sensors.sonar.preset = \"{preset}\"\nsensors.sonar.height_m = {:?}\n",
        thing(target, distance_m, off_axis_rad),
        lab::DISC,
        0.5 * target.height_m
    );
    let world = lab::specimens(&toml, 1)?.next();
    let heard = world.map(|world| heard(world, distance_m)).unwrap_or_default();
    Ok(heard > READINGS / 2)
}

/// A target that stands on the floor, beside the sensor's axis.
fn thing(target: &Target, distance_m: f64, off_axis_rad: f64) -> String {
    let (sin, cos) = math::sin_cos(off_axis_rad);
    let (x, y) = (lab::RIM_M + distance_m * cos, distance_m * sin);
    let Target { width_m, height_m, .. } = target;
    match target.form {
        Form::Plate => {
            let corner = |side: f64, behind_m: f64| {
                let beside_m = side * 0.5 * width_m;
                format!(
                    "[{:?}, {:?}]",
                    x - beside_m * sin + behind_m * cos,
                    y + beside_m * cos + behind_m * sin
                )
            };
            let corners =
                [corner(-1.0, 0.0), corner(-1.0, 0.01), corner(1.0, 0.01), corner(1.0, 0.0)].join(", ");
            format!(
                "polygons = [{{ name = \"plate\", solid = true, points_m = [{corners}], height_m = {height_m:?} }}]"
            )
        }
        Form::Cylinder => {
            let (radius_m, middle_m) = (0.5 * width_m, x + 0.5 * width_m);
            format!(
                "circles = [{{ name = \"cylinder\", x_m = {middle_m:?}, y_m = {y:?}, radius_m = {radius_m:?}, height_m = {height_m:?} }}]"
            )
        }
    }
}

fn heard(mut world: World, distance_m: f64) -> usize {
    let (mut readings, mut samples, mut heard) = (0, 0, 0);
    let nothing_m = world.robot(0).spec().sensors[0].device.range_m().unwrap_or(f64::INFINITY);
    while readings < READINGS {
        lab::idle(&mut world);
        let robot = world.robot(0);
        let Some(sensor) = robot.sensors().next() else { break };
        if sensor.samples > samples && !sensor.sample.is_empty() {
            samples = sensor.samples;
            readings += 1;
            heard += usize::from(sensor.sample[0] < nothing_m && (sensor.sample[0] - distance_m).abs() < 0.1);
        }
    }
    heard
}

const READINGS: usize = 10;
