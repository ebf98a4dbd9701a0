//! The time of commands on their way to a robot.

use baudbot_brain::{Body, RawCommands};
use baudbot_sim::drive::Wheels;
use baudbot_sim::{Answer, Written};
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
        for mut world in lab::specimens(&toml, 1)? {
            let body = Body::from(world.robot(0).spec());
            let mut commands =
                RawCommands::new(&body).expect("the scenario was read, so its messages fit the wire");
            let (mut obeyed, mut sent) = (0, None);
            while delays_ms.len() < self.commands {
                let turn = world.begin().first().copied();
                match turn.filter(|turn| sent.is_none() && turn.at.as_ns() % 1_000_000_000 < 1_000_000) {
                    Some(turn) => {
                        let sequence = commands.next_command(&[]);
                        let written = Written::Command { sequence, wheels: Wheels::default(), others: &[] };
                        world.finish_answers(&[Answer { robot: 0, at: turn.at, written }]);
                        sent = Some(turn.at);
                    }
                    None => world.finish(&[]),
                }
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
