//! A robot whose microcontroller runs a program of the user's own: see [`chip`](crate::chip).

mod motors;
mod probe;
mod senses;
mod state;
mod uart;

use senses::Around;
pub(crate) use state::ChipState;
use state::Span;

use super::measurement::measurement;
use super::{Robot, Tick};
use crate::model::{PortUse, RobotSpec};
use crate::time::SimTime;
use crate::timeline::What;

impl Robot {
    /// Runs its chip from where it is, `until` this instant at most. If its brain may step meanwhile, for less than a character:
    /// what a message makes a brain write must not come to the chip in its past.
    #[cold]
    #[inline(never)]
    pub(super) fn run_chip(&mut self, spec: &RobotSpec, tick: &Tick<'_>, until: SimTime, may_step: bool) {
        let (Some(mut chip), Some(chip_spec)) = (self.parts.chip.take(), &spec.chip) else { return };
        let now = chip.now().max(tick.start);
        let is_silent = chip_spec.is_opaque() && self.ports.is_empty() && spec.port_use != PortUse::Simulated;
        let slice_ns = match (may_step && !is_silent, spec.port_use) {
            (false, _) => u64::MAX,
            (true, PortUse::Closed | PortUse::Open) => spec.link.burst_ns(1) * 9 / 10,
            (true, PortUse::Simulated) => chip.slice_ns(now, spec.link.burst_ns(1)),
        };
        let until = until.min(tick.end).min(SimTime::from_ns(now.as_ns().saturating_add(slice_ns)));
        let Self { microcontroller, motion, actuators, parts, recorder, pings, .. } = self;
        let measurement = measurement(spec, tick, now, (motion, actuators, parts));
        let ping = &mut pings[0];
        let mut around = Around { spec, microcontroller, measurement, recorder, ping };
        let tick_ns = tick.end.since(tick.start);
        let span = Span { tick_ns, substep_ns: tick_ns / u64::from(tick.substeps), until };
        let spoken = chip.run(chip_spec, span, &mut around, (&mut self.uplink, &mut self.downlink));
        if let Some((from, until, bytes)) = spoken {
            self.recorder.note(from, until, What::Up { bytes });
        }
        self.parts.chip = Some(chip);
    }

    /// The actuators follow the chip's pins.
    #[cold]
    #[inline(never)]
    pub(super) fn take_up_from_chip(&mut self, spec: &RobotSpec, now: SimTime, dt_s: f64) {
        let (Some(chip), Some(chip_spec)) = (&mut self.parts.chip, &spec.chip) else { return };
        self.signals = chip.take_up(chip_spec, &spec.drive, now, dt_s).signals;
        chip.move_actuators(chip_spec, &mut self.actuators);
        self.commanded_at = now;
    }
}
