//! The time of an echo: the brain sends the next command when the answer to the last one is there.

use baudbot_brain::{Body, RawCommands};
use baudbot_sim::drive::Wheels;
use baudbot_sim::{Answer, World, Written};
use serde::Deserialize;

use super::{ExperimentError, lab};

/// Echoes over a serial cable: a command of two bytes, and a reading of one. What was measured are echoes of one byte, so
/// that characters are shorter here, and three take the time of the measured ones.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Echo {
    /// Characters that an echo takes on the cable: two if a robot sends the byte back, one through a loopback plug.
    pub characters: f64,
    /// Bits of a character on the real cable. Here it has 10, and the baud rate is such that it takes as long.
    pub bits_per_character: f64,
    /// Number of exchanges.
    pub exchanges: usize,
    /// The robot's processor, a preset.
    pub microcontroller: String,
}

impl Echo {
    /// Times of the echoes, in milliseconds, through an adapter of a preset, or through none.
    pub(super) fn run(&self, adapter: Option<&str>, baud: f64) -> Result<Vec<f64>, ExperimentError> {
        let adapter =
            adapter.map(|name| format!(", adapter = {{ preset = \"{name}\" }}")).unwrap_or_default();
        let toml = format!(
            "step_ms = {STEP_MS:?}\n[[robots]]\nname = \"robot\"\n{}\n\
             motors.signal_bits = 8\n\
             microcontroller.preset = \"{}\"\n\
             firmware = {{ protocol = \"bare\", mode = \"poll\" }}\n\
             sensors.compass = {{ kind = \"compass\", bits = 8, period_ms = 1000.0 }}\n\
             link = {{ kind = \"uart\", baud = {}, bits_per_character = 10{adapter} }}\n",
            lab::DISC,
            self.microcontroller,
            (3.0 / self.characters * baud * 10.0 / self.bits_per_character) as u32,
        );
        let world = lab::specimens(&toml, 1)?.next();
        Ok(world.map(|world| self.exchange(world)).unwrap_or_default())
    }

    fn exchange(&self, mut world: World) -> Vec<f64> {
        let body = Body::from(world.robot(0).spec());
        let mut commands =
            RawCommands::new(&body).expect("the scenario was read, so its messages fit the wire");
        let (mut echoes_ms, mut sent) = (Vec::new(), None);
        while echoes_ms.len() < self.exchanges {
            let turn = world.begin().first().copied();
            let arrived = world.has_message(0);
            let Some(turn) = turn.filter(|_| arrived || sent.is_none()) else {
                world.finish(&[]);
                continue;
            };
            echoes_ms.extend(sent.map(|sent| turn.at.since(sent) as f64 * 1e-6));
            let sequence = commands.next_command(&[]);
            let written = Written::Command { sequence, wheels: Wheels::default(), others: &[] };
            world.finish_answers(&[Answer { robot: 0, at: turn.at, written }]);
            sent = Some(turn.at);
        }
        echoes_ms
    }
}

/// A brain steps at most once a tick, so that this must be shorter than any echo.
const STEP_MS: f64 = 0.05;
