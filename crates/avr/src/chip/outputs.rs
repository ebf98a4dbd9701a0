//! The outputs of pins, and their changes for the board.

use super::Chip;
use crate::adc::Trigger;
use crate::board::{Board, Warning, special};
use crate::pin::{External, Pin, Port, Pwm, PwmReport};
use crate::system::Sleep;
use crate::timer::{self, Which};

const TIMERS: [Which; 3] = [Which::T0, Which::T1, Which::T2];

impl Chip {
    /// Computes the outputs of a port's pins at a cycle, and reports them to the board and the peripherals behind them.
    pub(super) fn update_port<B: Board>(&mut self, port: Port, now: u64, board: &mut B) {
        let changed = self.ports.update(port, now);
        if changed.drives | changed.contention != 0 {
            self.tell_drives(port, changed.drives, changed.contention, now, board);
        }
        if changed.levels & self.interest(port) != 0 {
            self.levels_changed(port, changed.levels, changed.level, now);
        }
    }

    fn tell_drives<B: Board>(&self, port: Port, drives: u8, contention: u8, now: u64, board: &mut B) {
        let at = self.clock.period_of(now);
        for bit in (0..8).filter(|bit| (drives | contention) >> bit & 1 == 1) {
            let pin = Pin::of(port, bit);
            if drives & pin.mask() != 0 && self.pwm(pin).is_none() {
                board.pin_changed(pin, self.ports.drive(pin), at);
            }
            if contention & pin.mask() != 0 {
                board.warn(Warning::Contention { pin }, at);
            }
        }
    }

    /// Pins of a port on which a peripheral listens.
    fn interest(&self, port: Port) -> u8 {
        let own = match port {
            Port::B => special::ICP1.mask(),
            Port::C => 0,
            Port::D => {
                special::RXD.mask()
                    | special::INT[0].mask()
                    | special::INT[1].mask()
                    | special::T0.mask()
                    | special::T1.mask()
            }
        };
        own | self.external.watched(port.index())
    }

    fn levels_changed(&mut self, port: Port, changed: u8, level: u8, now: u64) {
        self.external.pins_changed(port.index(), changed);
        let clock_runs = !self.sleep().is_some_and(Sleep::is_deep);
        let edge =
            |pin: Pin| (pin.port() == port && changed & pin.mask() != 0).then_some(level & pin.mask() != 0);
        for (line, pin) in (0..).zip(special::INT) {
            if let Some(level) = edge(pin) {
                self.external.line_changed(line, level, clock_runs);
            }
        }
        if let Some(level) = edge(special::RXD) {
            // Nothing on the line is a line that rests.
            self.usart.set_pin(now, level || self.ports.external(special::RXD) == External::Open);
        }
        for (which, pin) in [(Which::T0, special::T0), (Which::T1, special::T1)] {
            if let Some(rising) = edge(pin).filter(|_| clock_runs) {
                self.timers[which as usize].clock_edge(now, rising);
            }
        }
        if let Some(rising) = edge(special::ICP1).filter(|_| clock_runs && !self.comparator.captures()) {
            self.timers[Which::T1 as usize].capture_edge(now, rising);
        }
        self.check_trigger(now);
        self.schedule();
        self.attend();
    }

    /// The outputs of all timers, as they are at a cycle.
    pub(super) fn refresh_timers<B: Board>(&mut self, now: u64, board: &mut B) {
        for which in TIMERS {
            let time = self.timer_time(which, now);
            self.timers[which as usize].advance(time);
            self.refresh_timer(which, now, board);
        }
    }

    /// The outputs of a timer that has been brought to a cycle.
    pub(super) fn refresh_timer<B: Board>(&mut self, which: Which, now: u64, board: &mut B) {
        self.tell_shapes(which, now, board);
        let outputs = self.timers[which as usize].outputs();
        let pins = special::outputs(which);
        for (pin, output) in pins.into_iter().zip(outputs) {
            self.ports.override_value(pin, output);
        }
        self.update_port(pins[0].port(), now, board);
        if pins[1].port() != pins[0].port() {
            self.update_port(pins[1].port(), now, board);
        }
        self.watch_timer(which);
    }

    fn tell_shapes<B: Board>(&mut self, which: Which, now: u64, board: &mut B) {
        let timer = which as usize;
        for (channel, pin) in special::outputs(which).into_iter().enumerate() {
            let wanted =
                self.outputs.reports[timer][channel] == PwmReport::Shape && self.ports.is_output(pin);
            let shape = self.timers[timer].shape(channel).filter(|_| wanted);
            let periods = |cycles| self.timer_periods(which, cycles);
            let shape =
                shape.map(|(high, period)| Pwm { high: periods(high), period: periods(period).max(1) });
            if shape != self.outputs.shapes[timer][channel] {
                self.outputs.shapes[timer][channel] = shape;
                let at = self.clock.period_of(now);
                board.pwm_changed(pin, shape, at);
                if shape.is_none() {
                    board.pin_changed(pin, self.ports.drive(pin), at);
                }
            }
        }
    }

    /// The shape of the signal that a timer makes on a pin now, if it is reported as [`PwmReport::Shape`].
    pub fn pwm(&self, pin: Pin) -> Option<Pwm> {
        let shapes = TIMERS
            .into_iter()
            .flat_map(|which| special::outputs(which).into_iter().zip(self.outputs.shapes[which as usize]));
        shapes.filter(|(own, _)| *own == pin).find_map(|(_, shape)| shape)
    }

    pub(super) fn watch_timers(&mut self) {
        for which in TIMERS {
            self.watch_timer(which);
        }
    }

    /// Chooses the outputs and flags for which a timer must not wait.
    fn watch_timer(&mut self, which: Which) {
        let timer = which as usize;
        let outputs = self.timers[timer].outputs();
        let mut watched = 0;
        for (channel, pin) in special::outputs(which).into_iter().enumerate() {
            let listened = self.external.watched(pin.port().index()) & pin.mask() != 0
                || pin == special::INT[1] && self.external.watches_line(1)
                || pin == special::T1;
            let told = self.outputs.reports[timer][channel] == PwmReport::Edges || listened;
            if outputs[channel].is_some() && self.ports.is_output(pin) && told {
                watched |= 1 << channel;
            }
        }
        let triggers = match (self.adc.trigger(), which) {
            (Some(Trigger::Timer0CompareA), Which::T0) => timer::MATCH_A,
            (Some(Trigger::Timer0Overflow), Which::T0) | (Some(Trigger::Timer1Overflow), Which::T1) => {
                timer::OVERFLOW
            }
            (Some(Trigger::Timer1CompareB), Which::T1) => timer::MATCH_B,
            (Some(Trigger::Timer1Capture), Which::T1) => timer::CAPTURE,
            _ => 0,
        };
        self.timers[timer].watch(watched, triggers);
    }
}
