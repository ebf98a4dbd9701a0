//! Events of the peripherals, each at its own cycle, in the order of time.

use super::{Chip, Pending};
use crate::adc::{self, Input, Trigger};
use crate::board::{AnalogInput, Board, Unsupported, Warning};
use crate::system::ResetCause;
use crate::timer::{self, Which};
use crate::twi::Step;
use crate::watchdog::Bite;

/// The bandgap reference, in microvolts.
const BANDGAP_UV: u32 = 1_100_000;

impl Chip {
    /// Does all that has become due by the present cycle.
    #[inline(always)]
    pub(super) fn service<B: Board>(&mut self, board: &mut B) {
        if self.cycle >= self.next_event {
            self.service_events(board);
        }
    }

    #[inline(never)]
    fn service_events<B: Board>(&mut self, board: &mut B) {
        self.repeat.restart();
        while self.next_event <= self.cycle {
            let now = self.next_event;
            self.events_at(now, board);
            self.check_trigger(now);
            self.schedule();
        }
        self.attend();
    }

    fn events_at<B: Board>(&mut self, now: u64, board: &mut B) {
        let period = self.clock.period_of(now);
        while let Some((pin, external)) = self.inputs.take_due(period) {
            self.ports.set_external(pin, external);
            self.update_port(pin.port(), now, board);
        }
        for which in [Which::T0, Which::T1, Which::T2] {
            let time = self.timer_time(which, now);
            if self.timers[which as usize].next_event() <= time {
                self.timers[which as usize].advance(time);
                self.refresh_timer(which, now, board);
            }
        }
        if self.usart.next_event(&self.clock) <= now {
            self.usart_event(now, board);
        }
        self.adc_event(now, period, board);
        if let Some(byte) = self.spi.event(now) {
            let answer = board.spi_transfer(byte, period);
            self.spi.receive(answer);
        }
        if let Some(step) = self.twi.event(now) {
            self.twi_step(step, period, board);
        }
        self.eeprom.event(period);
        self.programming.event(period);
        if self.watchdog.event(period) == Bite::Reset {
            self.pending = Pending::Reset(ResetCause::Watchdog);
        }
    }

    fn usart_event<B: Board>(&mut self, now: u64, board: &mut B) {
        let overrun = self.usart.has_overrun();
        if let Some(sent) = self.usart.event(now, &self.clock) {
            board.character_sent(&sent);
        }
        if !overrun && self.usart.has_overrun() {
            board.warn(Warning::Overrun, self.clock.period_of(now));
        }
    }

    fn adc_event<B: Board>(&mut self, now: u64, period: u64, board: &mut B) {
        if self.adc.event(now) != adc::Event::Sample {
            return;
        }
        let microvolts = match self.adc.input() {
            Input::Outside(input) => board.analog_microvolts(input, period),
            Input::Inside(microvolts) => microvolts,
            Input::Reserved => {
                board.warn(Warning::Unsupported(Unsupported::ReservedAdcInput), period);
                0
            }
        };
        let result = self.adc.sample(microvolts, &self.supply);
        if let (Input::Outside(AnalogInput::Channel(channel)), Some(result)) = (self.adc.input(), result) {
            board.converted(channel, result, period);
        }
    }

    fn twi_step<B: Board>(&mut self, step: Step, period: u64, board: &mut B) {
        let (acknowledged, byte) = match step {
            Step::Start => (true, 0),
            Step::Address => {
                let (address, direction) = self.twi.addressed();
                (board.twi_address(address, direction, period), 0)
            }
            Step::Write => (board.twi_write(self.twi.data(), period), 0),
            Step::Read { acknowledge } => (true, board.twi_read(!acknowledge, period)),
        };
        self.twi.done(step, acknowledged, byte);
    }

    /// Compares the voltages at the comparator's inputs.
    pub(super) fn compare<B: Board>(&mut self, board: &mut B) {
        if !self.comparator.is_on() {
            return;
        }
        let period = self.now();
        let positive = if self.comparator.takes_bandgap() {
            BANDGAP_UV
        } else {
            board.analog_microvolts(AnalogInput::Positive, period)
        };
        let input = self.adc.lent_channel().map_or(AnalogInput::Negative, AnalogInput::Channel);
        let negative = board.analog_microvolts(input, period);
        let edge = self.comparator.set_output(positive > negative);
        if let Some(rising) = edge.filter(|_| self.comparator.captures()) {
            self.timers[Which::T1 as usize].capture_edge(self.cycle, rising);
        }
    }

    /// Starts a conversion if the flag that triggers it has risen.
    pub(super) fn check_trigger(&mut self, now: u64) {
        let flag = |which: Which, flag: u8| self.timers[which as usize].flags() & flag != 0;
        let level = match self.adc.trigger() {
            None | Some(Trigger::FreeRunning) => false,
            Some(Trigger::Comparator) => self.comparator.flag(),
            Some(Trigger::ExternalInterrupt0) => self.external.flags() & 1 != 0,
            Some(Trigger::Timer0CompareA) => flag(Which::T0, timer::MATCH_A),
            Some(Trigger::Timer0Overflow) => flag(Which::T0, timer::OVERFLOW),
            Some(Trigger::Timer1CompareB) => flag(Which::T1, timer::MATCH_B),
            Some(Trigger::Timer1Overflow) => flag(Which::T1, timer::OVERFLOW),
            Some(Trigger::Timer1Capture) => flag(Which::T1, timer::CAPTURE),
        };
        self.adc.see_trigger(now, level);
    }

    /// Works out when the next event is.
    pub(super) fn schedule(&mut self) {
        let period = self.next_period();
        let mut next = if period == u64::MAX { period } else { self.clock.cycle_from(period) };
        for which in [Which::T0, Which::T1, Which::T2] {
            next = next.min(self.timer_event(which));
        }
        next = next.min(self.usart.next_event(&self.clock)).min(self.adc.next_event());
        self.next_event = next.min(self.spi.next_event()).min(self.twi.next_event());
    }

    /// The next event that does not need the system clock, in periods of the clock source.
    pub(super) fn next_period(&self) -> u64 {
        self.inputs
            .next_due()
            .min(self.watchdog.next_event())
            .min(self.eeprom.next_event())
            .min(self.programming.next_event())
            .min(self.crystal_event())
    }

    /// Checks interrupts and events after this instruction.
    #[inline(always)]
    pub(super) fn attend(&mut self) {
        self.limit = 0;
    }
}
