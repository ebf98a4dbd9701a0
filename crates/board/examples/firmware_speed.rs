//! The processor time of programs on a board without parts: `cargo run --release -p baudbot-board --example
//! firmware_speed -- FILE…`.
//!
//! For each program it prints the processor time of a simulated millisecond, of 20 seconds in steps of a millisecond.

use std::time::Instant;

use baudbot_avr::{Chip, Fuses, Part, Program, Supply};
use baudbot_board::{Board, ChipClock, Physics, Wiring};

const SECONDS: u64 = 20;
const MS: u64 = 1_000_000;

/// Nothing is around.
struct Nothing;

impl Physics for Nothing {}

fn main() {
    for file in std::env::args().skip(1) {
        let bytes = std::fs::read(&file).unwrap_or_else(|error| panic!("{file}: {error}"));
        let program =
            Program::parse(Part::Atmega328P, &bytes).unwrap_or_else(|error| panic!("{file}: {error}"));
        let chip = Chip::new(&program, Fuses::external_clock(Part::Atmega328P), Supply::ARDUINO);
        let clock = ChipClock::exact(16_000_000).expect("it does not stand");
        let wiring = Wiring::builder().build().expect("it is empty");
        let mut board = Board::new(chip, clock, wiring).expect("both have 16 MHz");
        let begun = Instant::now();
        for step in 1..=1000 * SECONDS {
            board.run_until(step * MS, &mut Nothing);
            board.sent().for_each(drop);
        }
        let ns = begun.elapsed().as_nanos() / u128::from(1000 * SECONDS);
        println!("{ns:6} ns for a millisecond, {:5} times real time: {file}", u128::from(MS) / ns.max(1));
    }
}
