//! The pins as digital inputs and outputs.
//!
//! Source: data sheet, chapter *I/O-Ports*; functions of other parts take a pin over as in *Alternate Port Functions*,
//! by a value (PVOE, PVOV) and a direction (DDOE, DDOV).

use serde::{Deserialize, Serialize};

use crate::pin::{Drive, External, Pin, Port};

/// A register of a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Register {
    Pin,
    Direction,
    Port,
}

/// All ports.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Ports {
    states: [State; 3],
    /// PUD in MCUCR.
    pull_ups_off: bool,
}

/// Eight pins; a bit of each field for one pin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct State {
    port: u8,
    direction: u8,
    value_override: u8,
    value: u8,
    direction_override: u8,
    output: u8,
    /// Pins that another part drives, and how.
    external: u8,
    external_level: u8,
    level: u8,
    /// The level before the cycle `changed_at`.
    previous: u8,
    changed_at: u64,
    drives: Drives,
    floating_told: u8,
}

/// The effects of a port's pins on their wires.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Drives {
    output: u8,
    /// High, or pulled up.
    high: u8,
}

/// The pins that an update of a port has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Changed {
    /// Pins that do something else to their wires.
    pub(crate) drives: u8,
    /// Pins whose level has changed.
    pub(crate) levels: u8,
    /// The levels of all pins.
    pub(crate) level: u8,
    /// Pins that are driven against another part only now.
    pub(crate) contention: u8,
}

impl Ports {
    /// Registers return to their values after a reset. What is outside stays.
    pub(crate) fn reset(&mut self) {
        for state in &mut self.states {
            *state = State {
                external: state.external,
                external_level: state.external_level,
                level: state.level,
                previous: state.previous,
                changed_at: state.changed_at,
                drives: state.drives,
                ..State::default()
            };
        }
        self.pull_ups_off = false;
    }

    /// Reads a register. Pins pass a synchroniser: what changes with a cycle is seen one later.
    #[inline]
    pub(crate) fn read(&self, port: Port, register: Register, now: u64) -> u8 {
        let state = &self.states[port.index()];
        match register {
            Register::Pin if now <= state.changed_at => state.previous,
            Register::Pin => state.level,
            Register::Direction => state.direction,
            Register::Port => state.port,
        }
    }

    /// Whether PINx, read at this cycle, is what it was before the pins changed.
    #[inline]
    pub(crate) fn is_synchronising(&self, port: Port, now: u64) -> bool {
        now <= self.states[port.index()].changed_at
    }

    /// Writes a register; a one in PINx toggles.
    pub(crate) fn write(&mut self, port: Port, register: Register, value: u8) {
        let state = &mut self.states[port.index()];
        match register {
            Register::Pin => state.port ^= value,
            Register::Direction => state.direction = value,
            Register::Port => state.port = value,
        }
    }

    pub(crate) fn set_pull_ups_off(&mut self, off: bool) {
        self.pull_ups_off = off;
    }

    /// Another part does this to a pin from now on.
    pub(crate) fn set_external(&mut self, pin: Pin, external: External) {
        let state = &mut self.states[pin.port().index()];
        assign(&mut state.external, pin, external != External::Open);
        assign(&mut state.external_level, pin, external == External::High);
    }

    /// A part of the chip gives the pin its value if it is an output, or releases it.
    pub(crate) fn override_value(&mut self, pin: Pin, value: Option<bool>) {
        let state = &mut self.states[pin.port().index()];
        assign(&mut state.value_override, pin, value.is_some());
        assign(&mut state.value, pin, value == Some(true));
    }

    /// A part of the chip decides whether the pin is an output, or releases it.
    pub(crate) fn override_direction(&mut self, pin: Pin, output: Option<bool>) {
        let state = &mut self.states[pin.port().index()];
        assign(&mut state.direction_override, pin, output.is_some());
        assign(&mut state.output, pin, output == Some(true));
    }

    /// Whether the program has made the pin an output.
    pub(crate) fn is_output(&self, pin: Pin) -> bool {
        self.states[pin.port().index()].direction & pin.mask() != 0
    }

    /// The level of a pin, and of all pins of a port.
    pub(crate) fn level(&self, pin: Pin) -> bool {
        self.states[pin.port().index()].level & pin.mask() != 0
    }

    /// Another part's effect on the wire.
    pub(crate) fn external(&self, pin: Pin) -> External {
        let state = &self.states[pin.port().index()];
        match (state.external & pin.mask() != 0, state.external_level & pin.mask() != 0) {
            (false, _) => External::Open,
            (true, false) => External::Low,
            (true, true) => External::High,
        }
    }

    /// The pin's own effect on the wire.
    pub(crate) fn drive(&self, pin: Pin) -> Drive {
        let drives = self.states[pin.port().index()].drives;
        match (drives.output & pin.mask() != 0, drives.high & pin.mask() != 0) {
            (true, false) => Drive::Low,
            (true, true) => Drive::High,
            (false, true) => Drive::PullUp,
            (false, false) => Drive::HighImpedance,
        }
    }

    /// Works out what the pins of a port do, and their levels.
    pub(crate) fn update(&mut self, port: Port, now: u64) -> Changed {
        let pull_ups = if self.pull_ups_off { 0 } else { 0xFF };
        let state = &mut self.states[port.index()];
        let output = select(state.direction_override, state.output, state.direction);
        let value = select(state.value_override, state.value, state.port);
        let pulled = state.port & !output & pull_ups;
        let drives = Drives { output, high: (value & output) | pulled };
        let level = select(output, value, select(state.external, state.external_level, pulled));
        let old = core::mem::replace(&mut state.drives, drives);
        let against = |drives: Drives| drives.output & state.external & (drives.high ^ state.external_level);
        let changed = Changed {
            drives: (old.output ^ drives.output) | (old.high ^ drives.high),
            levels: state.level ^ level,
            level,
            contention: against(drives) & !against(old),
        };
        if changed.levels != 0 {
            if state.changed_at != now {
                state.previous = state.level;
            }
            state.level = level;
            state.changed_at = now;
        }
        changed
    }

    /// Pins of a port that float although they are read by `mask`; each is reported once.
    #[inline]
    pub(crate) fn floating(&mut self, port: Port, mask: u8) -> u8 {
        let state = &mut self.states[port.index()];
        let floating =
            mask & !(state.external | state.drives.output | state.drives.high | state.floating_told);
        state.floating_told |= floating;
        floating
    }
}

/// The bits of `yes` where `mask` is 1, else of `no`.
const fn select(mask: u8, yes: u8, no: u8) -> u8 {
    (yes & mask) | (no & !mask)
}

fn assign(bits: &mut u8, pin: Pin, value: bool) {
    *bits = select(pin.mask(), if value { 0xFF } else { 0 }, *bits);
}
