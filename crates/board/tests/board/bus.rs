//! Parts on the I²C bus.

use baudbot_board::{Compass, Kind, RangeFinder, Wiring};

use crate::board::asm::{Asm, data};
use crate::board::world::{MS, World, board, pair, register};

const COMPASS: u8 = 0x1E << 1;
const SRF02: u8 = 0xE0;

/// Reads bytes from a register on into registers of the processor.
fn read(program: &mut Asm, address: u8, from: u8, into: &[u16]) {
    program.twi_start().twi_send(address).twi_send(from).twi_start().twi_send(address | 1);
    for (place, &register) in into.iter().enumerate() {
        program.twi_read(register, place + 1 < into.len());
    }
    program.twi_stop();
}

fn compass(program: &Asm) -> baudbot_board::Board {
    let wiring = Wiring::builder().part("compass", Kind::Compass(Compass));
    board(program, wiring.connect("A4", "compass.sda").connect("A5", "compass.scl"))
}

#[test]
fn a_compass_says_its_name_and_measures_in_counts_of_its_gain() {
    let mut program = Asm::new();
    program.store(data::TWBR, 12);
    read(&mut program, COMPASS, 10, &[2, 3, 4]);
    // Continuous measurements.
    program.twi_start().twi_send(COMPASS).twi_send(2).twi_send(0).twi_stop();
    program.delay(60_000);
    read(&mut program, COMPASS, 3, &[5, 6, 7, 8, 9, 10]);
    read(&mut program, COMPASS, 9, &[11]);
    program.stay();
    let mut board = compass(&program);
    for step in 1..=40 {
        board.run_until(step * MS, &mut World { gauss: [0.3, -0.2, 9.0], ..World::default() });
    }
    assert_eq!([2, 3, 4].map(|at| register(&board, at)), *b"H43");
    let value = |at: usize| pair(&board, at).swap_bytes() as i16;
    // X, Z, Y; 1090 counts per gauss at the gain after the supply is switched on, and -4096 where that does not fit.
    assert_eq!([5, 7, 9].map(value), [327, -4096, -218]);
    assert_eq!(register(&board, 11), 0, "what was read is not ready again at once");
}

#[test]
fn a_single_measurement_takes_6_ms_and_then_the_compass_is_idle() {
    let mut program = Asm::new();
    program.store(data::TWBR, 12).twi_start().twi_send(COMPASS).twi_send(2).twi_send(1).twi_stop();
    let wait = program.here();
    program.adiw24(1);
    read(&mut program, COMPASS, 9, &[11]);
    program.sbrs(11, 0).rjmp(wait);
    read(&mut program, COMPASS, 2, &[12]);
    program.ldi(18, 1).stay();
    let mut board = compass(&program);
    board.run_until(6 * MS, &mut World::default());
    assert_eq!(register(&board, 18), 0);
    board.run_until(7 * MS, &mut World::default());
    assert_eq!((register(&board, 18), register(&board, 12)), (1, 3));
}

#[test]
fn an_srf02_is_silent_for_65_ms_and_then_has_the_range_in_centimetres() {
    let mut program = Asm::new();
    program.store(data::TWBR, 12).twi_start().twi_send(SRF02).twi_send(0).twi_send(0x51).twi_stop();
    program.twi_start().twi_send(SRF02).lds(20, data::TWSR).twi_stop();
    let wait = program.here();
    program.twi_start().twi_send(SRF02).lds(21, data::TWSR).twi_stop().sbrs(21, 3).rjmp(wait);
    read(&mut program, SRF02, 0, &[2, 3, 5, 4]);
    program.ldi(18, 1).stay();
    let wiring = Wiring::builder().part("range", Kind::RangeFinder(RangeFinder::SRF02));
    let mut board = board(&program, wiring.connect("A4", "range.sda").connect("A5", "range.scl"));
    let mut world = World { echo_ns: Some(123 * 58_000), ..World::default() };
    board.run_until(65 * MS, &mut world);
    assert_eq!((register(&board, 18), register(&board, 20)), (0, 0x20), "no acknowledgement");
    board.run_until(66 * MS, &mut world);
    assert_eq!(register(&board, 18), 1);
    assert_eq!(([register(&board, 2), register(&board, 3)], pair(&board, 4)), ([6, 0x80], 123));
    assert_eq!(world.echoes.len(), 1);
}

#[test]
fn an_address_without_a_part_is_not_acknowledged() {
    let mut program = Asm::new();
    program.store(data::TWBR, 12).twi_start().twi_send(0xD0).lds(20, data::TWSR).stay();
    let mut board = compass(&program);
    board.run_until(MS, &mut World::default());
    assert_eq!(register(&board, 20), 0x20);
}
