//! A board on a bench, with a world whose quantities a test sets, part by part.

use std::collections::VecDeque;
use std::path::PathBuf;

use baudbot_avr::usart::Frame;
use baudbot_avr::{Chip, Fuses, Part, Program, Supply};
use baudbot_board::{Board, Builder, ChipClock, MotorDrive, PartId, Physics, Sent, Wheel};

pub(crate) const US: u64 = 1000;
pub(crate) const MS: u64 = 1_000_000;
const PARTS: usize = 16;

/// The feelings of the parts, in the order of the parts.
#[derive(Clone, Default)]
pub(crate) struct World {
    pub(crate) volts: [f64; PARTS],
    pub(crate) discharge_ns: [u64; PARTS],
    pub(crate) pressed: [bool; PARTS],
    pub(crate) wheels: [Wheel; PARTS],
    pub(crate) echo_ns: [Option<u64>; PARTS],
    pub(crate) gauss: [f64; 3],
}

impl Physics for World {
    fn volts(&mut self, part: PartId, _at_ns: u64) -> f64 {
        self.volts[part.index()]
    }

    fn discharge_ns(&mut self, part: PartId, _at_ns: u64) -> u64 {
        self.discharge_ns[part.index()]
    }

    fn is_pressed(&mut self, part: PartId, _at_ns: u64) -> bool {
        self.pressed[part.index()]
    }

    fn wheel(&mut self, part: PartId, _at_ns: u64) -> Wheel {
        self.wheels[part.index()]
    }

    fn echo_ns(&mut self, part: PartId, _at_ns: u64) -> Option<u64> {
        self.echo_ns[part.index()]
    }

    fn gauss(&mut self, _part: PartId, _at_ns: u64) -> [f64; 3] {
        self.gauss
    }
}

/// A board, its world, and what its serial cable carries.
pub(crate) struct Bench {
    pub(crate) board: Board,
    pub(crate) world: World,
    /// All characters since the start.
    pub(crate) sent: Vec<Sent>,
    read: usize,
    typed: VecDeque<(u64, u8, u32)>,
}

/// The fuses of an Arduino Uno, but without its boot loader: a reset starts the program.
pub(crate) const FUSES: Fuses = Fuses { high: 0xDF, ..Fuses::ARDUINO_UNO };

/// A board with a program that `build.py` has built.
pub(crate) fn bench(file: &str, wiring: Builder) -> Bench {
    with_chip(chip(file, FUSES).unwrap_or_else(|| panic!("{file} was not built")), wiring)
}

/// A board with a program that `build.py` has fetched. None, with a message, if it could not be had.
pub(crate) fn bench_with_fetched(file: &str, wiring: Builder) -> Option<Bench> {
    let Some(chip) = chip(file, FUSES) else {
        println!("NOT CHECKED: {file} could not be fetched");
        return None;
    };
    Some(with_chip(chip, wiring))
}

pub(crate) fn with_chip(chip: Chip, wiring: Builder) -> Bench {
    let clock = ChipClock::exact(16_000_000).unwrap();
    let board = Board::new(chip, clock, wiring.build().unwrap()).unwrap();
    Bench { board, world: World::default(), sent: Vec::new(), read: 0, typed: VecDeque::new() }
}

pub(crate) fn chip(file: &str, fuses: Fuses) -> Option<Chip> {
    Some(Chip::new(&program(file)?, fuses, Supply::ARDUINO))
}

pub(crate) fn program(file: &str) -> Option<Program> {
    let folder = std::env::var("BAUDBOT_SKETCHES")
        .expect("BAUDBOT_SKETCHES names no folder: python3 tests/firmware/build.py DIR makes one");
    let bytes = std::fs::read(PathBuf::from(folder).join(file)).ok()?;
    Some(Program::parse(Part::Atmega328P, &bytes).unwrap())
}

impl Bench {
    /// Runs for a time in steps of a millisecond, as a world would.
    pub(crate) fn run(&mut self, ms: u64) {
        for _ in 0..ms {
            self.step(MS);
        }
    }

    /// A step of any length.
    pub(crate) fn step(&mut self, ns: u64) {
        let end = self.board.now_ns() + ns;
        while let Some(&(start, byte, baud)) = self.typed.front().filter(|typed| typed.0 < end) {
            self.board.receive(Frame::byte(byte), start, baud).unwrap();
            self.typed.pop_front();
        }
        self.board.run_until(end, &mut self.world);
        for wheel in &mut self.world.wheels {
            wheel.angle_rad += wheel.rate_rad_s * ns as f64 / 1e9;
        }
        self.sent.extend(self.board.sent());
    }

    /// Characters come in without pauses, from now on or when those before them are through.
    pub(crate) fn enter(&mut self, bytes: impl AsRef<[u8]>, baud: u32) {
        let length = 10_000_000_000 / u64::from(baud) + 1;
        let free = self.typed.back().map_or(0, |typed| typed.0 + length);
        let mut start = free.max(self.board.now_ns());
        for &byte in bytes.as_ref() {
            self.typed.push_back((start, byte, baud));
            start += length;
        }
    }

    /// The bytes since the last call.
    pub(crate) fn bytes(&mut self) -> Vec<u8> {
        let new = &self.sent[self.read..];
        self.read = self.sent.len();
        new.iter().map(|sent| sent.frame.data() as u8).collect()
    }

    pub(crate) fn text(&mut self) -> String {
        String::from_utf8(self.bytes()).unwrap()
    }

    /// The whole lines of what came since it was last asked, each with the instant at which its first character began.
    pub(crate) fn lines(&mut self) -> Vec<(u64, String)> {
        let mut lines = Vec::new();
        let mut from = self.read;
        for at in self.read..self.sent.len() {
            if self.sent[at].frame.data() == u16::from(b'\n') {
                let line: Vec<u8> = self.sent[from..at].iter().map(|sent| sent.frame.data() as u8).collect();
                lines.push((self.sent[from].start_ns, String::from_utf8(line).unwrap().trim_end().into()));
                from = at + 1;
            }
        }
        self.read = from;
        lines
    }

    /// The instants at which the first light changes within a time, in nanoseconds. At most one change is in a millisecond.
    pub(crate) fn light_edges(&mut self, ms: u64) -> Vec<u64> {
        let mut edges = Vec::new();
        let mut lit = self.brightness(0) > 0.5;
        for _ in 0..ms {
            let start = self.board.now_ns();
            self.run(1);
            let share = (self.brightness(0) * MS as f64).round() as u64;
            let now = if lit { share == MS } else { share > 0 };
            if now != lit {
                edges.push(if lit { start + share } else { start + MS - share });
            }
            lit = now;
        }
        edges
    }

    pub(crate) fn brightness(&self, light: usize) -> f64 {
        self.board.lights().nth(light).unwrap().brightness
    }

    pub(crate) fn duties(&self) -> Vec<f64> {
        let duty = |drive| match drive {
            MotorDrive::Drive { duty, .. } => duty,
            MotorDrive::Brake | MotorDrive::Coast => 0.0,
        };
        self.board.drives().map(|motor| duty(motor.drive)).collect()
    }

    pub(crate) fn assert_no_warnings(&self) {
        assert_eq!(self.board.warnings(), [], "a sane program has no warnings");
    }
}
