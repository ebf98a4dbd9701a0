//! A reflectance sensor that discharges a capacitor.
//!
//! The program charges the capacitor by a high output for 10 µs, makes the pin an input, and measures how long it stays
//! high: the more light comes back, the sooner the phototransistor has discharged it.
//!
//! Source: Pololu, *QTR Reflectance Sensor Application Note*; a QTR-1RC has 10 nF behind 220 Ω.

use baudbot_avr::{Drive, External};
use serde::{Deserialize, Serialize};

use super::{Change, Signal};
use crate::clock::ChipClock;
use crate::role::Role;

/// Half the time that the program charges the capacitor: by then the sensor holds the wire.
pub(crate) const REACTION_NS: u64 = 5_000;

/// A reflectance sensor such as the QTR-1RC. How long it discharges is the world's:
/// [`discharge_ns`](crate::Physics::discharge_ns).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reflectance;

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct State {
    capacitor: Capacitor,
    /// The sensor's hold on the wire, as the chip knows it.
    holds: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
enum Capacitor {
    #[default]
    Empty,
    /// Since this cycle it is full.
    Full(u64),
    /// Since this cycle it has been discharging.
    Released(u64),
    /// The capacitor is empty from this cycle on.
    Until(u64),
}

impl State {
    pub(crate) fn is_possible(&self, now: u64) -> bool {
        match self.capacitor {
            Capacitor::Full(since) | Capacitor::Released(since) => since <= now,
            Capacitor::Empty | Capacitor::Until(_) => true,
        }
    }

    pub(crate) fn hear(&mut self, signal: Signal, at: u64) {
        self.capacitor = match (signal, self.capacitor) {
            (Signal::Steady(Drive::High), _) => Capacitor::Full(at),
            (Signal::Steady(Drive::Low), Capacitor::Empty) => Capacitor::Empty,
            (Signal::Steady(Drive::Low), _) => Capacitor::Until(at),
            (Signal::Steady(Drive::HighImpedance), Capacitor::Full(_)) => Capacitor::Released(at),
            (Signal::Steady(Drive::HighImpedance | Drive::PullUp) | Signal::Pwm(_), unchanged) => unchanged,
        };
    }

    pub(crate) fn prepare(&mut self, clock: &ChipClock, discharge_ns: impl FnOnce(u64) -> u64) {
        if let Capacitor::Released(at) = self.capacitor {
            let at_ns = clock.ns(at);
            self.capacitor = Capacitor::Until(clock.cycle(at_ns.saturating_add(discharge_ns(at_ns))));
        }
    }

    pub(crate) fn next_change(&self) -> Option<Change> {
        let change = |at, external| Some(Change { at, role: Role::Signal, external });
        match (self.capacitor, self.holds) {
            (Capacitor::Full(at) | Capacitor::Released(at), false) => change(at, External::High),
            (Capacitor::Until(at), true) => change(at, External::Open),
            (Capacitor::Empty, _)
            | (Capacitor::Full(_) | Capacitor::Released(_), true)
            | (Capacitor::Until(_), false) => None,
        }
    }

    pub(crate) fn change_taken(&mut self) {
        if let Capacitor::Until(_) = self.capacitor {
            self.capacitor = Capacitor::Empty;
        }
        self.holds = !self.holds;
    }
}
