//! A behaviour of one's own in a brain that a file describes:
//! `cargo run --example own_behavior -p baudbot-brains -- brains/examples/own_behavior.toml --world wander`.

use std::process::ExitCode;

use baudbot_brains::process::{Moment, MotorBehavior};
use baudbot_brains::program;
use baudbot_brains::registry::Registry;
use baudbot_client::Signals;
use serde::Deserialize;

/// What the file may say under `parameters`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Parameters {
    forward: f64,
    /// How long a way to one side takes, in seconds.
    #[serde(default = "half_period_s")]
    half_period_s: f64,
}

fn half_period_s() -> f64 {
    1.0
}

/// Drives in wavy lines.
struct Weave {
    parameters: Parameters,
    elapsed_s: f64,
}

impl MotorBehavior for Weave {
    fn enter(&mut self, _: &mut Moment<'_>) {
        self.elapsed_s = 0.0;
    }

    fn step(&mut self, moment: &mut Moment<'_>) -> Option<Signals> {
        self.elapsed_s += moment.dt_s;
        let leftwards = ((self.elapsed_s / self.parameters.half_period_s) as u64).is_multiple_of(2);
        let lean = if leftwards { 0.3 } else { -0.3 };
        moment.beliefs.intention = if leftwards { "to the left" } else { "to the right" }.to_owned();
        let forward = self.parameters.forward;
        Some(Signals { left: forward * (1.0 - lean), right: forward * (1.0 + lean) })
    }
}

fn main() -> ExitCode {
    let mut registry = Registry::standard();
    registry.motor("weave", |parameters: Parameters, _| Ok(Weave { parameters, elapsed_s: 0.0 }));
    program::described(&registry)
}
