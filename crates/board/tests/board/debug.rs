//! A debugger at the chip.

use baudbot_avr::{Chip, Port, Stop};
use baudbot_board::{Board, Debugger, Kind, Led, LitBy, Wiring};

use crate::board::asm::{Asm, io};
use crate::board::state::{restless, world_at};
use crate::board::world::{MS, World, board};

/// Stops at each so manieth instruction, and notes where.
struct Every {
    every: u64,
    asked: u64,
    stops: Vec<(u32, u64)>,
}

impl Debugger for Every {
    fn stops(&mut self, _chip: &Chip) -> bool {
        self.asked += 1;
        self.asked.is_multiple_of(self.every)
    }

    fn stopped(&mut self, board: &mut Board, why: Stop) {
        assert_eq!(why, Stop::Breakpoint);
        self.stops.push((board.chip().pc(), board.chip().now()));
    }
}

#[test]
fn a_board_that_is_stopped_again_and_again_does_the_same_to_the_last_bit() {
    let (mut free, mut stopped) = (restless(), restless());
    let mut debugger = Every { every: 7, asked: 0, stops: Vec::new() };
    for step in 0..30 {
        let until = (step + 1) * MS;
        free.run_until(until, &mut world_at(step));
        stopped.debug_until(until, &mut world_at(step), &mut debugger);
        assert!(free == stopped, "step {step}");
    }
    let stops = &debugger.stops;
    assert!(stops.len() > 10_000, "{} stops", stops.len());
    assert!(stops.windows(2).all(|pair| pair[0].1 < pair[1].1), "time goes on between two stops");
}

#[test]
fn break_stops_behind_it_and_the_chip_goes_on() {
    /// Counts stops behind `BREAK`.
    struct Breaks(Vec<u32>);

    impl Debugger for Breaks {
        fn stops(&mut self, _chip: &Chip) -> bool {
            false
        }

        fn stopped(&mut self, board: &mut Board, why: Stop) {
            assert_eq!(why, Stop::Break);
            self.0.push(board.chip().pc());
        }
    }

    let mut program = Asm::new();
    program.words.extend([0x0000, 0x9598, 0x0000, 0xCFFF]);
    let mut board = board(&program, Wiring::builder());
    let mut breaks = Breaks(Vec::new());
    board.debug_until(2 * MS, &mut World::default(), &mut breaks);
    assert_eq!((breaks.0, board.chip().pc()), (vec![2], 3));
}

#[test]
fn parts_feel_what_a_debugger_writes_to_a_port() {
    let mut program = Asm::new();
    program.words.push(0xCFFF);
    let wiring =
        Wiring::builder().part("light", Kind::Led(Led { lit_by: LitBy::High })).connect("13", "light");
    let mut board = board(&program, wiring);
    board.run_until(MS, &mut World::default());
    for register in [io::DDRB, io::PORTB] {
        board.write_data(register + 0x20, 1 << 5);
    }
    board.run_until(2 * MS, &mut World::default());
    let brightness: Vec<f64> = board.lights().map(|light| light.brightness).collect();
    assert_eq!(brightness, [1.0]);
    assert!(board.chip().level(baudbot_avr::Pin::new(Port::B, 5).unwrap()));
}
