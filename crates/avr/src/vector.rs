//! Interrupt vectors, in the order of their priority.
//!
//! Source: data sheet, chapter *Interrupts*, tables *Reset and Interrupt Vectors*.

use serde::{Deserialize, Serialize};

/// An interrupt. Those that come first go first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[allow(missing_docs)] // The names are those of the table.
pub enum Vector {
    Int0 = 1,
    Int1,
    PinChange0,
    PinChange1,
    PinChange2,
    Watchdog,
    Timer2CompareA,
    Timer2CompareB,
    Timer2Overflow,
    Timer1Capture,
    Timer1CompareA,
    Timer1CompareB,
    Timer1Overflow,
    Timer0CompareA,
    Timer0CompareB,
    Timer0Overflow,
    Spi,
    UsartReceived,
    UsartEmpty,
    UsartSent,
    Adc,
    EepromReady,
    Comparator,
    Twi,
    SpmReady,
}

impl Vector {
    /// All interrupts by their priority.
    pub const ALL: [Self; 25] = [
        Self::Int0,
        Self::Int1,
        Self::PinChange0,
        Self::PinChange1,
        Self::PinChange2,
        Self::Watchdog,
        Self::Timer2CompareA,
        Self::Timer2CompareB,
        Self::Timer2Overflow,
        Self::Timer1Capture,
        Self::Timer1CompareA,
        Self::Timer1CompareB,
        Self::Timer1Overflow,
        Self::Timer0CompareA,
        Self::Timer0CompareB,
        Self::Timer0Overflow,
        Self::Spi,
        Self::UsartReceived,
        Self::UsartEmpty,
        Self::UsartSent,
        Self::Adc,
        Self::EepromReady,
        Self::Comparator,
        Self::Twi,
        Self::SpmReady,
    ];

    /// The number in the table, from 1; 0 is the reset.
    pub const fn number(self) -> u32 {
        self as u32
    }

    /// The bit of this interrupt in a set of requests.
    pub(crate) const fn bit(self) -> u32 {
        1 << self.number()
    }

    /// The first of a set of requests.
    pub(crate) fn first_of(requests: u32) -> Option<Self> {
        let number = requests.trailing_zeros();
        Self::ALL.get(usize::try_from(number).ok()?.checked_sub(1)?).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interrupts_have_the_numbers_of_the_table() {
        for (number, vector) in (1..).zip(Vector::ALL) {
            assert_eq!(vector.number(), number);
            assert_eq!(Vector::first_of(vector.bit() | Vector::SpmReady.bit()), Some(vector));
        }
        assert_eq!(Vector::first_of(0), None);
        assert_eq!(Vector::UsartReceived.number(), 18);
    }
}
