//! Experiments with real robots, repeated in worlds of ours.

mod battery;
mod echo;
mod facing_wall;
mod gps;
mod lab;
mod motion;
mod one_way;
mod sampling;
mod sonar;

use baudbot_scenario::ScenarioError;
use serde::Deserialize;

use crate::evidence::at::At;
use crate::evidence::sample::Sample;

pub use battery::{Discharge, Quantity};
pub use echo::Echo;
pub use facing_wall::FacingWall;
pub use gps::AtRest;
pub use motion::{Speed, StepRate, TurnStep};
pub use one_way::OneWay;
pub use sampling::{Instants, Sampling};
pub use sonar::{Cone, Farthest, Form, Target};

/// An experiment in a world. Each experiment takes what is varied from the measured points.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Experiment {
    /// A sensor faces a white wall.
    FacingWall(FacingWall),
    /// Echoes at 115,200 baud through the adapters that the points name; `none` is no adapter.
    EchoOfAdapter(Echo),
    /// Echoes through an FTDI adapter with a timer of 1 ms at the baud rates that the points have.
    EchoAtBaud(Echo),
    /// A robot begins to turn.
    TurnStep(TurnStep),
    /// A robot drives from a standstill with the commands that the points have.
    Speed(Speed),
    /// A stepper motor is commanded to the rates of the points, in steps a second.
    StepRate(StepRate),
    /// A robot's sensors are read.
    Sampling(Sampling),
    /// A board that faces an ultrasonic sensor at the distances in metres that the points have.
    Cone(Cone),
    /// Targets on the axis of an ultrasonic sensor.
    Farthest(Farthest),
    /// A battery that is discharged at the currents in amperes that the points have.
    Discharge(Discharge),
    /// A satellite receiver that stands still; the points are its axes.
    AtRest(AtRest),
    /// Commands over the links that the points name.
    OneWay(OneWay),
}

/// A reason why an experiment was not done.
#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    /// No scenario came of it.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A point has a name where the experiment needs a number, or the other way round.
    #[error("a point must be at {expected}, is at {at:?}")]
    At {
        /// The expected thing.
        expected: &'static str,
        /// The place of the point.
        at: At,
    },
    /// Nothing was read.
    #[error("nothing was measured in the world at {at:?}")]
    Nothing {
        /// The place of the point.
        at: At,
    },
}

impl Experiment {
    /// Does it at each point.
    ///
    /// # Errors
    /// If there is no such experiment at a point.
    pub(crate) fn run(&self, at: &[&At]) -> Result<Vec<Sample>, ExperimentError> {
        at.iter().map(|at| self.run_at(at)).collect()
    }

    fn run_at(&self, at: &At) -> Result<Sample, ExperimentError> {
        let values = match self {
            Self::FacingWall(experiment) => experiment.run(number(at)?)?,
            Self::EchoOfAdapter(experiment) => {
                experiment.run(Some(name(at)?).filter(|name| *name != "none"), 115_200.0)?
            }
            Self::EchoAtBaud(experiment) => experiment.run(Some("ft232r-1ms"), number(at)?)?,
            Self::TurnStep(experiment) => experiment.run(name(at)?)?,
            Self::Speed(experiment) => experiment.run(number(at)?)?,
            Self::StepRate(experiment) => experiment.run(number(at)?)?,
            Self::Sampling(experiment) => experiment.run(number(at)?)?,
            Self::Cone(experiment) => experiment.run(number(at)?)?,
            Self::Farthest(experiment) => experiment.run(name(at)?)?,
            Self::Discharge(experiment) => experiment.run(number(at)?)?,
            Self::AtRest(experiment) => experiment.run(name(at)?)?,
            Self::OneWay(experiment) => experiment.run(name(at)?)?,
        };
        Sample::of(&values).ok_or_else(|| ExperimentError::Nothing { at: at.clone() })
    }
}

fn number(at: &At) -> Result<f64, ExperimentError> {
    match at {
        At::Number(number) => Ok(*number),
        At::Name(_) => Err(ExperimentError::At { expected: "a number", at: at.clone() }),
    }
}

fn name(at: &At) -> Result<&str, ExperimentError> {
    match at {
        At::Name(name) => Ok(name),
        At::Number(_) => Err(ExperimentError::At { expected: "a name", at: at.clone() }),
    }
}
