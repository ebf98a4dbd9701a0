//! The feelings of sensors arrive in the program.

use std::f64::consts::TAU;

use baudbot_board::{
    Channels, Encoder, HcSr04, Kind, Ping, Pull, Reflectance, Switch, Voltage, WarningKind, Wheel, Wiring,
};

use crate::board::asm::{Asm, data, io};
use crate::board::world::{MS, World, board, pair, register};

#[test]
fn the_adc_has_the_code_of_the_data_sheet_for_each_voltage() {
    let mut program = Asm::new();
    program.store(data::ADMUX, 0x40).store(data::ADCSRA, 0xC7);
    let wait = program.here();
    program.lds(16, data::ADCSRA).sbrc(16, 6).rjmp(wait).lds(24, data::ADCL).lds(25, data::ADCH).stay();
    for (volts, ratio) in
        [(0.0, 1.0), (1.234, 1.0), (2.5, 1.0), (4.999, 1.0), (7.2, 1.0), (7.2, 0.5), (-3.0, 1.0)]
    {
        let wiring = Wiring::builder().part("ir", Kind::Voltage(Voltage { ratio })).connect("A0", "ir");
        let mut board = board(&program, wiring);
        board.run_until(MS, &mut World { volts, ..World::default() });
        // ADC = Vin 1024 / Vref, 10 bits.
        let code = (volts * ratio * 1024.0 / 5.0).clamp(0.0, 1023.0) as u16;
        assert_eq!(pair(&board, 24), code, "{volts} V times {ratio}");
        assert_eq!(board.warnings(), []);
    }
}

/// Triggers a sensor on PB0 by a pulse of 4 `loops` + 3 cycles, then captures both edges of its answer with timer 1: the
/// end of the trigger in r20 and r21, the rise in r22 and r23, the fall in r24 and r25.
fn ping_program(loops: u16) -> Asm {
    let mut program = Asm::new();
    program.store(data::TCCR1B, 0x41).sbi(io::DDRB, 0).sbi(io::PORTB, 0).delay(loops).cbi(io::PORTB, 0);
    program.lds(20, data::TCNT1L).lds(21, data::TCNT1H).cbi(io::DDRB, 0).ldi(16, 0x20).out(io::TIFR1, 16);
    let rise = program.here();
    program.sbis(io::TIFR1, 5).rjmp(rise).lds(22, data::ICR1L).lds(23, data::ICR1H);
    program.store(data::TCCR1B, 0x01).ldi(16, 0x20).out(io::TIFR1, 16);
    let fall = program.here();
    program.sbis(io::TIFR1, 5).rjmp(fall).lds(24, data::ICR1L).lds(25, data::ICR1H).ldi(18, 1).stay();
    program
}

#[test]
fn a_ping_answers_after_750_us_by_a_pulse_as_long_as_the_echo_to_the_cycle() {
    let wiring = || Wiring::builder().part("ping", Kind::Ping(Ping)).connect("8", "ping");
    for (echo_ns, pulse_us) in
        [(Some(1_234_500), 1234.5), (Some(50_000), 115.0), (Some(18_499_000), 18_499.0), (None, 18_500.0)]
    {
        let mut board = board(&ping_program(20), wiring());
        let mut world = World { echo_ns, ..World::default() };
        board.run_until(25 * MS, &mut world);
        assert_eq!(register(&board, 18), 1, "the program has seen both edges");
        let [trigger, rise, fall] = [20, 22, 24].map(|low| pair(&board, low));
        // The counter is read one cycle behind the end of the trigger.
        assert_eq!(rise.wrapping_sub(trigger), 12_000 - 1);
        assert_eq!(u32::from(fall.wrapping_sub(rise)), (pulse_us * 16.0) as u32 % 0x1_0000);
        assert_eq!(world.echoes.len(), 1);
        assert_eq!(board.warnings(), []);
    }
}

