//! Warnings name the pin and the part.

use baudbot_avr::usart::Frame;
use baudbot_avr::{Pin, Port};
use baudbot_board::{Board, Kind, Pull, ServoKind, Switch, Voltage, WarningKind, Wiring};

use crate::board::asm::{Asm, data, io};
use crate::board::world::{MS, World, board, board_with_file};

const BUTTON: Kind = Kind::Switch(Switch { pull: Pull::Internal, bounce_us: 0, seed: 0 });

/// The warnings: kind, pin, name of the part.
fn told(board: &Board) -> Vec<(WarningKind, Option<Pin>, &str)> {
    let name = |part| board.wiring().name(part);
    board
        .warnings()
        .iter()
        .map(|warning| (warning.kind, warning.pin, warning.part.map_or("", name)))
        .collect()
}

#[test]
fn a_button_without_its_pull_up_floats_and_with_it_does_not() {
    for (pull_up, expected) in [(false, 1), (true, 0)] {
        let mut program = Asm::new();
        if pull_up {
            program.sbi(io::PORTD, 4);
        }
        let again = program.here();
        program.sbic(io::PIND, 4).nop().rjmp(again);
        let mut board = board(&program, Wiring::builder().part("button", BUTTON).connect("4", "button"));
        board.run_until(MS, &mut World::default());
        let warning = (WarningKind::FloatingInput, Pin::new(Port::D, 4), "button");
        assert_eq!(told(&board), vec![warning; expected]);
    }
}

#[test]
fn an_output_against_a_pressed_button_is_a_short() {
    let mut program = Asm::new();
    program.sbi(io::DDRD, 4).sbi(io::PORTD, 4).stay();
    let mut board = board(&program, Wiring::builder().part("button", BUTTON).connect("4", "button"));
    board.run_until(MS, &mut World::default());
    assert_eq!(told(&board), []);
    board.run_until(2 * MS, &mut World { pressed: true, ..World::default() });
    assert_eq!(told(&board), [(WarningKind::Short, Pin::new(Port::D, 4), "button")]);
    assert_eq!(board.warnings()[0].count, 1);
}

#[test]
fn an_output_that_is_low_against_a_pull_up_resistor_is_none() {
    let button = Kind::Switch(Switch { pull: Pull::External, bounce_us: 0, seed: 0 });
    let mut program = Asm::new();
    program.sbi(io::DDRD, 4).delay(20_000).sbi(io::PORTD, 4).stay();
    let mut board = board(&program, Wiring::builder().part("button", button).connect("4", "button"));
    let mut world = World::default();
    for step in 1..=2 {
        board.run_until(step * MS, &mut world);
        world.pressed = !world.pressed;
    }
    assert_eq!(told(&board), [], "low, and the button first open, then pressed");
    world.pressed = true;
    board.run_until(10 * MS, &mut world);
    assert_eq!(told(&board), [(WarningKind::Short, Pin::new(Port::D, 4), "button")]);
}

#[test]
fn an_adc_input_without_anything_is_told_and_a_digital_signal_can_be_measured() {
    let mut program = Asm::new();
    program.sbi(io::PORTC, 2).store(data::ADMUX, 0x42).store(data::ADCSRA, 0xC7).delay(2000);
    program.lds(20, data::ADCL).lds(21, data::ADCH);
    program.store(data::ADMUX, 0x41).store(data::ADCSRA, 0xC7).stay();
    let mut board = board(&program, Wiring::builder());
    board.run_until(2 * MS, &mut World::default());
    assert_eq!(told(&board), [(WarningKind::OpenAdcInput, Pin::new(Port::C, 1), "")]);
    assert_eq!(crate::board::world::pair(&board, 20), 1023, "the pull-up resistor");
}

#[test]
fn a_voltage_that_is_read_as_a_digital_input_is_told() {
    let mut program = Asm::new();
    program.sbic(io::PINC, 0).nop().stay();
    let wiring = Wiring::builder().part("ir", Kind::Voltage(Voltage::DIRECT)).connect("A0", "ir");
    let mut board = board(&program, wiring);
    board.run_until(MS, &mut World::default());
    assert_eq!(told(&board), [(WarningKind::DigitalReadOfVoltage, Pin::new(Port::C, 0), "ir")]);
}

