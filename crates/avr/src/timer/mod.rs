//! Timer/Counter0, 1 and 2.
//!
//! A timer is not stepped in each cycle: `advance` brings it to an instant, from one of its corners (match, top,
//! bottom) to the next, and `next_event` gives the next instant of an event that the chip has to see. Instants are
//! cycles of the clock that the prescaler divides: the processor's, or that of a crystal.
//!
//! A tick of the timer happens at each cycle that the prescaler's division divides. Its flags are set by the tick that ends
//! the value compared, as the timing diagrams of the data sheet have it: OCF with the tick from OCR to OCR + 1, TOV with the
//! tick to BOTTOM.
//!
//! Source: data sheet, chapters *8-bit Timer/Counter0 with PWM*, *16-bit Timer/Counter1 with PWM*, *Timer/Counter0 and
//! Timer/Counter1 Prescalers*, *8-bit Timer/Counter2 with PWM and Asynchronous Operation*.
//!
//! # Deviations
//!
//! An edge at T0, T1 or ICP1 takes effect at once, not after the 2.5 to
//! 3.5 cycles of the synchroniser; the noise canceller delays by its 4 cycles.

mod count;
mod mode;
mod shape;

use serde::{Deserialize, Serialize};

use mode::{Mode, Output, Top, Update};

/// A timer of a chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Which {
    /// Timer/Counter0, 8 bits.
    T0,
    /// Timer/Counter1, 16 bits.
    T1,
    /// Timer/Counter2, 8 bits, with other divisions.
    T2,
}

/// TOVn in TIFRn and TIMSKn.
pub(crate) const OVERFLOW: u8 = 1 << 0;
/// OCFnA.
pub(crate) const MATCH_A: u8 = 1 << 1;
/// OCFnB.
pub(crate) const MATCH_B: u8 = 1 << 2;
/// ICF1.
pub(crate) const CAPTURE: u8 = 1 << 5;

const NOISE_CANCELLER: u8 = 1 << 7;
const CAPTURE_RISING: u8 = 1 << 6;
const FORCE_A: u8 = 1 << 7;
const FORCE_B: u8 = 1 << 6;
/// Samples that must be equal before the noise canceller passes an edge on.
const NOISE_CYCLES: u64 = 4;

/// A register of a timer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Register {
    ControlA,
    ControlB,
    ControlC,
    Count,
    CountHigh,
    Capture,
    CaptureHigh,
    CompareA,
    CompareAHigh,
    CompareB,
    CompareBHigh,
    Flags,
    Mask,
}

impl Register {
    /// Whether only the program changes it.
    pub(crate) const fn is_control(self) -> bool {
        matches!(self, Self::ControlA | Self::ControlB)
    }
}

/// The clock of a timer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    Stopped,
    Divided(u64),
    Falling,
    Rising,
}

/// A timer with its registers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Timer {
    which: Which,
    control: [u8; 2],
    count: u16,
    down: bool,
    /// The values to compare the counter with.
    compare: [u16; 2],
    /// The values as the program has written them; modes with a double buffer take them over later.
    buffer: [u16; 2],
    capture: u16,
    temporary: u8,
    flags: u8,
    mask: u8,
    /// The output latches; bit 0 is OCnA.
    latches: u8,
    /// A write to the counter blocks the match of the next tick.
    blocked: bool,
    /// Brought up to this cycle.
    at: u64,
    /// A cycle at which the prescaler was zero.
    zero: u64,
    /// The prescaler is held in reset.
    held: bool,
    /// The clock is off: power reduction or sleep.
    off: bool,
    /// Outputs whose edges are watched; bit 0 is OCnA.
    watched: u8,
    /// Flags that start conversions of the ADC.
    triggers: u8,
    /// The instant at which an edge has passed the noise canceller.
    noise_until: u64,
}

impl Timer {
    pub(crate) const fn new(which: Which, now: u64) -> Self {
        Self {
            which,
            control: [0; 2],
            count: 0,
            down: false,
            compare: [0; 2],
            buffer: [0; 2],
            capture: 0,
            temporary: 0,
            flags: 0,
            mask: 0,
            latches: 0,
            blocked: false,
            at: now,
            zero: now,
            held: false,
            off: false,
            watched: 0,
            triggers: 0,
            noise_until: u64::MAX,
        }
    }

