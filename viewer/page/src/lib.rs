//! Worlds, their server and brains of the repertoire for a page in a browser, compiled to WebAssembly (`wasm32-wasip1`).
//!
//! The page's scripts run this in a worker, with a clock, random numbers and files in memory by WASI:
//!
//! 1. [`abi`] is what they call: numbers and bytes only.
//! 2. [`page`] is the server ([`baudbot_server::Embedded`]) with its clients: each has a port, through which messages of `page.proto`
//!    go, as over a WebSocket elsewhere. It works in turns, and never waits: a worker that waits hears nothing.
//! 3. [`orders`] is what a page asks of its own program, beside the contract: which scenarios and brains there are, and that a brain
//!    of the repertoire drives a robot.
//!
//! A brain is a client of the server here as well, so that a world does the same as with `baudbot serve`, to the last bit.

pub mod abi;
mod brains;
mod idle;
pub mod orders;
pub mod page;