#[test]
fn a_port_that_is_read_for_one_floating_button_is_told_by_that() {
    let two = || {
        let wiring = Wiring::builder().part("left", BUTTON).part("right", BUTTON);
        wiring.connect("4", "left").connect("5", "right")
    };
    // in r24, PIND; andi r24, mask
    for (mask, expected) in
        [(0x7280, vec![(WarningKind::FloatingInput, Pin::new(Port::D, 5), "right")]), (0x7380, vec![])]
    {
        let mut program = Asm::new();
        program.word(0xB189).word(mask).stay();
        let mut board = board(&program, two());
        board.run_until(MS, &mut World::default());
        assert_eq!(told(&board), expected, "{mask:x}");
    }
}

#[test]
fn an_output_against_a_voltage_is_told_once_each_time_it_becomes_one() {
    let wiring = || Wiring::builder().part("ir", Kind::Voltage(Voltage::DIRECT)).connect("A0", "ir");
    let warning = (WarningKind::AgainstVoltage, Pin::new(Port::C, 0), "ir");
    let mut program = Asm::new();
    program.sbi(io::DDRC, 0).sbi(io::PORTC, 0).cbi(io::PORTC, 0).cbi(io::DDRC, 0).delay(100);
    program.sbi(io::DDRC, 0).stay();
    let mut driven = board(&program, wiring());
    driven.run_until(MS, &mut World { volts: 1.5, ..World::default() });
    assert_eq!(told(&driven), [warning]);
    assert_eq!(driven.warnings()[0].count, 2);
    let mut pulled_up = Asm::new();
    pulled_up.sbi(io::PORTC, 0).sbi(io::DDRC, 1).stay();
    let mut pulled_up = board(&pulled_up, wiring());
    pulled_up.run_until(MS, &mut World { volts: 1.5, ..World::default() });
    assert_eq!(told(&pulled_up), [], "a resistor, and another pin");
}

#[test]
fn a_character_for_a_program_without_a_uart_is_told() {
    let mut board = board_with_file("blink.hex", Wiring::builder());
    board.run_until(MS, &mut World::default());
    for at in 1..=3 {
        board.receive(Frame::byte(0), at * 2 * MS, 9600).unwrap();
    }
    assert_eq!(told(&board), [(WarningKind::ReceiverOff, None, "")]);
    assert_eq!(board.warnings()[0].count, 3);
}

#[test]
fn resets_by_the_watchdog_and_illegal_words_are_counted() {
    let mut program = Asm::new();
    // Reset after 16 ms.
    program.ldi(16, 0x18).ldi(17, 0x08).sts(data::WDTCSR, 16).sts(data::WDTCSR, 17).word(0xFFFF).stay();
    let mut board = board(&program, Wiring::builder());
    for step in 1..=50 {
        board.run_until(step * MS, &mut World::default());
    }
    assert_eq!(
        told(&board),
        [(WarningKind::IllegalInstruction, None, ""), (WarningKind::WatchdogReset, None, "")]
    );
    assert_eq!(board.warnings().iter().map(|warning| warning.count).collect::<Vec<_>>(), [4, 3]);
    // The reset is noticed a millisecond later at most.
    assert!((16 * MS..=17 * MS + 1000).contains(&board.warnings()[1].first_ns));
}

#[test]
fn a_stack_that_grows_below_the_memory_is_told() {
    let mut program = Asm::new();
    // push r0; rjmp .-4
    program.word(0x920F).rjmp(0);
    let mut board = board(&program, Wiring::builder());
    board.run_until(MS, &mut World::default());
    assert!(told(&board).iter().any(|(kind, ..)| *kind == WarningKind::StackOverflow), "{:?}", told(&board));
}

#[test]
fn a_pulse_that_no_servo_obeys_is_told() {
    let mut program = Asm::new();
    program.sbi(io::DDRB, 1).sbi(io::PORTB, 1).delay(100).cbi(io::PORTB, 1).stay();
    let wiring = Wiring::builder().part("arm", Kind::Servo(ServoKind::Standard)).connect("9", "arm");
    let mut board = board(&program, wiring);
    board.run_until(MS, &mut World::default());
    assert_eq!(told(&board), [(WarningKind::OddServoPulse, Pin::new(Port::B, 1), "arm")]);
    assert_eq!(board.servos().next().unwrap().pulse, None);
}
