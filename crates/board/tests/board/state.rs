//! A board is a value: it can be copied, stored, and goes on in the same way.

use std::f64::consts::TAU;

use baudbot_avr::{Chip, Fuses, Part, Program, Supply};
use baudbot_board::{
    Board, BoardError, Channels, ChipClock, Encoder, Kind, Led, LitBy, Next, Piezo, Ping, Pull, Switch,
    Wheel, Wiring,
};

use crate::board::asm::{Asm, data, io};
use crate::board::world::{MS, World, board, board_with_file, register};

/// Triggers again and again, and writes the level of the sensor's pin to another.
pub(crate) fn restless() -> Board {
    let mut program = Asm::new();
    program.sbi(io::DDRD, 4);
    let again = program.here();
    program.sbi(io::DDRB, 0).sbi(io::PORTB, 0).delay(20).cbi(io::PORTB, 0).cbi(io::DDRB, 0).delay(4000);
    let high = program.here();
    program.sbic(io::PINB, 0).rjmp(high).sbi(io::PIND, 4).rjmp(again);
    let encoder = Encoder { channels: Channels::Quadrature, counts_per_turn: 500 };
    let wiring = Wiring::builder()
        .part("ping", Kind::Ping(Ping))
        .part("wheel", Kind::Encoder(encoder))
        .part("whisker", Kind::Switch(Switch { pull: Pull::External, bounce_us: 900, seed: 3 }))
        .part("buzzer", Kind::Piezo(Piezo))
        .connect("8", "ping")
        .connect("2", "wheel.a")
        .connect("3", "wheel.b")
        .connect("7", "whisker")
        .connect("4", "buzzer");
    board(&program, wiring)
}

pub(crate) fn world_at(step: u64) -> World {
    let wheel = Wheel { angle_rad: TAU * step as f64 / 50.0, rate_rad_s: TAU * 20.0 };
    World { echo_ns: Some(3_333_333 + 1000 * step), pressed: step / 3 % 2 == 1, wheel, ..World::default() }
}

#[test]
fn a_clone_and_a_stored_board_go_on_alike_from_the_middle_of_an_echo() {
    let mut whole = restless();
    let mut stored = whole.clone();
    for step in 0..60 {
        let until = (step + 1) * MS;
        whole.run_until(until, &mut world_at(step));
        stored.run_until(until, &mut world_at(step));
        assert!(whole == stored, "step {step}");
        stored = postcard::from_bytes(&postcard::to_allocvec(&stored).unwrap()).unwrap();
        assert!(whole == stored, "stored after step {step}");
    }
    let copy = whole.clone();
    whole.run_until(70 * MS, &mut World::default());
    assert!(whole != copy);
}

#[test]
fn a_board_that_sleeps_says_when_something_will_happen() {
    let mut program = Asm::new();
    // Power-down.
    program.ldi(16, 5).out(io::SMCR, 16).sleep().stay();
    let mut board = board(&program, Wiring::builder());
    assert!(matches!(board.next_event_ns(), Next::At(_)), "held in reset");
    board.run_until(MS, &mut World::default());
    assert_eq!(board.next_event_ns(), Next::Never);
    let awake = board_with_file("sleep.hex", Wiring::builder());
    assert!(matches!(awake.next_event_ns(), Next::At(_)));
}

#[test]
fn an_echo_that_comes_wakes_a_board() {
    let mut program = Asm::new();
    program.sbi(io::DDRB, 0).sbi(io::PORTB, 0).delay(20).cbi(io::PORTB, 0).cbi(io::DDRB, 0);
    program.store(data::PCMSK2, 0).ldi(16, 5).out(io::SMCR, 16).sleep().stay();
    let wiring = Wiring::builder().part("ping", Kind::Ping(Ping)).connect("8", "ping");
    let mut board = board(&program, wiring);
    let mut world = World { echo_ns: Some(MS), ..World::default() };
    board.run_until(MS / 10, &mut world);
    let Next::At(begin) = board.next_event_ns() else { panic!("the echo comes") };
    assert!(begin > 750_000 && begin < 770_000, "{begin}");
    board.run_until(begin + 1000, &mut world);
    let Next::At(end) = board.next_event_ns() else { panic!("the echo ends") };
    assert!(end.abs_diff(begin + MS) <= 62);
    board.run_until(3 * MS, &mut world);
    assert_eq!(board.next_event_ns(), Next::Never);
}

#[test]
fn chip_and_clock_must_have_one_frequency() {
    let program = Program::from_words(Part::Atmega328P, &[0xCFFF]).unwrap();
    let chip = Chip::new(&program, Fuses::external_clock(Part::Atmega328P), Supply::ARDUINO);
    let board = Board::new(chip, ChipClock::exact(8_000_000).unwrap(), Wiring::default());
    assert_eq!(board.unwrap_err(), BoardError::OtherFrequency { chip: 16_000_000, clock: 8_000_000 });
}

#[test]
fn a_clock_that_is_too_fast_makes_more_cycles() {
    let program = Program::from_words(Part::Atmega328P, &[0xCFFF]).unwrap();
    let chip = Chip::new(&program, Fuses::external_clock(Part::Atmega328P), Supply::ARDUINO);
    let clock = ChipClock::exact(16_000_000).unwrap().with_ppm(1000).unwrap();
    let mut board = Board::new(chip, clock, Wiring::default()).unwrap();
    for step in 1..=100 {
        board.run_until(step * MS, &mut World::default());
    }
    assert!(board.chip().now().abs_diff(1_601_600) <= 2);
}

#[test]
fn a_reset_starts_the_program_again_and_lets_go_of_the_pins() {
    let mut program = Asm::new();
    program.lds(20, data::MCUSR).sbi(io::DDRB, 0).sbi(io::PORTB, 0).stay();
    let led = Kind::Led(Led { lit_by: LitBy::High });
    let mut board = board(&program, Wiring::builder().part("led", led).connect("8", "led"));
    let mut world = World::default();
    board.run_until(MS, &mut world);
    board.run_until(2 * MS, &mut world);
    assert_eq!((board.lights().next().unwrap().brightness, register(&board, 20)), (1.0, 1));
    board.reset();
    board.run_until(3 * MS, &mut world);
    // Start-up and reset take 20 cycles, the program before its LED 6.
    let lit = board.lights().next().unwrap().brightness;
    assert!((lit - (1.0 - 26.0 / 16_000.0)).abs() < 3.0 / 16_000.0, "{lit}");
    assert_eq!(register(&board, 20), 3, "power-on and the pin");
    assert_eq!(board.warnings(), []);
}
