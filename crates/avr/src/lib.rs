//! A microcontroller, cycle by cycle: an ATmega48, 88, 168 or 328 with its memories and peripherals.
//!
//! A [`Chip`] is a value: it can be cloned, compared, saved and loaded in the middle of anything, and goes on to the same bits.
//! It knows nothing of what is around it; that is a [`Board`], which is told what the pins do, and gives voltages and answers.
//!
//! # Time
//!
//! Instants at the border are counted in periods of the chip's clock source since it was made: at 16 MHz 62.5 ns each. They go on
//! through sleep and changes of the clock prescaler. The chip runs until an instant, and stops at the first boundary of an
//! instruction at or after it.
//!
//! Input comes beforehand, with its instant: levels of pins ([`Chip::set_pin`]), characters at RXD ([`Chip::receive`]).
//!
//! # How it works
//!
//! Instructions are decoded once for each program, and clones share them. Peripherals are not stepped: each knows its next event,
//! counters are worked out when they are read, and the processor executes instructions until the first event of all. A chip that
//! sleeps goes to its next event at once, and so does one in a loop that comes back to where it was: that asks for a variable,
//! a pin or a flag until it changes.
//!
//! # What is not there
//!
//! A program that switches one of these on causes a [`Warning`]: synchronous modes of the USART, and timer 2 with a crystal of
//! its own where the clock source takes the crystal's pins. As a TWI slave the chip is never addressed. Of the USART, the SPI and
//! the TWI, power reduction (PRR) only keeps writes away. Brown-out detection is left to the embedder ([`Chip::reset_now`]).
//! Each peripheral's module lists its deviations from the data sheet.
//!
//! # Example
//!
//! ```
//! use baudbot_avr::{Board, Chip, Drive, Fuses, Part, Pin, Port, Program, Supply};
//!
//! /// Counts the edges of an LED.
//! struct Led(u32);
//!
//! impl Board for Led {
//!     fn pin_changed(&mut self, pin: Pin, _drive: Drive, _at: u64) {
//!         self.0 += u32::from(Some(pin) == Pin::new(Port::B, 5));
//!     }
//! }
//!
//! // sbi DDRB, 5; sbi PINB, 5; rjmp .-4
//! let program = Program::from_words(Part::Atmega328P, &[0x9A25, 0x9A1D, 0xCFFE])?;
//! let mut chip = Chip::new(&program, Fuses::external_clock(Part::Atmega328P), Supply::ARDUINO);
//! let mut led = Led(0);
//! chip.run(16_000, &mut led);
//! // A millisecond has 16,000 cycles; the loop has 4.
//! assert!(led.0 > 3900);
//! # Ok::<(), baudbot_avr::ProgramError>(())
//! ```
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

mod adc;
mod address;
mod alu;
mod board;
mod checked;
mod chip;
mod clock;
mod comparator;
mod eeprom;
mod external;
mod flash;
pub mod fuses;
mod instruction;
pub mod part;
pub mod pin;
mod ports;
pub mod program;
mod rounds;
mod spi;
mod spm;
mod system;
mod timer;
mod twi;
pub mod usart;
mod vector;
mod watchdog;

pub use board::{AnalogInput, Bare, Board, Direction, Supply, Unsupported, Warning};
pub use chip::{Channel, Chip, InputError, Stop};
pub use clock::LATEST;
pub use flash::NO_MEMORY;
pub use fuses::Fuses;
pub use instruction::{Op, decode};
pub use part::Part;
pub use pin::{Drive, External, Pin, Port, Pwm, PwmReport};
pub use program::{Program, ProgramError};
pub use rounds::{Round, Rounds};
pub use system::{ResetCause, Sleep};
pub use timer::Which as Timer;
pub use vector::Vector;