/// A data sheet's minimum is what its maker promises: sensors obey less, and programs rely on it. NewPing makes pulses of 9.5 µs.
#[test]
fn a_trigger_shorter_than_promised_is_obeyed_and_told_and_one_far_too_short_does_nothing() {
    // Pulses of 4 `loops` + 3 cycles of 62.5 ns.
    for (loops, echoes, told) in
        [(3, 0, Some(WarningKind::ShortTrigger)), (5, 1, Some(WarningKind::WeakTrigger)), (8, 1, None)]
    {
        let wiring = Wiring::builder().part("ping", Kind::Ping(Ping)).connect("8", "ping");
        let mut board = board(&ping_program(loops), wiring);
        let mut world = World { echo_ns: Some(1_000_000), ..World::default() };
        board.run_until(25 * MS, &mut world);
        assert_eq!(world.echoes.len(), echoes, "PING: {loops} loops");
        let warning = board.warnings().first();
        assert_eq!(warning.map(|warning| warning.kind), told, "PING: {loops} loops");
        assert!(warning.is_none_or(|warning| warning.part == board.wiring().part("ping")));
    }
    for (loops, echoes, told) in [
        (7, 0, Some(WarningKind::ShortTrigger)),
        (8, 1, Some(WarningKind::WeakTrigger)),
        (37, 1, Some(WarningKind::WeakTrigger)),
        (40, 1, None),
    ] {
        let mut program = Asm::new();
        program.sbi(io::DDRD, 4).sbi(io::PORTD, 4).delay(loops).cbi(io::PORTD, 4).stay();
        let wiring = Wiring::builder().part("range", Kind::HcSr04(HcSr04));
        let mut board = board(&program, wiring.connect("4", "range.trigger").connect("5", "range.echo"));
        let mut world = World { echo_ns: Some(1_000_000), ..World::default() };
        board.run_until(25 * MS, &mut world);
        let found = board.warnings().first().map(|warning| warning.kind);
        assert_eq!((world.echoes.len(), found), (echoes, told), "HC-SR04: {loops} loops");
    }
}

#[test]
fn an_hc_sr04_answers_on_its_second_pin() {
    let mut program = Asm::new();
    program.sbi(io::DDRD, 4).sbi(io::PORTD, 4).delay(50).cbi(io::PORTD, 4).ldi(24, 0).ldi(25, 0);
    let low = program.here();
    program.sbis(io::PIND, 5).rjmp(low);
    let high = program.here();
    // Five cycles a turn.
    program.adiw24(1).sbic(io::PIND, 5).rjmp(high).stay();
    let wiring = Wiring::builder().part("range", Kind::HcSr04(HcSr04));
    let mut board = board(&program, wiring.connect("4", "range.trigger").connect("5", "range.echo"));
    board.run_until(10 * MS, &mut World { echo_ns: Some(5_800_000), ..World::default() });
    assert!(pair(&board, 24).abs_diff(5800 / 5 * 16) <= 1, "{}", pair(&board, 24));
    assert_eq!(board.warnings(), []);
}

#[test]
fn a_reflectance_sensor_holds_its_pin_as_long_as_it_discharges() {
    let mut program = Asm::new();
    program
        .sbi(io::DDRC, 0)
        .sbi(io::PORTC, 0)
        .delay(40)
        .ldi(24, 0)
        .ldi(25, 0)
        .cbi(io::DDRC, 0)
        .cbi(io::PORTC, 0);
    let high = program.here();
    program.adiw24(1).sbic(io::PINC, 0).rjmp(high).stay();
    let wiring = Wiring::builder().part("line", Kind::Reflectance(Reflectance)).connect("A0", "line");
    let mut board = board(&program, wiring);
    board.run_until(3 * MS, &mut World { discharge_ns: 500_000, ..World::default() });
    assert!(pair(&board, 24).abs_diff(500 / 5 * 16) <= 1, "{}", pair(&board, 24));
    assert_eq!(board.warnings(), []);
}

/// Counts interrupts of a vector in r24 and r25.
fn counter(vector: usize, prepare: impl FnOnce(&mut Asm)) -> Asm {
    let mut program = Asm::new();
    program.rjmp(0x40).org(2 * vector).adiw24(1).reti().org(0x40);
    prepare(&mut program);
    program.sei().stay();
    program
}

const INT0: usize = 1;
const PCINT2: usize = 5;

