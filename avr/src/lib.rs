//! ATmega48 to ATmega328, cycle by cycle.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

mod adc;
mod address;
mod alu;
mod board;
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
pub use fuses::Fuses;
pub use instruction::{Op, decode};
pub use part::Part;
pub use pin::{Drive, External, Pin, Port, Pwm, PwmReport};
pub use program::{Program, ProgramError};
pub use system::{ResetCause, Sleep};
pub use timer::Which as Timer;
pub use vector::Vector;
