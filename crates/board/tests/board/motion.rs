//! A program's acts on its pins arrive at motors, servos, lamps and buzzers.

use baudbot_board::{BridgeKind, Decay, Kind, Led, LitBy, MotorDrive, Piezo, ServoKind, WarningKind, Wiring};

use crate::board::asm::{Asm, data, io};
use crate::board::world::{MS, World, board, board_with_file};

const MOTOR: Kind = Kind::Bridge(BridgeKind::Directed { decay: Decay::Brake, drop_v: 0.1 });

fn duty(drive: MotorDrive) -> f64 {
    match drive {
        MotorDrive::Drive { duty, .. } => duty,
        MotorDrive::Brake | MotorDrive::Coast => 0.0,
    }
}

#[test]
fn the_duty_of_a_timer_reaches_the_bridge_exactly() {
    let mut program = Asm::new();
    // Fast PWM on OC0A, which is high for OCR0A + 1 of 256 counts; the direction is low.
    program
        .sbi(io::DDRD, 6)
        .sbi(io::DDRD, 7)
        .store(data::OCR0A, 63)
        .store(data::TCCR0A, 0x83)
        .store(data::TCCR0B, 3)
        .stay();
    let wiring =
        Wiring::builder().part("left", MOTOR).connect("6", "left.pwm").connect("7", "left.direction");
    let mut board = board(&program, wiring);
    let mut world = World::default();
    assert_eq!(
        board.drives().map(|motor| motor.drive).collect::<Vec<_>>(),
        [MotorDrive::Coast],
        "before the first step"
    );
    board.run_until(MS, &mut world);
    for step in 2..20 {
        board.run_until(step * MS, &mut world);
        let motor = board.drives().next().unwrap();
        assert_eq!(motor.drive, MotorDrive::Drive { duty: -0.25, decay: Decay::Brake });
        assert_eq!(motor.drop_v, 0.1);
    }
}

#[test]
fn software_pwm_is_its_mean_over_the_step() {
    let mut program = Asm::new();
    program.sbi(io::DDRC, 0).sbi(io::DDRC, 1).sbi(io::PORTC, 1);
    let period = program.here();
    // High for 397 + 1 + 2 cycles of 1602: SBI 2, delay 397, NOP 1, CBI 2, delay 1197, NOP 1, RJMP 2.
    program.sbi(io::PORTC, 0).delay(99).nop().cbi(io::PORTC, 0).delay(299).nop().rjmp(period);
    let wiring =
        Wiring::builder().part("left", MOTOR).connect("A0", "left.pwm").connect("A1", "left.direction");
    let mut board = board(&program, wiring);
    let mut world = World::default();
    board.run_until(MS, &mut world);
    for step in 2..10 {
        board.run_until(step * 10 * MS, &mut world);
        let duty = duty(board.drives().next().unwrap().drive);
        assert!((duty - 400.0 / 1602.0).abs() < 0.003, "{duty}");
    }
}

#[test]
fn motors_a_servo_and_a_tone_of_a_program_in_c_are_what_it_set() {
    let wiring = Wiring::builder()
        .part("left", MOTOR)
        .part("right", Kind::Bridge(BridgeKind::L298N))
        .part("arm", Kind::Servo(ServoKind::Standard))
        .part("buzzer", Kind::Piezo(Piezo))
        .connect("6", "left.pwm")
        .connect("VCC", "left.direction")
        .connect("5", "right.enable")
        .connect("VCC", "right.in1")
        .connect("GND", "right.in2")
        .connect("9", "arm")
        .connect("3", "buzzer");
    let mut board = board_with_file("pwm.hex", wiring);
    let mut world = World::default();
    for step in 1..=100 {
        board.run_until(step * MS, &mut world);
    }
    let drives: Vec<MotorDrive> = board.drives().map(|motor| motor.drive).collect();
    assert_eq!(
        drives,
        [
            MotorDrive::Drive { duty: 0.25, decay: Decay::Brake },
            MotorDrive::Drive { duty: 0.75, decay: Decay::Coast }
        ]
    );
    let pulse = board.servos().next().unwrap().pulse.unwrap();
    assert_eq!(pulse.width_ns, 1_500_000);
    assert!(pulse.at_ns > 75 * MS && pulse.at_ns <= 100 * MS);
    let hz = board.tones().next().unwrap().hz.unwrap();
    assert_eq!(hz, 16e6 / (2.0 * 142.0 * 128.0));
    // Until the program has set ICR1 the timer makes a short pulse.
    let kinds: Vec<WarningKind> = board.warnings().iter().map(|warning| warning.kind).collect();
    assert_eq!(kinds, [WarningKind::OddServoPulse]);
}

