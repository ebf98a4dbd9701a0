//! ARSim's odometer: an estimate of the pose from the ways that the wheels rolled (2.7)–(2.9), with noise
//! added in metres per wheel and per read.
//!
//! Deviation from good sense, kept because it is ARSim's: the noise does not scale with the way, so the
//! estimate wanders even when the robot stands. A brain that wants honest odometry reads the encoders and
//! integrates them itself.

use baudbot_geometry::{Pose, Twist, angle, math};
use serde::{Deserialize, Serialize};

use super::{Measurement, noise};
use crate::drive::Wheels;
use crate::random::Stream;
use crate::sound;

/// What an odometer is.
#[derive(Clone, Debug, PartialEq)]
pub struct Odometer {
    /// Standard deviation of each wheel's displacement, in metres a read.
    pub sigma_m: f64,
}

/// The odometer's state: its pose, and the wheels' travel that it has accounted for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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

impl Odometer {
    /// The estimated x, y (metres) and heading (radians, in (−π, π]).
    pub(super) fn read(
        &self,
        at: &Measurement<'_>,
        estimate: &mut Estimate,
        stream: &mut Stream,
    ) -> [f64; 3] {
        let sigma = if at.noise { self.sigma_m } else { 0.0 };
        let travel = at.motion.travel_m;
        let left = noise::additive(travel.left - estimate.travel_m.left, sigma, stream);
        let right = noise::additive(travel.right - estimate.travel_m.right, sigma, stream);
        estimate.travel_m = travel;

        let pose = &mut estimate.pose;
        let Twist { forward, turn } = Twist::of_wheels([left, right], at.robot.drive.half_track_m);
        pose.heading = angle::wrap(pose.heading + turn);
        let (sin, cos) = math::sin_cos(pose.heading);
        pose.position.x += forward * cos;
        pose.position.y += forward * sin;
        [pose.position.x, pose.position.y, pose.heading]
    }
}
