//! The registers of the peripherals, as the program reads and writes them.

use super::Chip;
use crate::adc;
use crate::address::{Core, Place};
use crate::board::{Board, Unsupported, Warning};
use crate::pin::Port;
use crate::ports;
use crate::system::{self, Effect, power};
use crate::timer::{self, Which};
use crate::twi::Wanted;
use crate::usart;

impl Chip {
    /// Reads a register at the present cycle.
    #[inline]
    pub(super) fn read_io<B: Board>(&mut self, address: u8, board: &mut B) -> u8 {
        match Place::at(address) {
            Place::Core(Core::Flags) => return self.sreg,
            Place::Core(Core::StackLow) => return self.sp.to_le_bytes()[0],
            Place::Core(Core::StackHigh) => return self.sp.to_le_bytes()[1],
            Place::Reserved => return 0,
            Place::Port(..)
            | Place::Timer(..)
            | Place::Usart(_)
            | Place::Adc(_)
            | Place::Eeprom(_)
            | Place::External(_)
            | Place::Spi(_)
            | Place::Twi(_)
            | Place::System(_)
            | Place::Comparator
            | Place::Watchdog
            | Place::SelfProgramming => {}
        }
        self.service(board);
        self.note_read(Place::at(address));
        self.read_peripheral(Place::at(address), board)
    }

    /// Whether a bit of a register is set, for `SBIS` and `SBIC`. A pin that floats is reported.
    #[inline]
    pub(super) fn read_bit<B: Board>(&mut self, address: u8, mask: u8, board: &mut B) -> bool {
        let value = self.read_io(address, board);
        if let Place::Port(port, ports::Register::Pin) = Place::at(address) {
            self.note_look(port, mask, board);
        }
        value & mask != 0
    }

    /// Writes a register at the present cycle.
    #[inline]
    pub(super) fn write_io<B: Board>(&mut self, address: u8, value: u8, board: &mut B) {
        let place = Place::at(address);
        if let Place::Core(register) = place {
            return self.write_core(register, value);
        }
        self.service(board);
        self.note_write(place, value);
        if let Place::Port(port, register) = place {
            self.write_port(port, register, value, board);
        } else if self.system.power() & clock_of(place) == 0 {
            self.write_peripheral(place, value, board);
            self.check_trigger(self.cycle);
            self.schedule();
            self.attend();
        }
    }

    #[inline]
    fn write_core(&mut self, register: Core, value: u8) {
        let [low, high] = self.sp.to_le_bytes();
        match register {
            Core::Flags => self.set_sreg(value),
            Core::StackLow => self.sp = u16::from_le_bytes([value, high]),
            Core::StackHigh => self.sp = u16::from_le_bytes([low, value]),
        }
    }

    fn read_peripheral<B: Board>(&mut self, place: Place, board: &mut B) -> u8 {
        let now = self.cycle;
        match place {
            Place::Port(port, register) => self.read_port(port, register, board),
            Place::Timer(which, register) => {
                let time = self.timer_time(which, now);
                let timer = &mut self.timers[which as usize];
                if !register.is_control() {
                    timer.advance(time);
                }
                timer.read(register)
            }
            Place::Usart(register) => {
                let value = self.usart.read(register);
                if register == usart::Register::Data {
                    self.attend();
                }
                value
            }
            Place::Adc(register) => self.adc.read(register),
            Place::Eeprom(register) => self.eeprom.read(register, now),
            Place::External(register) => self.external.read(register),
            Place::Spi(register) => {
                let value = self.spi.read(register);
                if register == crate::spi::Register::Data {
                    self.attend();
                }
                value
            }
            Place::Twi(register) => self.twi.read(register),
            Place::System(register) => self.system.read(register),
            Place::Comparator => {
                self.compare(board);
                self.comparator.read()
            }
            Place::Watchdog => self.watchdog.read(now),
            Place::SelfProgramming => self.programming.read(now),
            Place::Reserved | Place::Core(_) => 0,
        }
    }

