//! Reset, sleep and power reduction.

use super::{Chip, Pending, State};
use crate::adc::Adc;
use crate::alu::I;
use crate::board::{Board, special};
use crate::clock::periods;
use crate::comparator::Comparator;
use crate::external::External;
use crate::pin::Port;
use crate::spi::Spi;
use crate::system::{ResetCause, Sleep, System, power};
use crate::timer::{Timer, Which};
use crate::twi::Twi;
use crate::watchdog::Watchdog;

/// CLKPS after a reset with CKDIV8.
const DIVIDE_BY_8: u8 = 3;
/// Cycles of the clock source that each reset takes.
const RESET_CYCLES: u64 = 14;

impl Chip {
    /// Resets the chip now, as the pin RESET or a low supply does.
    pub fn reset_now<B: Board>(&mut self, cause: ResetCause, board: &mut B) {
        self.reset(cause as u8, board);
    }

    pub(super) fn reset<B: Board>(&mut self, cause: u8, board: &mut B) {
        if cause == ResetCause::Watchdog as u8 {
            self.watchdog_resets = self.watchdog_resets.wrapping_add(1);
        }
        self.begin(self.system.status() | cause);
        let now = self.cycle;
        for port in Port::ALL {
            self.update_port(port, now, board);
        }
        self.refresh_timers(now, board);
        self.schedule();
    }

    /// The state after a reset; `status` is MCUSR.
    pub(super) fn begin(&mut self, status: u8) {
        self.watch_reset();
        let now = self.cycle;
        let prescaler = if self.fuses.divides_clock() { DIVIDE_BY_8 } else { 0 };
        self.clock.set_shift(now, prescaler);
        self.sreg = 0;
        self.sp = self.part.ram_end();
        let in_boot = self.fuses.starts_in_boot_section(self.part);
        self.pc = if in_boot { self.fuses.boot_start(self.part) } else { 0 };
        (self.inhibited, self.pending) = (false, Pending::Nothing);
        self.ports.reset();
        self.timers = [Which::T0, Which::T1, Which::T2].map(|which| Timer::new(which, now));
        self.usart.reset(now);
        self.adc = Adc::new(now);
        self.comparator = Comparator::default();
        self.external = External::new(self.external.levels());
        self.spi = Spi::new();
        self.twi = Twi::new();
        self.eeprom.reset();
        self.programming.reset();
        self.system = System::new(prescaler, status);
        let start_up = self.fuses.start_up();
        let delay = periods(self.supply.clock_hz, u64::from(start_up.reset_100us) * 100);
        let held_until = self.now() + u64::from(start_up.cycles) + RESET_CYCLES + delay;
        self.state = State::Held(held_until);
        let (always_on, bitten) = (self.fuses.watchdog_always_on(), self.system.has_watchdog_bitten());
        self.watchdog = Watchdog::new(self.supply.clock_hz, always_on, bitten, held_until);
        self.schedule();
    }

    /// `SLEEP`.
    pub(super) fn go_to_sleep<B: Board>(&mut self, board: &mut B) -> u64 {
        let Some(sleep) = self.system.sleep_mode() else { return 1 };
        self.cycle += 1;
        self.service(board);
        self.state = State::Asleep(sleep);
        self.apply_power();
        if sleep == Sleep::AdcNoiseReduction {
            self.adc.sleep(self.cycle);
        }
        self.schedule();
        self.attend();
        0
    }

    /// The clocks run again; an oscillator that stood needs its time to start.
    pub(super) fn leave_sleep<B: Board>(&mut self, sleep: Sleep, board: &mut B) {
        self.apply_power();
        if sleep.stops_oscillator() {
            let ready = self.now() + u64::from(self.fuses.start_up().cycles);
            self.skip_to(ready);
        }
        self.schedule();
        self.service(board);
    }

    /// Whether the processor sleeps, and how.
    pub const fn sleep(&self) -> Option<Sleep> {
        match self.state {
            State::Asleep(sleep) => Some(sleep),
            State::Awake | State::Held(_) => None,
        }
    }

    /// The instant up to which nothing happens unless something comes from outside, if the processor sleeps or is held in
    /// reset; None: it is awake. `u64::MAX`: it sleeps for ever.
    pub fn next_event(&self) -> Option<u64> {
        let sleep = match self.state {
            State::Awake => return None,
            State::Held(until) => return Some(until),
            State::Asleep(sleep) => sleep,
        };
        if self.sreg & I != 0 && self.can_wake(sleep) {
            return None;
        }
        if sleep.is_deep() {
            return Some(self.next_period());
        }
        Some(if self.next_event == u64::MAX { u64::MAX } else { self.clock.period_of(self.next_event) })
    }

    /// Switches clocks off and on by PRR and the sleep mode.
    pub(super) fn apply_power(&mut self) {
        let asleep = self.state == State::Asleep(Sleep::AdcNoiseReduction);
        let off = self.system.power();
        for (which, bit) in
            [(Which::T0, power::TIMER0), (Which::T1, power::TIMER1), (Which::T2, power::TIMER2)]
        {
            let now = self.timer_time(which, self.cycle);
            let crystal = which == Which::T2 && self.has_crystal();
            let off = if crystal { self.stops_crystal() } else { asleep || off & bit != 0 };
            self.timers[which as usize].set_off(now, off);
        }
        self.adc.set_off(off & power::ADC != 0);
    }

    pub(super) fn restart_watchdog(&mut self) {
        self.watchdog.restart(self.now());
        self.schedule();
        self.attend();
    }

    /// Pins that the USART takes over.
    pub(super) fn override_usart_pins(&mut self) {
        let sends = self.usart.transmitter_on();
        self.ports.override_value(special::TXD, sends.then_some(true));
        self.ports.override_direction(special::TXD, sends.then_some(true));
        self.ports.override_direction(special::RXD, self.usart.receiver_on().then_some(false));
    }

    /// Pins that the SPI takes over: what the other side drives is an input.
    pub(super) fn override_spi_pins(&mut self) {
        let (on, master) = (self.spi.is_enabled(), self.spi.is_master());
        self.ports.override_direction(special::MISO, (on && master).then_some(false));
        for pin in [special::MOSI, special::SCK, special::SS] {
            self.ports.override_direction(pin, (on && !master).then_some(false));
        }
    }

    /// Pins that the TWI takes over: nothing drives them high.
    pub(super) fn override_twi_pins(&mut self) {
        let taken = self.twi.is_enabled().then_some(false);
        self.ports.override_direction(special::SDA, taken);
        self.ports.override_direction(special::SCL, taken);
    }
}
