//! Programs as people flash them, on boards with parts: sketches that Debian's avr-gcc and Arduino's core were built of, and
//! firmware of others.
//!
//! `python3 tests/firmware/build.py DIR` makes the programs, and `BAUDBOT_SKETCHES=DIR` is their folder.

mod bench;
mod bootloader;
mod buses;
mod firmata;
mod lines;
mod motion;
mod rounds;
mod sensors;
mod steps;
mod text;
mod time;
mod wheels;