    fn write_peripheral<B: Board>(&mut self, place: Place, value: u8, board: &mut B) {
        let now = self.cycle;
        match place {
            Place::Timer(which, register) => self.write_timer(which, register, value, board),
            Place::Usart(register) => self.write_usart(register, value, board),
            Place::Adc(register) => self.write_adc(register, value, board),
            Place::Eeprom(register) => {
                let (period, clock_hz) = (self.now(), self.supply.clock_hz);
                self.cycle += self.eeprom.write(register, value, now, period, clock_hz);
            }
            Place::External(register) => {
                // A timer lags behind unless an edge of it is watched: before a register changes, it is brought to the
                // present.
                self.refresh_timers(now, board);
                self.external.write(register, value);
                self.watch_timers();
            }
            Place::Spi(register) => self.write_spi(register, value, board),
            Place::Twi(register) => self.write_twi(register, value, board),
            Place::System(register) => self.write_system(register, value, board),
            Place::Comparator => {
                self.comparator.write(value);
                self.compare(board);
            }
            Place::Watchdog => {
                let bitten = self.system.has_watchdog_bitten();
                self.watchdog.write(value, now, self.now(), bitten);
            }
            Place::SelfProgramming => self.programming.write(value, now),
            Place::Reserved | Place::Core(_) | Place::Port(..) => {}
        }
    }

    fn read_port<B: Board>(&mut self, port: Port, register: ports::Register, board: &mut B) -> u8 {
        let now = self.cycle;
        if register != ports::Register::Pin {
            return self.ports.read(port, register, now);
        }
        if self.outputs.shapes.iter().flatten().any(Option::is_some) {
            self.refresh_timers(now, board);
            self.repeat.forget();
        }
        if self.ports.is_synchronising(port, now) {
            // The next read may give something else, without an event.
            self.repeat.forget();
        }
        self.ports.read(port, register, now) & !self.digital_off(port)
    }

    /// Pins of a port whose digital inputs are off.
    fn digital_off(&self, port: Port) -> u8 {
        match port {
            Port::B => 0,
            Port::C => self.system.read(system::Register::DigitalOff(0)) & 0x3F,
            Port::D => self.system.read(system::Register::DigitalOff(1)) << 6,
        }
    }

    fn write_port<B: Board>(&mut self, port: Port, register: ports::Register, value: u8, board: &mut B) {
        self.ports.write(port, register, value);
        self.update_port(port, self.cycle, board);
        if register == ports::Register::Direction {
            self.refresh_timers(self.cycle, board);
            self.schedule();
            self.attend();
        }
    }

    fn write_timer<B: Board>(&mut self, which: Which, register: timer::Register, value: u8, board: &mut B) {
        let now = self.cycle;
        let time = self.timer_time(which, now);
        let timer = &mut self.timers[which as usize];
        if timer.holds(register, value) {
            return;
        }
        timer.advance(time);
        timer.write(register, value);
        if timer.has_reserved_mode() {
            self.warn(Warning::Unsupported(Unsupported::ReservedTimerMode(which)), board);
        }
        self.refresh_timer(which, now, board);
    }

    fn write_usart<B: Board>(&mut self, register: usart::Register, value: u8, board: &mut B) {
        self.usart.write(register, value, self.cycle);
        match register {
            usart::Register::ControlB => {
                self.override_usart_pins();
                self.update_port(Port::D, self.cycle, board);
            }
            usart::Register::ControlC if self.usart.is_synchronous() => {
                self.warn(Warning::Unsupported(Unsupported::SynchronousUsart), board);
            }
            usart::Register::ControlA
            | usart::Register::ControlC
            | usart::Register::Baud
            | usart::Register::BaudHigh
            | usart::Register::Data => {}
        }
    }

