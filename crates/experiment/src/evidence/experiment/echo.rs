//! The time of an echo: the brain sends the next command when the answer to the last one is there.

use baudbot_run::{BareWorld, LockstepWorld};
use baudbot_sim::World;
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

    fn exchange(&self, world: World) -> Vec<f64> {
        let mut world = BareWorld::new(world);
        let (mut echoes_ms, mut sent) = (Vec::new(), None);
        while echoes_ms.len() < self.exchanges {
            world.begin();
            let has_answer = sent.is_none() || world.has_message(0);
            if let Some(&turn) = world.turns().first().filter(|_| has_answer) {
                echoes_ms.extend(sent.map(|sent| turn.at.since(sent) as f64 * 1e-6));
                lab::command(&mut world, turn, [0.0; 2]);
                sent = Some(turn.at);
            }
            world.finish();
        }
        echoes_ms
    }
}

/// A brain steps at most once a tick, so that this must be shorter than any echo.
const STEP_MS: f64 = 0.05;
