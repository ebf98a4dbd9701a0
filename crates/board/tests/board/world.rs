//! Boards at the instant before their start, and a world of constants.

use baudbot_avr::{Chip, Fuses, Part, Program, Supply};
use baudbot_board::{Board, Builder, ChipClock, PartId, Physics, Wheel};

use crate::board::asm::Asm;

pub(crate) const MS: u64 = 1_000_000;

/// A world that gives all parts their feelings, and notes for what it was asked.
#[derive(Clone, Default)]
pub(crate) struct World {
    pub(crate) volts: f64,
    pub(crate) discharge_ns: u64,
    pub(crate) pressed: bool,
    pub(crate) wheel: Wheel,
    pub(crate) echo_ns: Option<u64>,
    pub(crate) gauss: [f64; 3],
    pub(crate) echoes: Vec<u64>,
}

impl Physics for World {
    fn volts(&mut self, _part: PartId, _at_ns: u64) -> f64 {
        self.volts
    }

    fn discharge_ns(&mut self, _part: PartId, _at_ns: u64) -> u64 {
        self.discharge_ns
    }

    fn is_pressed(&mut self, _part: PartId, _at_ns: u64) -> bool {
        self.pressed
    }

    fn wheel(&mut self, _part: PartId, _at_ns: u64) -> Wheel {
        self.wheel
    }

    fn echo_ns(&mut self, _part: PartId, at_ns: u64) -> Option<u64> {
        self.echoes.push(at_ns);
        self.echo_ns
    }

    fn gauss(&mut self, _part: PartId, _at_ns: u64) -> [f64; 3] {
        self.gauss
    }
}

pub(crate) fn board(program: &Asm, wiring: Builder) -> Board {
    with_program(&Program::from_words(Part::Atmega328P, &program.words).unwrap(), wiring)
}

/// A board with a program of the tests of the chip.
pub(crate) fn board_with_file(file: &str, wiring: Builder) -> Board {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../avr/tests/programs").join(file);
    with_program(&Program::parse(Part::Atmega328P, &std::fs::read(path).unwrap()).unwrap(), wiring)
}

fn with_program(program: &Program, wiring: Builder) -> Board {
    let chip = Chip::new(program, Fuses::external_clock(Part::Atmega328P), Supply::ARDUINO);
    Board::new(chip, ChipClock::exact(16_000_000).unwrap(), wiring.build().unwrap()).unwrap()
}

/// A pair of general registers, low one first.
pub(crate) fn pair(board: &Board, low: usize) -> u16 {
    let registers = board.chip().general_registers();
    u16::from_le_bytes([registers[low], registers[low + 1]])
}

pub(crate) fn register(board: &Board, register: usize) -> u8 {
    board.chip().general_registers()[register]
}
