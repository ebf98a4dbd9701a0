//! The signal of a timer, drawn from its shape.

use baudbot_avr::{Pin, Pwm};

/// A signal on its way from edge to edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wave {
    pin: Pin,
    pwm: Pwm,
    /// The shape that holds from the next period on.
    queued: Option<Pwm>,
    /// The cycle in which this period began.
    begin: u64,
    /// The cycle of the next edge.
    next: u64,
    /// The next edge is the one within the period.
    falls: bool,
}

impl Wave {
    /// A wave whose first period begins at a cycle.
    pub(super) const fn new(pin: Pin, pwm: Pwm, begin: u64) -> Self {
        Self { pin, pwm, queued: None, begin, next: begin, falls: false }
    }

    pub(super) const fn pin(&self) -> Pin {
        self.pin
    }

    /// The cycle of its next edge, or of a period's begin without one.
    pub(super) const fn next(&self) -> u64 {
        self.next
    }

    /// Gives the wave another shape from a cycle on.
    pub(super) fn change(&mut self, pwm: Pwm, at: u64) {
        if pwm.period == self.pwm.period {
            self.queued = Some(pwm);
        } else {
            *self = Self::new(self.pin, pwm, at);
        }
    }

    /// Goes past the next edge. Returns whether the signal is high from there on.
    pub(super) fn step(&mut self) -> bool {
        if self.falls {
            self.falls = false;
            self.next = self.begin.saturating_add(self.pwm.period);
            return false;
        }
        self.pwm = self.queued.take().unwrap_or(self.pwm);
        self.begin = self.next;
        let Pwm { high, period } = self.pwm;
        self.falls = 0 < high && high < period;
        self.next = self.begin.saturating_add(if self.falls { high } else { period.max(1) });
        high > 0
    }
}

#[cfg(test)]
mod tests {
    use baudbot_avr::Port;

    use super::*;

    fn edges(wave: &mut Wave, count: usize) -> std::vec::Vec<(u64, bool)> {
        (0..count).map(|_| (wave.next(), wave.step())).collect()
    }

    #[test]
    fn a_new_duty_holds_from_the_next_period_on_and_a_new_period_at_once() {
        let pin = Pin::new(Port::B, 1).unwrap();
        let mut wave = Wave::new(pin, Pwm { high: 64, period: 256 }, 1000);
        assert_eq!(edges(&mut wave, 3), [(1000, true), (1064, false), (1256, true)]);
        wave.change(Pwm { high: 10, period: 256 }, 1300);
        wave.change(Pwm { high: 128, period: 256 }, 1310);
        assert_eq!(edges(&mut wave, 3), [(1320, false), (1512, true), (1640, false)]);
        wave.change(Pwm { high: 5, period: 50 }, 1650);
        assert_eq!(edges(&mut wave, 3), [(1650, true), (1655, false), (1700, true)]);
    }

    #[test]
    fn a_signal_of_duty_0_or_1_is_steady() {
        let pin = Pin::new(Port::B, 1).unwrap();
        let mut wave = Wave::new(pin, Pwm { high: 256, period: 256 }, 0);
        assert_eq!(edges(&mut wave, 2), [(0, true), (256, true)]);
        wave.change(Pwm { high: 0, period: 256 }, 300);
        assert_eq!(edges(&mut wave, 2), [(512, false), (768, false)]);
    }
}
