//! The cognitive process *Odometry*: where the robot is, by counting what its wheels do.

use baudbot_brain::{Body, SensorKind};
use baudbot_geometry::Pose;
use serde::Deserialize;

use crate::odometry::{self, Calibration, OVERDUE_NS, Odometry};
use crate::parameter::{ParameterError, check_not_negative, check_positive};
use crate::process::{Awaited, CognitiveProcess, StepContext};

/// The sensors that it counts by.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// Name of a sensor of kind `encoders` or `odometer`.
    pub sensor: String,
    /// The pose at the start, `[x in m, y in m, heading in rad]`. Without it encoders start at the origin, and an
    /// odometer at its own pose.
    pub start: Option<[f64; 3]>,
    /// Variance of the error of a wheel's way, in square metres for each metre that it goes.
    pub variance_m2_per_m: f64,
    /// Diameters of the left and of the right wheel, as multiples of the data sheet's.
    pub wheel_factors: [f64; 2],
    /// Distance between the wheels, as a multiple of the data sheet's.
    pub track_factor: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            sensor: "odometer".to_owned(),
            start: None,
            variance_m2_per_m: 1e-4,
            wheel_factors: [1.0; 2],
            track_factor: 1.0,
        }
    }
}

/// A process that believes its wheels.
#[derive(Clone, Debug, PartialEq)]
pub struct CountWheels {
    parameters: odometry::Parameters,
    sensor: String,
    start: Option<Pose>,
}

impl CountWheels {
    /// A `CountWheels` for a robot with this body; an error if it has no such sensor.
    ///
    /// # Errors
    /// See [`ParameterError`].
    pub fn new(parameters: &Parameters, body: &Body) -> Result<Self, ParameterError> {
        let Some(known) = odometry::Parameters::of(body, &parameters.sensor) else {
            let (robot, sensor) = (&body.name, &parameters.sensor);
            let problem = format_args!("robot `{robot}` has no encoders and no odometer called `{sensor}`");
            return Err(ParameterError::value("sensor", problem));
        };
        let variance_m2_per_m = parameters.variance_m2_per_m;
        check_not_negative([("variance_m2_per_m", variance_m2_per_m)])?;
        let (wheels, track) = (parameters.wheel_factors, parameters.track_factor);
        let [left, right] = wheels;
        check_positive([("wheel_factors[0]", left), ("wheel_factors[1]", right), ("track_factor", track)])?;
        let is_odometer =
            body.sensor(&parameters.sensor).is_some_and(|sensor| sensor.kind == SensorKind::Odometer);
        let start = parameters.start.map(|[x, y, heading]| Pose::new(x, y, heading));
        let start = start.or_else(|| (!is_odometer).then(|| Pose::new(0.0, 0.0, 0.0)));
        let calibration = Calibration { wheels, track };
        let known = odometry::Parameters { variance_m2_per_m, calibration, ..known };
        Ok(Self { parameters: known, sensor: parameters.sensor.clone(), start })
    }
}

impl CognitiveProcess for CountWheels {
    fn step(&mut self, context: &mut StepContext<'_>) {
        if context.beliefs.odometry.is_none() {
            context.beliefs.odometry =
                Odometry::starting(self.parameters, context.turn, &self.sensor, self.start);
        }
        let Some(odometry) = &mut context.beliefs.odometry else {
            context.beliefs.awaited = Some(Awaited { sensor: self.sensor.clone(), since_ns: 0 });
            return;
        };
        odometry.read(context.turn, &self.sensor);
        context.beliefs.pose = Some(odometry.estimate());
        if odometry.is_overdue(context.turn.at_ns, OVERDUE_NS) {
            context.beliefs.awaited = Some(odometry.awaited());
        }
    }
}