    /// Whether this is the timer of this number, and can exist at a cycle.
    pub(crate) fn is_possible(&self, which: usize, now: u64) -> bool {
        let values = [self.count, self.compare[0], self.compare[1], self.buffer[0], self.buffer[1]];
        self.which as usize == which
            && values.into_iter().all(|value| value <= self.max())
            && self.zero <= self.at
            && self.at <= now
            && self.noise_until >= self.at
    }

    /// Flags whose interrupts are enabled.
    pub(crate) const fn requests(&self) -> u8 {
        self.flags & self.mask
    }

    pub(crate) const fn flags(&self) -> u8 {
        self.flags
    }

    /// An interrupt has been taken.
    pub(crate) fn acknowledge(&mut self, flag: u8) {
        self.flags &= !flag;
    }

    /// The prescaler starts again from zero, or is held there.
    pub(crate) fn reset_prescaler(&mut self, now: u64, held: bool) {
        self.advance(now);
        self.zero = now;
        self.held = held;
    }

    /// The timer has another clock, which has this time.
    pub(crate) const fn count_from(&mut self, now: u64) {
        self.at = now;
        self.zero = now;
    }

    /// Whether the prescaler is held.
    pub(crate) const fn is_held(&self) -> bool {
        self.held
    }

    /// WGM has one of its reserved values.
    pub(crate) const fn has_reserved_mode(&self) -> bool {
        match self.which {
            Which::T1 => self.waveform() == 13,
            Which::T0 | Which::T2 => matches!(self.waveform(), 4 | 6),
        }
    }

    /// Switches the clock of the timer off or on.
    pub(crate) fn set_off(&mut self, now: u64, off: bool) {
        self.advance(now);
        self.off = off;
    }

    /// Sets the outputs whose edges are waited for, bit 0 is OCnA, and the flags that start conversions.
    pub(crate) fn watch(&mut self, outputs: u8, triggers: u8) {
        self.watched = outputs;
        self.triggers = triggers;
    }

    /// The levels of the outputs that are connected to their pins; None where the port has the pin.
    pub(crate) fn outputs(&self) -> [Option<bool>; 2] {
        [0, 1].map(|channel| {
            (self.output(channel) != Output::Disconnected).then_some(self.latches >> channel & 1 == 1)
        })
    }

    /// Reads a register at an instant to which the timer has been brought.
    pub(crate) fn read(&mut self, register: Register) -> u8 {
        let mut sixteen = |value: u16, latches: bool| {
            let [low, high] = value.to_le_bytes();
            if latches {
                self.temporary = high;
            }
            low
        };
        match register {
            Register::ControlA => self.control[0],
            Register::ControlB => self.control[1],
            Register::ControlC => 0,
            Register::Count => sixteen(self.count, true),
            Register::Capture => sixteen(self.capture, true),
            Register::CountHigh | Register::CaptureHigh => self.temporary,
            Register::CompareA => sixteen(self.buffer[0], false),
            Register::CompareB => sixteen(self.buffer[1], false),
            Register::CompareAHigh => self.buffer[0].to_le_bytes()[1],
            Register::CompareBHigh => self.buffer[1].to_le_bytes()[1],
            Register::Flags => self.flags,
            Register::Mask => self.mask,
        }
    }

    /// Whether TCCRnA has this value already, so that a write changes nothing. Programs take outputs off timers again
    /// and again.
    pub(crate) fn holds(&self, register: Register, value: u8) -> bool {
        register == Register::ControlA && self.control[0] == value
    }

    /// Writes a register at an instant to which the timer has been brought.
    pub(crate) fn write(&mut self, register: Register, value: u8) {
        let sixteen =
            if self.which == Which::T1 { u16::from_le_bytes([value, self.temporary]) } else { value.into() };
        match register {
            Register::ControlA => self.control[0] = value,
            Register::ControlB if self.which == Which::T1 => self.control[1] = value,
            Register::ControlB => {
                self.control[1] = value & 0x0F;
                self.force(value);
            }
            Register::ControlC => self.force(value),
            Register::Count => {
                self.count = sixteen;
                self.blocked = true;
                // The counter can only go up from BOTTOM.
                self.down &= sixteen != 0;
            }
            Register::CountHigh | Register::CaptureHigh | Register::CompareAHigh | Register::CompareBHigh => {
                self.temporary = value;
            }
            Register::Capture if self.mode().top == Top::Capture => self.capture = sixteen,
            Register::Capture => {}
            Register::CompareA => self.buffer[0] = sixteen,
            Register::CompareB => self.buffer[1] = sixteen,
            Register::Flags => self.flags &= !value,
            Register::Mask => self.mask = value & self.possible_flags(),
        }
        if self.mode().update == Update::Immediate {
            self.compare = self.buffer;
        }
        if !matches!(self.mode().slope, mode::Slope::Dual) {
            self.down = false;
        }
    }

