//! Ultrasonic range finders that answer a trigger pulse by a pulse as long as the echo.
//!
//! Source: Parallax, *PING))) Ultrasonic Distance Sensor (#28015)*, section *Communication Protocol*; Elecfreaks, *Ultrasonic
//! Ranging Module HC-SR04*, section *Timing diagram*. That the echo of an HC-SR04 begins about 460 µs after the trigger is
//! known from measurements, not from its data sheet.
//!
//! The shortest trigger pulse is the one that a data sheet promises to be enough. Sensors take shorter ones, and
//! programs rely on it: `delayMicroseconds(10)` between two writes to a port makes a pulse of 9.5 µs,
//! `delayMicroseconds(2)` one of 1.5 µs. So a pulse that is shorter than promised gives a warning, and is obeyed down
//! to a fifth of it, or a half. The true limit of sensors is not known.

use baudbot_avr::External;
use serde::{Deserialize, Serialize};

use super::{Change, Instant, Remark, Signal};
use crate::role::Role;

/// Parallax PING))): trigger and echo on one pin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ping;

/// HC-SR04: trigger and echo on two pins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HcSr04;

/// The numbers of a data sheet, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Timing {
    /// The shortest trigger pulse that the data sheet promises to be enough.
    trigger: u64,
    /// The time from the end of the trigger to the beginning of the echo pulse.
    hold_off: u64,
    shortest: u64,
    longest: u64,
    /// The length of the pulse if there is no echo.
    nothing: u64,
    /// Trigger and echo are on one pin, so that the sensor releases it.
    one_pin: bool,
}

pub(crate) const PING: Timing = Timing {
    trigger: 2_000,
    hold_off: 750_000,
    shortest: 115_000,
    longest: 18_500_000,
    nothing: 18_500_000,
    one_pin: true,
};
pub(crate) const HC_SR04: Timing = Timing {
    trigger: 10_000,
    hold_off: 460_000,
    shortest: 150_000,
    longest: 25_000_000,
    nothing: 38_000_000,
    one_pin: false,
};
/// A run ends at an instruction's end, which may be later than asked for by less than this.
const MARGIN_NS: u64 = 10_000;

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct State {
    timing: Timing,
    /// The cycle with which the trigger pulse began.
    raised: Option<u64>,
    phase: Phase,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Phase {
    /// The level of the echo pin is not reported yet.
    New,
    Idle,
    /// The echo pulse will begin at this cycle.
    HoldOff(u64),
    /// The echo pulse will begin and end at these cycles.
    Rising(u64, u64),
    Falling(u64),
}

impl Timing {
    /// The shortest trigger pulse that the sensor obeys.
    const fn least_trigger(self) -> u64 {
        if self.one_pin { 1_000 } else { 2_000 }
    }
}

impl State {
    pub(crate) const fn new(timing: Timing) -> Self {
        Self { timing, raised: None, phase: if timing.one_pin { Phase::Idle } else { Phase::New } }
    }

    pub(crate) fn is_possible(&self, timing: Timing, now: u64) -> bool {
        let in_order = match self.phase {
            Phase::Rising(start, end) => start <= end,
            Phase::New | Phase::Idle | Phase::HoldOff(_) | Phase::Falling(_) => true,
        };
        self.timing == timing && self.raised.is_none_or(|raised| raised <= now) && in_order
    }

    pub(crate) const fn reaction_ns(&self) -> u64 {
        self.timing.hold_off - MARGIN_NS
    }

    pub(crate) fn hear(&mut self, role: Role, signal: Signal, at: Instant<'_>) -> Option<Remark> {
        if role == Role::Echo {
            return None;
        }
        if signal.is_high() {
            self.raised = self.raised.or(Some(at.cycle));
            return None;
        }
        let begun = self.raised.take()?;
        if self.phase != Phase::Idle && self.phase != Phase::New {
            return None;
        }
        let width = at.clock.ns(at.cycle - begun);
        if width < self.timing.least_trigger() {
            return Some(Remark::ShortTrigger);
        }
        self.phase = Phase::HoldOff(at.after(self.timing.hold_off));
        (width < self.timing.trigger).then_some(Remark::WeakTrigger)
    }

    /// Asks for the echo of a pulse that begins by this cycle.
    pub(crate) fn prepare(&mut self, until: Instant<'_>, echo_ns: impl FnOnce(u64) -> Option<u64>) {
        let Phase::HoldOff(start) = self.phase else { return };
        if start > until.cycle {
            return;
        }
        let start = Instant { cycle: start, ..until };
        let length = match echo_ns(start.ns()) {
            Some(length) => length.clamp(self.timing.shortest, self.timing.longest),
            None => self.timing.nothing,
        };
        self.phase = Phase::Rising(start.cycle, start.after(length));
    }

    pub(crate) fn next_change(&self) -> Option<Change> {
        let role = if self.timing.one_pin { Role::Signal } else { Role::Echo };
        let rest = if self.timing.one_pin { External::Open } else { External::Low };
        match self.phase {
            Phase::New => Some(Change { at: 0, role, external: rest }),
            Phase::Idle | Phase::HoldOff(_) => None,
            Phase::Rising(at, _) => Some(Change { at, role, external: External::High }),
            Phase::Falling(at) => Some(Change { at, role, external: rest }),
        }
    }

    pub(crate) fn change_taken(&mut self) {
        self.phase = match self.phase {
            Phase::Rising(_, end) => Phase::Falling(end),
            Phase::New | Phase::Falling(_) => Phase::Idle,
            Phase::Idle | Phase::HoldOff(_) => self.phase,
        };
    }

    /// The instant at which the world will be asked.
    pub(crate) const fn due(&self) -> Option<u64> {
        match self.phase {
            Phase::HoldOff(at) => Some(at),
            Phase::New | Phase::Idle | Phase::Rising(..) | Phase::Falling(_) => None,
        }
    }
}
