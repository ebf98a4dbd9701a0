//! A brain for a baudbot robot: behaviours of the crate `baudbot-brains`, and one of its own. `brain.toml` says which of
//! them the brain has, and when each is useful.

use std::process::ExitCode;

use baudbot_brains::process::{MotorBehavior, StepContext};
use baudbot_brains::program;
use baudbot_brains::registry::Registry;
use baudbot_client::Signals;
use serde::Deserialize;

/// The `parameters` of `brain.toml`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Parameters {
    forward: f64,
}

/// Drives in wavy lines.
struct Weave {
    parameters: Parameters,
    elapsed_s: f64,
}

impl MotorBehavior for Weave {
    /// Called in each step in which the behaviour is active. `context.turn` has the readings.
    fn step(&mut self, context: &mut StepContext<'_>) -> Option<Signals> {
        self.elapsed_s += context.dt_s;
        let lean = if (self.elapsed_s as u64).is_multiple_of(2) { 0.3 } else { -0.3 };
        let forward = self.parameters.forward;
        Some(Signals { left: forward * (1.0 - lean), right: forward * (1.0 + lean) })
    }
}

fn main() -> ExitCode {
    let mut registry = Registry::standard();
    registry.motors.add("weave", |parameters: Parameters, _| Ok(Weave { parameters, elapsed_s: 0.0 }));
    program::described(&registry)
}