    fn write_adc<B: Board>(&mut self, register: adc::Register, value: u8, board: &mut B) {
        self.refresh_timers(self.cycle, board);
        self.adc.write(register, value, self.cycle);
        self.watch_timers();
        if self.adc.has_reserved_reference() {
            self.warn(Warning::Unsupported(Unsupported::ReservedAdcInput), board);
        }
    }

    fn write_spi<B: Board>(&mut self, register: crate::spi::Register, value: u8, board: &mut B) {
        let ss = crate::board::special::SS;
        let held = !self.ports.is_output(ss) && self.ports.external(ss) == crate::pin::External::Low;
        self.spi.write(register, value, self.cycle);
        if held && self.spi.is_enabled() && self.spi.is_master() {
            self.spi.lose_mastership();
        }
        if register == crate::spi::Register::Control {
            self.override_spi_pins();
            self.update_port(Port::B, self.cycle, board);
        }
    }

    fn write_twi<B: Board>(&mut self, register: crate::twi::Register, value: u8, board: &mut B) {
        match self.twi.write(register, value, self.cycle) {
            Wanted::Nothing => {}
            Wanted::Stop => board.twi_stop(self.now()),
        }
        if register == crate::twi::Register::Control {
            self.override_twi_pins();
            self.update_port(Port::C, self.cycle, board);
        }
    }

    fn write_system<B: Board>(&mut self, register: system::Register, value: u8, board: &mut B) {
        let now = self.cycle;
        match self.system.write(register, value, now) {
            Effect::Nothing => {}
            Effect::Prescale(shift) => {
                self.clock.set_shift(now, shift);
                self.usart.clock_changed(now);
                self.refresh_timers(now, board);
            }
            Effect::PullUpsOff(off) => {
                self.ports.set_pull_ups_off(off);
                for port in Port::ALL {
                    self.update_port(port, now, board);
                }
            }
            Effect::Power => {
                self.apply_power();
                self.refresh_timers(now, board);
            }
            Effect::ResetPrescalers(value) => self.reset_prescalers(value),
            Effect::Asynchronous => self.choose_crystal(value, board),
        }
    }

    /// Timer 2 takes its other clock.
    fn choose_crystal<B: Board>(&mut self, value: u8, board: &mut B) {
        self.timers[Which::T2 as usize].advance(self.timer_time(Which::T2, self.cycle));
        self.system.set_asynchronous(value);
        if self.system.is_asynchronous() && !self.has_crystal() {
            self.warn(Warning::Unsupported(Unsupported::AsynchronousTimer), board);
        }
        let now = self.timer_time(Which::T2, self.cycle);
        self.timers[Which::T2 as usize].count_from(now);
        self.apply_power();
        self.refresh_timer(Which::T2, self.cycle, board);
    }

    fn reset_prescalers(&mut self, value: u8) {
        let now = self.cycle;
        for (which, bit) in [
            (Which::T0, system::RESET_TIMERS),
            (Which::T1, system::RESET_TIMERS),
            (Which::T2, system::RESET_TIMER2),
        ] {
            let held = value & system::HOLD != 0 && value & bit != 0;
            let time = self.timer_time(which, now);
            let timer = &mut self.timers[which as usize];
            if value & bit != 0 || timer.is_held() {
                timer.reset_prescaler(time, held);
            }
        }
    }
}

/// The bit in PRR that switches a peripheral off.
const fn clock_of(place: Place) -> u8 {
    match place {
        Place::Timer(Which::T0, _) => power::TIMER0,
        Place::Timer(Which::T1, _) => power::TIMER1,
        Place::Timer(Which::T2, _) => power::TIMER2,
        Place::Usart(_) => power::USART,
        Place::Adc(_) => power::ADC,
        Place::Spi(_) => power::SPI,
        Place::Twi(_) => power::TWI,
        Place::Reserved
        | Place::Core(_)
        | Place::Port(..)
        | Place::Eeprom(_)
        | Place::External(_)
        | Place::System(_)
        | Place::Comparator
        | Place::Watchdog
        | Place::SelfProgramming => 0,
    }
}
