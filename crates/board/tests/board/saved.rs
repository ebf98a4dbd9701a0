//! Boards that are loaded: what was saved is, and what was damaged is refused or harmless.

use std::f64::consts::TAU;

use baudbot_avr::usart::Frame;
use baudbot_board::{
    Board, BridgeKind, Builder, Channels, ChipClock, Compass, Encoder, HcSr04, Kind, Led, LitBy, Piezo, Ping,
    Pull, RangeFinder, Reflectance, ServoKind, Switch, Voltage, Wheel, Wiring,
};
use proptest::prelude::*;

use crate::board::asm::Asm;
use crate::board::world::{MS, World, board};

/// One part of each kind.
fn all_parts() -> Builder {
    let encoder = Encoder { channels: Channels::Quadrature, counts_per_turn: 500 };
    Wiring::builder()
        .part("light", Kind::Voltage(Voltage { ratio: 0.5 }))
        .part("line", Kind::Reflectance(Reflectance))
        .part("whisker", Kind::Switch(Switch { pull: Pull::External, bounce_us: 900, seed: 3 }))
        .part("wheel", Kind::Encoder(encoder))
        .part("ping", Kind::Ping(Ping))
        .part("sonar", Kind::HcSr04(HcSr04))
        .part("motor", Kind::Bridge(BridgeKind::TB6612))
        .part("servo", Kind::Servo(ServoKind::Standard))
        .part("led", Kind::Led(Led { lit_by: LitBy::Low }))
        .part("buzzer", Kind::Piezo(Piezo))
        .part("compass", Kind::Compass(Compass))
        .part("finder", Kind::RangeFinder(RangeFinder::SRF02))
        .connect("A0", "light")
        .connect("A1", "line")
        .connect("7", "whisker")
        .connect("2", "wheel.a")
        .connect("4", "wheel.b")
        .connect("8", "ping")
        .connect("12", "sonar.trigger")
        .connect("A2", "sonar.echo")
        .connect("A3", "motor.in1")
        .connect("GND", "motor.in2")
        .connect("6", "motor.pwm")
        .connect("5V", "motor.standby")
        .connect("9", "servo")
        .connect("13", "led")
        .connect("3", "buzzer")
        .connect("A4", "compass.sda")
        .connect("A5", "compass.scl")
        .connect("A4", "finder.sda")
        .connect("A5", "finder.scl")
}

/// A program that writes values to registers one after another, again and again, with a pause behind each.
fn program(writes: &[(u8, u8)]) -> Asm {
    let mut program = Asm::new();
    // All motors, lamps and sounds are outputs.
    program.store(0x24, 0xFF).store(0x27, 0x0A).store(0x2A, 0x48);
    let again = program.here();
    for &(register, value) in writes {
        program.store(0x20 + u16::from(register % 0xA8), value).delay(40);
    }
    program.rjmp(again);
    program
}

fn world_at(step: u64) -> World {
    World {
        volts: 1.5,
        discharge_ns: 300_000,
        pressed: step / 3 % 2 == 1,
        wheel: Wheel { angle_rad: TAU * step as f64 / 50.0, rate_rad_s: TAU * 20.0 },
        echo_ns: Some(3_333_333 + 1000 * step),
        gauss: [0.2, -0.1, 0.4],
        ..World::default()
    }
}

fn step(board: &mut Board, step: u64) {
    let _ = board.receive(Frame::byte(step as u8), step * MS, 115_200);
    board.run_until((step + 1) * MS, &mut world_at(step));
}

fn stored(board: &Board) -> Vec<u8> {
    postcard::to_allocvec(board).unwrap()
}

/// Places in a saved board that are not in the middle of an empty memory.
fn outside_memories(bytes: &[u8]) -> Vec<usize> {
    (8..bytes.len() - 8).filter(|&at| bytes[at - 8..at + 8].iter().any(|&byte| byte != bytes[at])).collect()
}

