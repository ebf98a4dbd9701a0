//! The time of commands on their way to a robot.

use baudbot_run::{BareWorld, LockstepWorld};
use serde::Deserialize;

use super::{ExperimentError, lab};

/// Commands, one a second, over a link of a preset.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OneWay {
    /// Number of commands.
    pub commands: usize,
}

impl OneWay {
    /// Times from when a command is written until it is obeyed, in milliseconds.
    pub(super) fn run(&self, link: &str) -> Result<Vec<f64>, ExperimentError> {
        let toml = format!(
            "step_ms = 1.0\nsubsteps = 1\n[[robots]]\nname = \"robot\"\n{}\nmotors.signal_bits = 8\n\
             firmware = {{ protocol = \"bare\", mode = \"poll\", gap_ms = 500.0 }}\n\
             sensors.compass = {{ kind = \"compass\", bits = 8, period_ms = 1000.0 }}\nlink.preset = \"{link}\"\n",
            lab::DISC
        );
        let mut delays_ms = Vec::new();
        for world in lab::specimens(&toml, 1)? {
            let mut world = BareWorld::new(world);
            let (mut obeyed, mut sent) = (0, None);
            while delays_ms.len() < self.commands {
                world.begin();
                let is_due = |at_ns: u64| sent.is_none() && at_ns % 1_000_000_000 < 1_000_000;
                if let Some(&turn) = world.turns().first().filter(|turn| is_due(turn.at.as_ns())) {
                    lab::command(&mut world, turn, [0.0; 2]);
                    sent = Some(turn.at);
                }
                world.finish();
                let count = world.robot(0).commands();
                if count > obeyed {
                    obeyed = count;
                    delays_ms.extend(sent.take().map(|sent| world.time().since(sent) as f64 * 1e-6));
                }
            }
        }
        Ok(delays_ms)
    }
}
