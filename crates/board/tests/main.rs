//! Programs on boards with parts: small ones, and those that people flash.

mod board;
mod sketches;