/// Timers with signals for motor, servo and buzzer, a USART that sends, a trigger for the sonars, TWI that talks with the
/// compass, and the ADC.
const BUSY: [(u8, u8); 24] = [
    (0x24, 0xA3),
    (0x25, 0x02),
    (0x27, 99),
    (0x60, 0xA2),
    (0x61, 0x1A),
    (0x66, 0x40),
    (0x67, 0x9C),
    (0x90, 0x23),
    (0x91, 0x0A),
    (0x93, 141),
    (0xA1, 0x18),
    (0xA4, 8),
    (0xA6, 0x55),
    (0x05, 0x11),
    (0x05, 0x00),
    (0x5C, 0x40),
    (0x5A, 0xC3),
    (0x9C, 0xA4),
    (0x9B, 0x3C),
    (0x9C, 0x84),
    (0x9B, 2),
    (0x9C, 0x84),
    (0x9B, 0),
    (0x9C, 0x84),
];

#[test]
fn a_board_with_each_part_is_loaded_at_each_step_and_goes_on_alike() {
    let mut whole = board(&program(&BUSY), all_parts());
    let mut copy = whole.clone();
    for at in 0..120 {
        step(&mut whole, at);
        step(&mut copy, at);
        copy = postcard::from_bytes(&stored(&copy)).unwrap_or_else(|error| panic!("step {at}: {error}"));
        assert!(whole == copy, "step {at}");
    }
}

#[test]
fn a_board_is_of_its_own_wiring_and_clock_only() {
    let board = board(&program(&BUSY), all_parts());
    let clock = ChipClock::exact(16_000_000).unwrap();
    assert!(board.is_of(&all_parts().build().unwrap(), &clock));
    assert!(!board.is_of(&all_parts().build().unwrap(), &clock.with_ppm(1).unwrap()));
    let more = all_parts().part("lamp", Kind::Led(Led { lit_by: LitBy::High })).connect("1", "lamp");
    assert!(!board.is_of(&more.build().unwrap(), &clock));
}

#[test]
fn clocks_and_wirings_that_cannot_exist_are_not_loaded() {
    let load =
        |hz: u32, ppb: i32| postcard::from_bytes::<ChipClock>(&postcard::to_allocvec(&(hz, ppb)).unwrap());
    assert!(load(16_000_000, 50_000).is_ok());
    assert!(load(0, 0).is_err() && load(16_000_000, 100_000_001).is_err());
    let bytes = postcard::to_allocvec(&all_parts().build().unwrap()).unwrap();
    assert!(postcard::from_bytes::<Wiring>(&bytes).is_ok());
    let mut refused = 0;
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1;
        refused += usize::from(postcard::from_bytes::<Wiring>(&damaged).is_err());
    }
    assert!(refused > 80, "{refused}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(
        std::env::var("BAUDBOT_FORGED").map_or(48, |cases| cases.parse().unwrap())
    ))]

    #[test]
    fn whatever_a_program_does_its_board_is_loaded_again(writes: Vec<(u8, u8)>) {
        let mut board = board(&program(&writes), all_parts());
        for at in 0..12 {
            step(&mut board, at);
            let loaded = postcard::from_bytes::<Board>(&stored(&board));
            prop_assert!(loaded.is_ok_and(|loaded| loaded == board), "step {}", at);
        }
    }

    #[test]
    fn a_damaged_board_is_refused_or_runs(
        steps in 0u64..90, changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let mut board = board(&program(&BUSY), all_parts());
        for at in 0..steps {
            step(&mut board, at);
        }
        let mut bytes = stored(&board);
        let places = outside_memories(&bytes);
        for (place, value) in changes {
            bytes[*place.get(&places)] = value;
        }
        if let Ok(mut forged) = postcard::from_bytes::<Board>(&bytes) {
            for at in steps..steps + 4 {
                step(&mut forged, at);
                let _ = (forged.next_event_ns(), forged.drives().count(), forged.servos().count());
                let _ = (forged.tones().count(), forged.lights().count(), forged.warnings().len());
            }
            forged.sent().for_each(drop);
        }
    }
}
