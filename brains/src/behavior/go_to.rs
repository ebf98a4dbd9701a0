//! Point-to-point navigation by the believed pose: one point after the other, straight on, more slowly near the last.

use baudbot_brain::Signals;
use baudbot_geometry::{Pose, math};
use serde::Deserialize;

use crate::navigation::Goals;
use crate::parameter::ParameterError;
use crate::process::{MotorBehavior, StepContext};
use crate::steering::{Helm, Steering, braking};

/// The points of the tour and the steering.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Points `[x, y]`, in metres, in the frame of the believed pose.
    pub points_m: Vec<[f64; 2]>,
    /// A point is reached within this distance, in metres.
    #[serde(default = "reached_m")]
    pub reached_m: f64,
    /// The first point comes again after the last.
    #[serde(default)]
    pub again: bool,
    /// The gains and speeds of its steering.
    #[serde(default)]
    pub steering: Steering,
}

fn reached_m() -> f64 {
    0.05
}

/// A behaviour that visits points.
#[derive(Clone, Debug, PartialEq)]
pub struct GoTo {
    goals: Goals,
    helm: Helm,
}

impl GoTo {
    /// A `GoTo` at its start.
    ///
    /// # Errors
    /// If the parameters are invalid.
    pub fn new(parameters: &Parameters) -> Result<Self, ParameterError> {
        let Parameters { points_m, reached_m, again, steering } = parameters;
        steering.check()?;
        Ok(Self { goals: Goals::new("points_m", points_m, *reached_m, *again)?, helm: Helm::new(*steering) })
    }

    /// Whether all points have been reached.
    pub fn has_arrived(&self) -> bool {
        self.goals.has_arrived()
    }

    fn toward(&mut self, world_from_robot: &Pose) -> Signals {
        let Some(goal) = self.goals.from(world_from_robot.position) else { return Signals::default() };
        let offset = goal - world_from_robot.position;
        let part = if self.goals.is_last() { braking(offset.norm()) } else { 1.0 };
        self.helm.signals(world_from_robot, math::atan2(offset.y, offset.x), part)
    }
}

impl MotorBehavior for GoTo {
    /// The tour begins with the first point again if the robot had arrived; one that was interrupted goes on.
    fn enter(&mut self, _: &mut StepContext<'_>) {
        self.goals.begin();
    }

    fn step(&mut self, context: &mut StepContext<'_>) -> Option<Signals> {
        let Some(estimate) = context.beliefs.pose else { return Some(Signals::default()) };
        let signals = self.toward(&estimate.world_from_robot);
        context.beliefs.path = self.goals.left().to_vec();
        context.beliefs.intention = if self.has_arrived() { "has arrived".to_owned() } else { String::new() };
        Some(signals)
    }

    fn goes_by_pose(&self) -> bool {
        true
    }
}
