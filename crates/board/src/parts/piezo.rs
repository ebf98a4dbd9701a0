//! A piezo buzzer without an oscillator of its own: it makes the tone of its signal.

use baudbot_avr::Pwm;
use serde::{Deserialize, Serialize};

use super::{Instant, Signal};

/// A piezo buzzer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Piezo;

/// The time without an edge after which the piezo is silent; slower signals are clicks and no tone.
const SILENCE_NS: u64 = 50_000_000;

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct State {
    high: bool,
    /// The cycle of the last edge, of the last rise, and from the rise before to this.
    edge: u64,
    rise: Option<u64>,
    period: Option<u64>,
    shape: Option<Pwm>,
}

impl State {
    pub(crate) fn is_possible(&self, now: u64) -> bool {
        self.edge <= now && self.rise.is_none_or(|rise| rise <= now)
    }

    pub(crate) fn hear(&mut self, signal: Signal, at: Instant<'_>) {
        let Signal::Steady(_) = signal else {
            if let Signal::Pwm(pwm) = signal {
                *self = Self { shape: Some(pwm), ..Self::default() };
            }
            return;
        };
        if self.shape.take().is_some() {
            *self = Self::default();
        }
        if signal.is_high() == self.high {
            return;
        }
        self.high = !self.high;
        self.edge = at.cycle;
        if self.high {
            let period = self.rise.map(|rise| at.cycle - rise);
            self.period = period.filter(|&period| at.clock.ns(period) <= SILENCE_NS);
            self.rise = Some(at.cycle);
        }
    }

    /// The frequency of its tone now, in hertz; None: it is silent.
    pub(crate) fn hz(&self, now: Instant<'_>) -> Option<f64> {
        let sounding = |period: u64| (period > 0 && now.clock.ns(period) <= SILENCE_NS).then_some(period);
        let period = match self.shape {
            Some(Pwm { high, period }) if 0 < high && high < period => sounding(period),
            Some(_) => None,
            None => self.period.filter(|_| now.clock.ns(now.cycle.saturating_sub(self.edge)) <= SILENCE_NS),
        };
        period.map(|period| now.clock.frequency() / period as f64)
    }
}