#[test]
fn a_servo_hears_the_pulses_of_a_program_that_waits() {
    let mut program = Asm::new();
    program.sbi(io::DDRB, 4);
    let again = program.here();
    // The pulse from the end of SBI to the end of CBI: 4 * 5999 + 1 + 1 + 2 cycles are 1500 µs.
    program.sbi(io::PORTB, 4).delay(5999).nop().cbi(io::PORTB, 4).delay(60_000).rjmp(again);
    let wiring = Wiring::builder().part("wheel", Kind::Servo(ServoKind::Continuous)).connect("12", "wheel");
    let mut board = board(&program, wiring);
    board.run_until(50 * MS, &mut World::default());
    let pulse = board.servos().next().unwrap().pulse.unwrap();
    assert_eq!((pulse.width_ns, pulse.speed()), (1_500_000, 0.0));
    // Three pulses and two pauses from the first instruction on.
    assert_eq!(pulse.at_ns, (20 + 2 + 2 + 3 * 24_000 + 2 * (240_001 + 2 + 2)) * 1000 / 16);
}

#[test]
fn lamps_are_as_bright_as_their_share_of_time() {
    let mut program = Asm::new();
    program.sbi(io::DDRD, 6).store(data::OCR0A, 63).store(data::TCCR0A, 0x83).store(data::TCCR0B, 3);
    program.sbi(io::DDRB, 5).sbi(io::PORTB, 5).stay();
    let led = |lit_by| Kind::Led(Led { lit_by });
    let wiring = Wiring::builder()
        .part("high", led(LitBy::High))
        .part("low", led(LitBy::Low))
        .part("steady", led(LitBy::High))
        .part("unused", led(LitBy::Low))
        .connect("6", "high")
        .connect("6", "low")
        .connect("13", "steady")
        .connect("12", "unused");
    let mut board = board(&program, wiring);
    board.run_until(MS, &mut World::default());
    board.run_until(2 * MS, &mut World::default());
    assert_eq!(board.lights().map(|light| light.brightness).collect::<Vec<_>>(), [0.25, 0.75, 1.0, 0.0]);
}

#[test]
fn a_tone_by_edges_has_their_frequency_and_ends_50_ms_after_the_last() {
    let mut program = Asm::new();
    program.sbi(io::DDRB, 0);
    // 64 edges.
    program.ldi(20, 0);
    let again = program.here();
    program.sbi(io::PINB, 0).delay(1999).inc(20).sbrs(20, 6).rjmp(again).stay();
    let wiring = Wiring::builder().part("buzzer", Kind::Piezo(Piezo)).connect("8", "buzzer");
    let mut board = board(&program, wiring);
    let mut world = World::default();
    board.run_until(20 * MS, &mut world);
    let hz = board.tones().next().unwrap().hz.unwrap();
    // SBI 2, delay 7997, INC 1, SBRS 1, RJMP 2.
    assert_eq!(hz, 16e6 / (2.0 * 8003.0));
    board.run_until(81 * MS, &mut world);
    assert!(board.tones().next().unwrap().hz.is_some(), "the last edge was less than 50 ms ago");
    board.run_until(82 * MS, &mut world);
    assert_eq!(board.tones().next().unwrap().hz, None);
}
