//! A robot's microcontroller under a debugger: the remote serial protocol of GDB, for `avr-gdb`.
//!
//! A [`GdbServer`] is a [`Probe`](baudbot_sim::chip::Probe): a world in which it is put on a robot
//! ([`World::probe`](baudbot_sim::World::probe)) waits at the chip's reset until a debugger has connected, and stands whenever the
//! chip is stopped. What stops it is on instructions' boundaries alone, so that a program that is only looked at does the same as
//! without a debugger, to the last bit.
//!
//! # Addresses
//!
//! They are those of `avr-gdb`: flash from 0 on in bytes, the data space from `0x800000`, the EEPROM from `0x810000`. Reading has no
//! effect on the chip, not even on registers of peripherals; writing has what an instruction's has.
//!
//! # What is not there
//!
//! Fuses, lock bits and the signature are not in memory. Watchpoints are for writes to the static memory: others are
//! refused. A debugger cannot go backwards. `kill` releases the chip, as `detach` does.

mod arch;
mod memory;
mod monitor;
mod server;
mod session;
mod stops;
mod target;
mod wire;

pub use server::GdbServer;
