//! Debuggers that speak the protocol over a real socket.

mod chip;
mod client;
mod others;
mod running;
mod world;
