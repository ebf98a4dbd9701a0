//! Small programs on boards with parts.

mod asm;
mod bus;
mod debug;
mod edges;
mod motion;
mod saved;
mod sensors;
mod state;
mod uart;
mod warnings;
mod world;
