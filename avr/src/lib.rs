//! ATmega48 to ATmega328, cycle by cycle.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod fuses;
pub mod part;
pub mod program;

pub use fuses::Fuses;
pub use part::Part;
pub use program::{Program, ProgramError};
