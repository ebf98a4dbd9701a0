//! Light-emitting diodes.

use baudbot_avr::Drive;
use serde::{Deserialize, Serialize};

use super::Signal;
use super::meter::Meter;

/// The level that lights a diode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum LitBy {
    /// It is between the pin and ground.
    High,
    /// It is between the supply and the pin.
    Low,
}

/// A light-emitting diode with its resistor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Led {
    /// The level that lights it.
    pub lit_by: LitBy,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct State {
    led: Led,
    brightness: Meter,
}

impl State {
    pub(crate) fn new(led: Led) -> Self {
        Self { led, brightness: Meter::default() }
    }

    pub(crate) fn is_possible(&self, led: Led, now: u64) -> bool {
        self.led == led && self.brightness.is_possible(now)
    }

    pub(crate) fn hear(&mut self, signal: Signal, at: u64) {
        let lit = match (signal, self.led.lit_by) {
            // A pull-up resistor gives too little current to see.
            (Signal::Steady(Drive::PullUp | Drive::HighImpedance), _) => 0.0,
            (Signal::Steady(Drive::High), LitBy::High) | (Signal::Steady(Drive::Low), LitBy::Low) => 1.0,
            (Signal::Steady(Drive::Low), LitBy::High) | (Signal::Steady(Drive::High), LitBy::Low) => 0.0,
            (Signal::Pwm(_), LitBy::High) => signal.duty(),
            (Signal::Pwm(_), LitBy::Low) => 1.0 - signal.duty(),
        };
        self.brightness.set(lit, at);
    }

    pub(crate) fn finish(&mut self, now: u64) {
        self.brightness.finish(now);
    }

    /// The fraction of time in which it was lit in the last step.
    pub(crate) const fn brightness(&self) -> f64 {
        self.brightness.mean()
    }
}
