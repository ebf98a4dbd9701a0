//! Registers of the chip as a whole: sleep, resets, clock prescaler, power reduction.
//!
//! Source: data sheet, chapters *System Clock and Clock Options*, *Power Management and Sleep Modes*, *System Control and
//! Reset*, section *Moving Interrupts Between Application and Boot Space*.

use serde::{Deserialize, Serialize};

use crate::clock::Window;

/// A register of the system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Register {
    Sleep,
    Status,
    Control,
    PowerReduction,
    OscillatorCalibration,
    Prescaler,
    General(usize),
    /// DIDR0 and DIDR1.
    DigitalOff(usize),
    TimerControl,
    AsynchronousStatus,
}

/// The cause of a reset: the bits of MCUSR.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ResetCause {
    /// PORF: the supply was switched on.
    PowerOn = 0x01,
    /// EXTRF: the pin RESET was low.
    External = 0x02,
    /// BORF: the supply was too low.
    BrownOut = 0x04,
    /// WDRF: the watchdog.
    Watchdog = 0x08,
}

/// A sleep mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Sleep {
    /// Only the processor stands.
    Idle,
    /// The clocks of processor and I/O stand; the ADC's runs.
    AdcNoiseReduction,
    /// All clocks stand, and the oscillator.
    PowerDown,
    /// The same as power-down, but a timer 2 with its own crystal runs.
    PowerSave,
    /// All clocks stand; the oscillator runs.
    Standby,
    /// The same as standby, but a timer 2 with its own crystal runs.
    ExtendedStandby,
}

impl Sleep {
    /// Whether the system clock stands.
    pub const fn is_deep(self) -> bool {
        match self {
            Self::Idle | Self::AdcNoiseReduction => false,
            Self::PowerDown | Self::PowerSave | Self::Standby | Self::ExtendedStandby => true,
        }
    }

    /// Whether the oscillator stands, too, and must start again.
    pub const fn stops_oscillator(self) -> bool {
        matches!(self, Self::PowerDown | Self::PowerSave)
    }
}

/// PRR: parts whose clocks are off.
pub(crate) mod power {
    pub(crate) const ADC: u8 = 1 << 0;
    pub(crate) const USART: u8 = 1 << 1;
    pub(crate) const SPI: u8 = 1 << 2;
    pub(crate) const TIMER1: u8 = 1 << 3;
    pub(crate) const TIMER0: u8 = 1 << 5;
    pub(crate) const TIMER2: u8 = 1 << 6;
    pub(crate) const TWI: u8 = 1 << 7;
}

/// A write's request to the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effect {
    Nothing,
    /// The clock prescaler is this from now on.
    Prescale(u8),
    PullUpsOff(bool),
    Power,
    /// GTCCR was written.
    ResetPrescalers(u8),
    /// ASSR was written.
    Asynchronous,
}

const SLEEP_ENABLE: u8 = 1;
const VECTORS_IN_BOOT: u8 = 1 << 1;
const VECTOR_CHANGE: u8 = 1;
const PULL_UPS_OFF: u8 = 1 << 4;
const PRESCALER_CHANGE: u8 = 1 << 7;
/// GTCCR.
pub(crate) const HOLD: u8 = 1 << 7;
pub(crate) const RESET_TIMER2: u8 = 1 << 1;
pub(crate) const RESET_TIMERS: u8 = 1 << 0;
/// ASSR: AS2 and EXCLK.
const ASYNCHRONOUS: u8 = 1 << 5;
const ASYNCHRONOUS_BITS: u8 = 3 << 5;
const LARGEST_PRESCALER: u8 = 8;
/// A middle value, as that of a real chip is not known.
const CALIBRATION: u8 = 0x80;

/// The registers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct System {
    sleep: u8,
    status: u8,
    control: u8,
    power: u8,
    calibration: u8,
    prescaler: u8,
    general: [u8; 3],
    digital_off: [u8; 2],
    timer_control: u8,
    asynchronous: u8,
    /// Warnings since the last reset that a program out of control causes with each instruction.
    pub(crate) often_warned: u8,
    prescaler_window: Window,
    vector_window: Window,
}

