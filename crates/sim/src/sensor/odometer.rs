//! ARSim's odometer: an estimate of the pose from the ways that the wheels rolled (2.7)–(2.9), with noise
//! added in metres per wheel and per read.
//!
//! Deviation from good sense, kept because it is ARSim's: the noise does not scale with the way, so the
//! estimate wanders even when the robot stands. A brain that wants honest odometry reads the encoders and
//! integrates them itself.

use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::PI;

use baudbot_geometry::{Pose, Twist, angle, math};
use serde::{Deserialize, Serialize};

use super::kind::{Built, Component, Effect, Fit, Place, Sense, level};
use super::{Measurement, noise};
use crate::drive::Wheels;
use crate::random::Stream;
use crate::sound;
use baudbot_fields::number::{Length, Number, Sigma};
use baudbot_fields::{FieldError, Path};

/// The model of an odometer.
#[derive(Clone, Debug, PartialEq)]
pub struct Odometer {
    /// Standard deviation of each wheel's displacement, in metres a read.
    pub sigma_m: f64,
}

/// The odometer's state: its pose, and the wheels' travel that it has accounted for.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Estimate {
    pose: Pose,
    travel_m: Wheels,
}

impl Estimate {
    pub(super) fn is_sound(&self) -> bool {
        sound::pose(&self.pose) && sound::wheels(&self.travel_m)
    }

    /// `CalibrateOdometer`: the estimate starts at the true pose.
    pub(crate) fn calibrated(start: &Pose) -> Self {
        Self { pose: *start, travel_m: Wheels::default() }
    }
}

/// The fields of its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Sheet {
    /// Standard deviation of the noise on each wheel's displacement, per read.
    #[serde(default)]
    sigma_m: Number<Sigma>,
    /// With `bits`: x and y are sent as levels from minus this to this, the heading as a level from −π to π.
    #[serde(default = "Number::<Length>::constant::<10>")]
    position_range_m: Number<Length>,
}

impl Sense for Odometer {
    const NAME: &str = "odometer";
    const PLACE: Place = Place::Inside;
    const IS_ANALOG: bool = false;
    type Sheet = Sheet;
    type Memory = Estimate;

    fn new(sheet: Sheet, _: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let range = sheet.position_range_m.get();
        let position = level(fit.bits, -range, range);
        let encodings = vec![position, position, level(fit.bits, -PI, PI)];
        Ok(Built::new(Self { sigma_m: sheet.sigma_m.get() }, encodings))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("x_m", "m"), Component::one("y_m", "m"), Component::one("heading_rad", "rad")]
    }

    /// An odometer is calibrated: it starts at the true pose.
    fn remember(&self, start: &Pose, _: &mut Stream) -> Estimate {
        Estimate::calibrated(start)
    }

    /// The estimated x, y (metres) and heading (radians, in (−π, π]): (2.7)–(2.9).
    fn read(
        &self,
        at: &Measurement<'_>,
        estimate: &mut Estimate,
        stream: &mut Stream,
        values: &mut [f64],
    ) -> Effect {
        let sigma = if at.noise { self.sigma_m } else { 0.0 };
        let travel = at.motion.travel_m;
        let left = noise::additive(travel.left - estimate.travel_m.left, sigma, stream);
        let right = noise::additive(travel.right - estimate.travel_m.right, sigma, stream);
        estimate.travel_m = travel;

        let pose = &mut estimate.pose;
        let Twist { forward, turn } = Twist::of_wheels([left, right], at.drive.half_track_m);
        pose.heading = angle::wrap(pose.heading + turn);
        let (sin, cos) = math::sin_cos(pose.heading);
        pose.position.x += forward * cos;
        pose.position.y += forward * sin;
        values.copy_from_slice(&[pose.position.x, pose.position.y, pose.heading]);
        Effect::NONE
    }
}