    /// An edge at the pin Tn.
    pub(crate) fn clock_edge(&mut self, now: u64, rising: bool) {
        self.advance(now);
        let wanted = if rising { Source::Rising } else { Source::Falling };
        if !self.off && self.source() == wanted {
            self.tick();
        }
    }

    /// An edge at the pin ICP1, or of the comparator.
    pub(crate) fn capture_edge(&mut self, now: u64, rising: bool) {
        self.advance(now);
        let wanted = rising == (self.control[1] & CAPTURE_RISING != 0);
        if self.off || self.mode().top == Top::Capture {
            return;
        }
        if self.control[1] & NOISE_CANCELLER == 0 {
            if wanted {
                self.take_capture();
            }
        } else {
            self.noise_until = if wanted { now + NOISE_CYCLES } else { u64::MAX };
        }
    }

    fn take_capture(&mut self) {
        self.capture = self.count;
        self.flags |= CAPTURE;
    }

    /// FOCnA and FOCnB: the pin does what it would do on a match, without a flag.
    fn force(&mut self, value: u8) {
        if self.mode().is_pwm() {
            return;
        }
        for (channel, bit) in [(0, FORCE_A), (1, FORCE_B)] {
            if value & bit != 0 {
                self.apply(channel, self.output(channel));
            }
        }
    }

    const fn possible_flags(&self) -> u8 {
        match self.which {
            Which::T1 => OVERFLOW | MATCH_A | MATCH_B | CAPTURE,
            Which::T0 | Which::T2 => OVERFLOW | MATCH_A | MATCH_B,
        }
    }

    /// WGMn bits of both control registers.
    const fn waveform(&self) -> u8 {
        match self.which {
            Which::T1 => self.control[0] & 3 | self.control[1] >> 1 & 0x0C,
            Which::T0 | Which::T2 => self.control[0] & 3 | self.control[1] >> 1 & 4,
        }
    }

    const fn mode(&self) -> Mode {
        match self.which {
            Which::T1 => Mode::sixteen(self.waveform()),
            Which::T0 | Which::T2 => Mode::eight(self.waveform()),
        }
    }

    const fn max(&self) -> u16 {
        match self.which {
            Which::T1 => 0xFFFF,
            Which::T0 | Which::T2 => 0xFF,
        }
    }

    const fn top(&self) -> u16 {
        match self.mode().top {
            Top::Fixed(top) => top,
            Top::CompareA => self.compare[0],
            Top::Capture => self.capture,
        }
    }

    const fn source(&self) -> Source {
        let select = self.control[1] & 7;
        match (self.which, select) {
            (_, 0) => Source::Stopped,
            (_, 1) => Source::Divided(1),
            (_, 2) => Source::Divided(8),
            (Which::T2, 3) => Source::Divided(32),
            (Which::T2, 4) => Source::Divided(64),
            (Which::T2, 5) => Source::Divided(128),
            (Which::T2, 6) => Source::Divided(256),
            (Which::T2, _) => Source::Divided(1024),
            (Which::T0 | Which::T1, 3) => Source::Divided(64),
            (Which::T0 | Which::T1, 4) => Source::Divided(256),
            (Which::T0 | Which::T1, 5) => Source::Divided(1024),
            (Which::T0 | Which::T1, 6) => Source::Falling,
            (Which::T0 | Which::T1, _) => Source::Rising,
        }
    }

    /// The effect of a match on the pin of a channel, 0 for A.
    fn output(&self, channel: usize) -> Output {
        let waveform = self.waveform();
        let toggles = match self.which {
            _ if !self.mode().is_pwm() => true,
            Which::T1 => channel == 0 && matches!(waveform, 9 | 11 | 14 | 15),
            Which::T0 | Which::T2 => channel == 0 && matches!(waveform, 5 | 7),
        };
        Output::of(self.control[0] >> (6 - 2 * channel), toggles)
    }
}

#[cfg(test)]
mod tests;
