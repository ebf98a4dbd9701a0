//! A fixed action pattern: motions one after the other that, once released, run to their end whatever comes. Wahde 2016, §4.4.3.
//!
//! The greylag goose rolls an egg towards its nest, and goes on to its chest also if the egg is taken away; the mantis strikes. What
//! releases the pattern is decided outside of it, by a state variable: the innate releasing mechanism. Motions are open-loop. After its
//! end the robot stands until another behaviour has been active, so a releaser that stays there releases the pattern once.

use baudbot_brain::Signals;
use serde::Deserialize;

use crate::parameter::ParameterError;
use crate::process::{MotorBehavior, StepContext};

/// The motions of the pattern.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// The motions, in their order: the signal of the left motor, that of the right one, and the duration in seconds.
    pub motions: Vec<[f64; 3]>,
}

/// A behaviour that cannot be stopped once it has begun.
#[derive(Clone, Debug, PartialEq)]
pub struct FixedAction {
    pub(crate) motions: Vec<[f64; 3]>,
    /// The instant at which it was released.
    since_ns: Option<u64>,
}

impl FixedAction {
    /// A pattern at rest.
    ///
    /// # Errors
    /// If it has no motion or one that takes no time, or takes more than an hour.
    pub fn new(parameters: Parameters) -> Result<Self, ParameterError> {
        let Parameters { motions } = parameters;
        if motions.is_empty() {
            return Err(ParameterError::value("motions", "has no motion, such as [0.2, 0.2, 1.5]"));
        }
        if let Some(place) = motions.iter().position(|[_, _, seconds]| seconds.is_nan() || *seconds <= 0.0) {
            let problem = "must take some time: [left, right, seconds]";
            return Err(ParameterError::value(format_args!("motions[{place}]"), problem));
        }
        let seconds: f64 = motions.iter().map(|[_, _, seconds]| seconds).sum();
        if seconds > LONGEST_S {
            let problem =
                format_args!("must take an hour at most, as nothing ends them, and take {seconds} s");
            return Err(ParameterError::value("motions", problem));
        }
        Ok(Self { motions, since_ns: None })
    }
}

impl MotorBehavior for FixedAction {
    fn enter(&mut self, context: &mut StepContext<'_>) {
        self.since_ns = Some(context.turn.at_ns);
    }

    fn step(&mut self, context: &mut StepContext<'_>) -> Option<Signals> {
        let since_ns = self.since_ns?;
        let mut left_s = context.turn.at_ns.saturating_sub(since_ns) as f64 * 1e-9;
        for [left, right, seconds] in &self.motions {
            if left_s < *seconds {
                return Some(Signals { left: *left, right: *right });
            }
            left_s -= seconds;
        }
        self.since_ns = None;
        Some(Signals::default())
    }

    fn leave(&mut self, _: &mut StepContext<'_>) {
        self.since_ns = None;
    }

    fn is_fixed(&self) -> bool {
        self.since_ns.is_some()
    }
}

/// The longest pattern, in seconds.
const LONGEST_S: f64 = 3600.0;