#[test]
fn int0_counts_each_edge_of_a_single_channel() {
    // ISC0 = 1: any edge.
    let program = counter(INT0, |program| {
        program.store(data::EICRA, 1).ldi(16, 1).out(io::EIMSK, 16);
    });
    let encoder = Encoder { channels: Channels::Single, counts_per_turn: 40 };
    let wiring = Wiring::builder().part("left", Kind::Encoder(encoder)).connect("2", "left.a");
    let mut board = board(&program, wiring);
    let mut world = World::default();
    board.run_until(MS, &mut world);
    // Three turns in a second and a bit, in steps of 10 ms.
    for step in 0..100 {
        world.wheel = Wheel { angle_rad: 0.01 + 3.0 * TAU * f64::from(step) / 100.0, rate_rad_s: 3.0 * TAU };
        board.run_until(board.now_ns() + 10 * MS, &mut world);
    }
    assert_eq!(pair(&board, 24), 120);
    assert_eq!(board.warnings(), []);
}

#[test]
fn pin_change_interrupts_count_all_edges_in_quadrature_also_many_in_a_step() {
    let program = counter(PCINT2, |program| {
        program.store(data::PCMSK2, 1 << 6 | 1 << 7).store(data::PCICR, 4);
    });
    let encoder = Encoder { channels: Channels::Quadrature, counts_per_turn: 2000 };
    let wiring =
        Wiring::builder().part("left", Kind::Encoder(encoder)).connect("6", "left.a").connect("7", "left.b");
    let mut board = board(&program, wiring);
    let mut world = World::default();
    board.run_until(MS, &mut world);
    let before = pair(&board, 24);
    world.wheel = Wheel { angle_rad: 1e-3, rate_rad_s: 10.0 * TAU };
    board.run_until(101 * MS, &mut world);
    world.wheel = Wheel { angle_rad: TAU + 1e-3, rate_rad_s: 0.0 };
    board.run_until(102 * MS, &mut world);
    assert_eq!(pair(&board, 24) - before, 2000, "one turn in 100 ms");
    world.wheel.rate_rad_s = -10.0 * TAU;
    board.run_until(202 * MS, &mut world);
    world.wheel = Wheel { angle_rad: 1e-3, rate_rad_s: 0.0 };
    board.run_until(203 * MS, &mut world);
    assert_eq!(pair(&board, 24) - before, 4000, "and back");
}

#[test]
fn a_program_that_does_not_debounce_counts_the_bounces() {
    // ISC0 = 2: falling edges.
    let program = counter(INT0, |program| {
        program.store(data::EICRA, 2).ldi(16, 1).out(io::EIMSK, 16);
    });
    let pushes = |bounce_us| {
        let whisker = Switch { pull: Pull::External, bounce_us, seed: 7 };
        let wiring = Wiring::builder().part("whisker", Kind::Switch(whisker)).connect("2", "whisker");
        let mut board = board(&program, wiring);
        let mut world = World::default();
        board.run_until(MS, &mut world);
        let before = pair(&board, 24);
        for push in 1..=10 {
            world.pressed = push % 2 == 1;
            board.run_until(push * 10 * MS, &mut world);
        }
        pair(&board, 24) - before
    };
    assert_eq!(pushes(0), 5);
    assert!(pushes(1000) >= 10, "{}", pushes(1000));
    assert_eq!(pushes(1000), pushes(1000));
}

#[test]
fn an_output_on_an_echo_is_told_in_the_words_of_who_wired_it() {
    let mut program = Asm::new();
    program.sbi(io::DDRB, 3).sbi(io::PORTB, 3).stay();
    let wiring = Wiring::builder().part("sensors.sonar", Kind::HcSr04(HcSr04));
    let wiring = wiring.connect("12", "sensors.sonar.trigger").connect("11", "sensors.sonar.echo");
    let mut board = board(&program, wiring);
    board.run_until(MS, &mut World::default());
    let [warning] = board.warnings() else { panic!("{:?}", board.warnings()) };
    assert_eq!(warning.printed_pin(), "11");
    assert_eq!(
        warning.explain(board.wiring()),
        "wired to the sonar's echo, which drives it, and the sketch drives it too; are trigger and echo swapped?"
    );
}