impl System {
    pub(crate) fn new(prescaler: u8, status: u8) -> Self {
        Self {
            sleep: 0,
            status,
            control: 0,
            power: 0,
            calibration: CALIBRATION,
            prescaler,
            general: [0; 3],
            digital_off: [0; 2],
            timer_control: 0,
            asynchronous: 0,
            often_warned: 0,
            prescaler_window: Window::default(),
            vector_window: Window::default(),
        }
    }

    /// The sleep mode that `SLEEP` would enter; None: it is not enabled, or reserved.
    pub(crate) const fn sleep_mode(&self) -> Option<Sleep> {
        if self.sleep & SLEEP_ENABLE == 0 {
            return None;
        }
        match self.sleep >> 1 & 7 {
            0 => Some(Sleep::Idle),
            1 => Some(Sleep::AdcNoiseReduction),
            2 => Some(Sleep::PowerDown),
            3 => Some(Sleep::PowerSave),
            6 => Some(Sleep::Standby),
            7 => Some(Sleep::ExtendedStandby),
            _ => None,
        }
    }

    /// MCUSR.
    pub(crate) const fn status(&self) -> u8 {
        self.status
    }

    /// WDRF.
    pub(crate) const fn has_watchdog_bitten(&self) -> bool {
        self.status & ResetCause::Watchdog as u8 != 0
    }

    /// IVSEL.
    pub(crate) const fn vectors_in_boot(&self) -> bool {
        self.control & VECTORS_IN_BOOT != 0
    }

    /// AS2.
    pub(crate) const fn is_asynchronous(&self) -> bool {
        self.asynchronous & ASYNCHRONOUS != 0
    }

    /// Writes ASSR.
    pub(crate) const fn set_asynchronous(&mut self, value: u8) {
        self.asynchronous = value & ASYNCHRONOUS_BITS;
    }

    /// PRR.
    pub(crate) const fn power(&self) -> u8 {
        self.power
    }

    pub(crate) const fn read(&self, register: Register) -> u8 {
        match register {
            Register::Sleep => self.sleep,
            Register::Status => self.status,
            Register::Control => self.control,
            Register::PowerReduction => self.power,
            Register::OscillatorCalibration => self.calibration,
            Register::Prescaler => self.prescaler,
            Register::General(which) => self.general[which],
            Register::DigitalOff(which) => self.digital_off[which],
            Register::TimerControl => self.timer_control,
            Register::AsynchronousStatus => self.asynchronous,
        }
    }

    pub(crate) fn write(&mut self, register: Register, value: u8, now: u64) -> Effect {
        match register {
            Register::Sleep => self.sleep = value & 0x0F,
            // Flags can be cleared only.
            Register::Status => self.status &= value,
            Register::Control => return self.write_control(value, now),
            Register::PowerReduction => {
                self.power = value & 0xEF;
                return Effect::Power;
            }
            Register::OscillatorCalibration => self.calibration = value,
            Register::Prescaler => return self.write_prescaler(value, now),
            Register::General(which) => self.general[which] = value,
            Register::DigitalOff(which) => self.digital_off[which] = value,
            Register::TimerControl => {
                // The reset bits stay only as long as TSM holds them.
                self.timer_control =
                    if value & HOLD == 0 { 0 } else { value & (HOLD | RESET_TIMER2 | RESET_TIMERS) };
                return Effect::ResetPrescalers(value);
            }
            Register::AsynchronousStatus => return Effect::Asynchronous,
        }
        Effect::Nothing
    }

    fn write_control(&mut self, value: u8, now: u64) -> Effect {
        if value & VECTOR_CHANGE != 0 {
            self.vector_window.open(now);
        } else if self.vector_window.is_open(now) {
            self.control = self.control & !VECTORS_IN_BOOT | value & VECTORS_IN_BOOT;
            self.vector_window.close();
        }
        self.control = self.control & VECTORS_IN_BOOT | value & PULL_UPS_OFF;
        Effect::PullUpsOff(value & PULL_UPS_OFF != 0)
    }

    fn write_prescaler(&mut self, value: u8, now: u64) -> Effect {
        if value == PRESCALER_CHANGE {
            self.prescaler_window.open(now);
        } else if value & PRESCALER_CHANGE == 0 && self.prescaler_window.is_open(now) {
            self.prescaler_window.close();
            self.prescaler = (value & 0x0F).min(LARGEST_PRESCALER);
            return Effect::Prescale(self.prescaler);
        }
        Effect::Nothing
    }
}
