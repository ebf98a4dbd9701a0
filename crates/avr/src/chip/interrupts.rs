//! The requested interrupts.

use super::Chip;
use crate::system::Sleep;
use crate::timer::{self, Which};
use crate::usart;
use crate::vector::Vector;

/// The interrupts that wake from ADC noise reduction.
const ADC_NOISE_REDUCTION: u32 = DEEP
    | Vector::Int0.bit()
    | Vector::Int1.bit()
    | Vector::Adc.bit()
    | Vector::EepromReady.bit()
    | Vector::SpmReady.bit();
/// The interrupts that wake from deep sleep. Of INT0 and INT1 the low levels do, too.
const DEEP: u32 =
    Vector::PinChange0.bit() | Vector::PinChange1.bit() | Vector::PinChange2.bit() | Vector::Watchdog.bit();
/// The interrupts of a timer 2 with its own crystal.
const TIMER2: u32 =
    Vector::Timer2CompareA.bit() | Vector::Timer2CompareB.bit() | Vector::Timer2Overflow.bit();

impl Chip {
    /// A set with the bit of each vector that is requested and enabled by its own mask.
    pub(super) fn requests(&self) -> u32 {
        let external = u32::from(self.external.requests()) << Vector::Int0.number();
        let changes = u32::from(self.external.change_requests()) << Vector::PinChange0.number();
        let mut requests = external | changes | self.timer_requests() | self.usart_requests();
        for (requested, vector) in [
            (self.watchdog.requests(), Vector::Watchdog),
            (self.spi.requests(), Vector::Spi),
            (self.adc.requests(), Vector::Adc),
            (self.eeprom.requests(), Vector::EepromReady),
            (self.comparator.requests(), Vector::Comparator),
            (self.twi.requests(), Vector::Twi),
            (self.programming.requests(), Vector::SpmReady),
        ] {
            if requested {
                requests |= vector.bit();
            }
        }
        requests
    }

    /// Whether an interrupt is requested that ends this sleep.
    pub(super) fn can_wake(&self, sleep: Sleep) -> bool {
        if self.sreg & crate::alu::I == 0 {
            return false;
        }
        let requests = self.requests();
        let low = u32::from(self.external.low_requests()) << Vector::Int0.number();
        let timer2 = if self.has_crystal() { TIMER2 } else { 0 };
        match sleep {
            Sleep::Idle => requests != 0,
            Sleep::AdcNoiseReduction => requests & (ADC_NOISE_REDUCTION | timer2) != 0,
            Sleep::PowerSave | Sleep::ExtendedStandby => requests & (DEEP | low | timer2) != 0,
            Sleep::PowerDown | Sleep::Standby => requests & (DEEP | low) != 0,
        }
    }

    /// The interrupt is taken: flags that hardware clears are cleared.
    pub(super) fn acknowledge(&mut self, vector: Vector) {
        match vector {
            Vector::Int0 => self.external.acknowledge(0),
            Vector::Int1 => self.external.acknowledge(1),
            Vector::PinChange0 => self.external.acknowledge_change(0),
            Vector::PinChange1 => self.external.acknowledge_change(1),
            Vector::PinChange2 => self.external.acknowledge_change(2),
            Vector::Watchdog => self.watchdog.acknowledge(),
            Vector::Timer2CompareA => self.timer(Which::T2).acknowledge(timer::MATCH_A),
            Vector::Timer2CompareB => self.timer(Which::T2).acknowledge(timer::MATCH_B),
            Vector::Timer2Overflow => self.timer(Which::T2).acknowledge(timer::OVERFLOW),
            Vector::Timer1Capture => self.timer(Which::T1).acknowledge(timer::CAPTURE),
            Vector::Timer1CompareA => self.timer(Which::T1).acknowledge(timer::MATCH_A),
            Vector::Timer1CompareB => self.timer(Which::T1).acknowledge(timer::MATCH_B),
            Vector::Timer1Overflow => self.timer(Which::T1).acknowledge(timer::OVERFLOW),
            Vector::Timer0CompareA => self.timer(Which::T0).acknowledge(timer::MATCH_A),
            Vector::Timer0CompareB => self.timer(Which::T0).acknowledge(timer::MATCH_B),
            Vector::Timer0Overflow => self.timer(Which::T0).acknowledge(timer::OVERFLOW),
            Vector::Spi => self.spi.acknowledge(),
            Vector::UsartSent => self.usart.acknowledge_sent(),
            Vector::Adc => self.adc.acknowledge(),
            Vector::Comparator => self.comparator.acknowledge(),
            // The request of these interrupts stays as long as its cause does.
            Vector::UsartReceived
            | Vector::UsartEmpty
            | Vector::EepromReady
            | Vector::Twi
            | Vector::SpmReady => {}
        }
        self.check_trigger(self.cycle);
    }

    fn timer(&mut self, which: Which) -> &mut timer::Timer {
        &mut self.timers[which as usize]
    }

    fn timer_requests(&self) -> u32 {
        let [t0, t1, t2] = [0, 1, 2].map(|which: usize| u32::from(self.timers[which].requests()));
        // OVF, OCA and OCB are in the opposite order of their vectors.
        let three = |flags: u32, first: Vector| {
            (flags >> 1 & 1 | flags >> 1 & 2 | (flags & 1) << 2) << first.number()
        };
        three(t0, Vector::Timer0CompareA)
            | three(t1, Vector::Timer1CompareA)
            | three(t2, Vector::Timer2CompareA)
            | (t1 >> 5 & 1) << Vector::Timer1Capture.number()
    }

    fn usart_requests(&self) -> u32 {
        let requests = self.usart.requests();
        let one = |flag: u8, vector: Vector| if requests & flag != 0 { vector.bit() } else { 0 };
        one(usart::RECEIVED, Vector::UsartReceived)
            | one(usart::EMPTY, Vector::UsartEmpty)
            | one(usart::SENT, Vector::UsartSent)
    }
}
