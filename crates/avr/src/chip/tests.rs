use std::vec;
use std::vec::Vec;

use super::*;
use crate::board::{Bare, Board, Warning};
use crate::pin::{Drive, External, Pin, Port};
use crate::vector::Vector;

/// A chip with these words from address 0 on, at the instant at which it executes the first.
pub(super) fn chip(words: &[u16]) -> Chip {
    let part = Part::Atmega328P;
    let program = Program::from_words(part, words).unwrap();
    let mut chip = Chip::new(&program, Fuses::external_clock(part), Supply::ARDUINO);
    let start = chip.next_event().unwrap();
    chip.run(start, &mut Bare);
    chip
}

/// Runs for so many cycles.
pub(super) fn run(chip: &mut Chip, cycles: u64, board: &mut impl Board) -> Stop {
    chip.run(chip.now() + cycles, board)
}

/// Executes one instruction, or takes one interrupt; the answer is how many cycles that took.
pub(super) fn step(chip: &mut Chip) -> u64 {
    let before = chip.cycles();
    run(chip, 1, &mut Bare);
    chip.cycles() - before
}

/// A record of a board's notifications.
#[derive(Default)]
pub(super) struct Told {
    pub(super) pins: Vec<(Pin, Drive, u64)>,
    pub(super) shapes: Vec<(Pin, Option<Pwm>, u64)>,
    pub(super) warnings: Vec<Warning>,
}

impl Board for Told {
    fn pin_changed(&mut self, pin: Pin, drive: Drive, at: u64) {
        self.pins.push((pin, drive, at));
    }

    fn pwm_changed(&mut self, pin: Pin, pwm: Option<Pwm>, at: u64) {
        self.shapes.push((pin, pwm, at));
    }

    fn warn(&mut self, warning: Warning, _at: u64) {
        self.warnings.push(warning);
    }
}

#[test]
fn a_pin_is_set_at_the_end_of_sbi_and_toggled_by_a_one_in_pinx() {
    // sbi DDRB, 5; sbi PORTB, 5; sbi PINB, 5; rjmp .-2
    let mut chip = chip(&[0x9A25, 0x9A2D, 0x9A1D, 0xCFFF]);
    let start = chip.now();
    let mut told = Told::default();
    run(&mut chip, 20, &mut told);
    let pin = Pin::of(Port::B, 5);
    assert_eq!(
        told.pins,
        [(pin, Drive::Low, start + 2), (pin, Drive::High, start + 4), (pin, Drive::Low, start + 6)]
    );
}

#[test]
fn an_output_is_read_back_one_cycle_later() {
    // ldi r16, 0xFF; out DDRB, r16; out PORTB, r16; in r17, PINB; in r18, PINB
    let mut chip = chip(&[0xEF0F, 0xB904, 0xB905, 0xB113, 0xB123]);
    run(&mut chip, 5, &mut Bare);
    assert_eq!((chip.register(17), chip.register(18)), (0, 0xFF));
}

#[test]
fn an_interrupt_takes_four_cycles_and_waits_for_the_instruction_after_sei() {
    // ldi r16, 1; out EIMSK, r16; sei; nop; nop with INT0 low
    let mut chip = chip(&[0xE001, 0xBB0D, 0x9478, 0x0000, 0x0000]);
    assert_eq!([step(&mut chip), step(&mut chip), step(&mut chip), step(&mut chip)], [1, 1, 1, 1]);
    assert_eq!(chip.pc(), 4);
    assert_eq!(step(&mut chip), 4);
    assert_eq!(chip.pc(), 2 * Vector::Int0.number());
    assert_eq!((chip.sreg & 0x80, chip.sp), (0, 0x8FD));
    assert_eq!(chip.sram()[0x7FE..], [0, 4]);
}

#[test]
fn after_reti_one_instruction_is_executed_before_the_next_interrupt() {
    let mut words = vec![0x0000; 6];
    words[2] = 0x9518; // reti at the vector of INT0
    let mut chip = chip(&words);
    chip.external.write(crate::external::Register::Mask, 1);
    chip.sreg = 0x80;
    chip.pc = 4;
    assert_eq!((step(&mut chip), chip.pc()), (4, 2));
    assert_eq!((step(&mut chip), chip.pc()), (4, 4));
    assert_eq!((step(&mut chip), chip.pc()), (1, 5));
    assert_eq!((step(&mut chip), chip.pc()), (4, 2));
}

#[test]
fn an_illegal_word_does_nothing_for_one_cycle_and_is_told() {
    let mut chip = chip(&[0xFFFF, 0x0000]);
    let mut told = Told::default();
    run(&mut chip, 1, &mut told);
    assert_eq!(chip.pc(), 1);
    assert_eq!(told.warnings, [Warning::IllegalInstruction { pc: 0, word: 0xFFFF }]);
}

#[test]
fn a_program_out_of_control_is_told_a_hundred_times_until_it_is_reset() {
    // st X, r0; .word 0xFFFF; rjmp .-6 with X beyond the memory
    let mut chip = chip(&[0x920C, 0xFFFF, 0xCFFD]);
    chip.general_registers_mut()[27] = 0xF0;
    let mut told = Told::default();
    run(&mut chip, 10_000, &mut told);
    assert_eq!(told.warnings.len(), 100);
    chip.reset_now(ResetCause::External, &mut told);
    run(&mut chip, 2_000_000, &mut told);
    assert_eq!(told.warnings.len(), 200);
}

#[test]
fn a_twi_slave_whom_nobody_calls_waits_and_causes_no_warning() {
    // Wire.begin(4): TWAR, then TWEN, TWIE and TWEA; and TWINT as at the end of a transfer.
    let (mut chip, mut told) = (idle(), Told::default());
    write(&mut chip, &mut told, &[(0xBA, 4 << 1), (0xBC, 0x45), (0xBC, 0xC5)]);
    run(&mut chip, 100_000, &mut told);
    assert_eq!((chip.requests(), chip.read_data(0xB9, &mut told)), (0, 0xF8));
    assert_eq!(told.warnings, []);
}

/// A chip of 8 MHz by its internal oscillator, that sleeps in this mode; timer 2 with its crystal overflows each second.
fn clock_of_seconds(sleep: u8) -> Chip {
    let part = Part::Atmega328P;
    // rjmp 32; at 9, the overflow of timer 2: inc r20; reti; at 33: sei; sleep; rjmp .-4
    let mut words = [0u16; 40];
    words[0] = 0xC020;
    (words[18], words[19]) = (0x9543, 0x9518);
    (words[33], words[34], words[35]) = (0x9478, 0x9588, 0xCFFE);
    let program = Program::from_words(part, &words).unwrap();
    let supply = Supply { clock_hz: 8_000_000, ..Supply::ARDUINO };
    let mut chip = Chip::new(&program, Fuses { low: 0xE2, ..Fuses::external_clock(part) }, supply);
    let start = chip.next_event().unwrap();
    chip.run(start, &mut Bare);
    // AS2; the division by 128; TOIE2; the sleep mode.
    write(&mut chip, &mut Bare, &[(0xB6, 0x20), (0xB1, 5), (0x70, 1), (0x53, sleep << 1 | 1)]);
    chip
}

#[test]
fn timer_2_with_its_crystal_wakes_each_second_from_power_save_and_not_from_power_down() {
    for (sleep, seconds) in [(0, 5), (1, 5), (3, 5), (7, 5), (2, 0), (6, 0)] {
        let mut chip = clock_of_seconds(sleep);
        let start = chip.now();
        for at in 1..=55 {
            chip.run(start + 800_000 * at, &mut Bare);
            chip = postcard::from_bytes(&postcard::to_allocvec(&chip).unwrap()).unwrap();
        }
        assert_eq!(chip.general_registers()[20], seconds, "sleep mode {sleep}");
    }
}

#[test]
fn timer_2_with_its_crystal_counts_32768_in_a_second_whatever_the_processor_does() {
    let mut chip = clock_of_seconds(0);
    write(&mut chip, &mut Bare, &[(0xB1, 1)]);
    assert_eq!(chip.read_data(0xB6, &mut Bare), 0x20);
    let counts = |at: u64| at * 32_768 / 8_000_000;
    let start = chip.now();
    for later in [1, 244, 245, 489, 1000, 20_000, 62_000] {
        chip.run(start + later, &mut Bare);
        let found = u64::from(chip.read_data(0xB2, &mut Bare));
        assert_eq!(found, counts(chip.now()) - counts(start), "{later}");
    }
    // The timer counts cycles again without its crystal.
    write(&mut chip, &mut Bare, &[(0xB6, 0), (0xB2, 0)]);
    run(&mut chip, 100, &mut Bare);
    assert_eq!(chip.read_data(0xB2, &mut Bare), 100);
}

#[test]
fn a_stack_that_reaches_the_variables_is_told_once() {
    // push r0; rjmp .-4
    let mut chip = chip(&[0x920F, 0xCFFE]);
    chip.watch_stack(0x8F0);
    let mut told = Told::default();
    run(&mut chip, 100, &mut told);
    assert_eq!(told.warnings, [Warning::StackLow { sp: 0x8EE, mark: 0x8F0 }]);
    assert_eq!(chip.lowest_sp(), chip.stack_pointer());
}

#[test]
fn break_stops_and_a_further_run_goes_on_behind_it() {
    let mut chip = chip(&[0x0000, 0x9598, 0x0000, 0xCFFF]);
    assert_eq!(run(&mut chip, 100, &mut Bare), Stop::Break);
    assert_eq!(chip.pc(), 2);
    assert_eq!(run(&mut chip, 100, &mut Bare), Stop::Reached);
    assert_eq!(chip.pc(), 3);
}

#[test]
fn a_breakpoint_stops_before_its_instruction_and_does_not_hold_a_further_run() {
    let mut chip = chip(&[0x0000, 0x0000, 0xCFFD]);
    let until = chip.now() + 100;
    assert_eq!(chip.run_to(until, &[1], &mut Bare), Stop::Breakpoint);
    let before = chip.cycles();
    assert_eq!(chip.pc(), 1);
    assert_eq!(chip.run_to(until, &[1], &mut Bare), Stop::Breakpoint);
    assert_eq!((chip.pc(), chip.cycles() - before), (1, 4));
}

#[test]
fn a_breakpoint_behind_sei_does_not_let_an_interrupt_in_before_its_instruction() {
    // ldi r16, 1; out EIMSK, r16; sei; nop; nop with INT0 low
    let mut chip = chip(&[0xE001, 0xBB0D, 0x9478, 0x0000, 0x0000]);
    let until = chip.now() + 100;
    assert_eq!((chip.run_to(until, &[3], &mut Bare), chip.pc()), (Stop::Breakpoint, 3));
    assert_eq!((step(&mut chip), chip.pc()), (1, 4));
    assert_eq!((step(&mut chip), chip.pc()), (4, 2));
}

#[test]
fn a_run_in_two_parts_is_the_same_as_one() {
    let words = [0xE001, 0xBB0D, 0x9478, 0x9503, 0xCFFE];
    let (mut whole, mut parts) = (chip(&words), chip(&words));
    let end = whole.now() + 1000;
    whole.run(end, &mut Bare);
    while parts.now() < end {
        let at = parts.now() + 1;
        parts.run(at, &mut Bare);
        parts = postcard::from_bytes(&postcard::to_allocvec(&parts).unwrap()).unwrap();
    }
    assert!(whole == parts);
}

#[test]
fn idle_sleep_lasts_until_an_interrupt_and_waking_takes_eight_cycles() {
    // ldi r16, 1; out SMCR, r16; sts TIMSK0, r16; out TCCR0B, r16; sei; sleep; nop
    let mut chip = chip(&[0xE001, 0xBF03, 0x9300, 0x006E, 0xBD05, 0x9478, 0x9588, 0x0000]);
    for _ in 0..4 {
        step(&mut chip);
    }
    let started = chip.now();
    step(&mut chip);
    step(&mut chip);
    assert_eq!(chip.sleep(), Some(Sleep::Idle));
    assert_eq!(chip.next_event(), Some(started + 256));
    chip.run(started + 255, &mut Bare);
    assert_eq!((chip.sleep(), chip.now()), (Some(Sleep::Idle), started + 255));
    chip.run(started + 257, &mut Bare);
    assert_eq!(chip.sleep(), None);
    chip.run(started + 261, &mut Bare);
    assert_eq!((chip.now(), chip.pc()), (started + 264, 2 * Vector::Timer0Overflow.number()));
}

#[test]
fn the_watchdog_resets_and_leaves_its_mark_in_mcusr() {
    // ldi r16, 0x18; ldi r17, 0x08; sts WDTCSR, r16; sts WDTCSR, r17; rjmp .-2
    let mut chip = chip(&[0xE108, 0xE018, 0x9300, 0x0060, 0x9310, 0x0060, 0xCFFF]);
    let start = chip.now();
    assert_eq!(chip.system.status(), ResetCause::PowerOn as u8);
    chip.run(start + 256_002, &mut Bare);
    assert_eq!(chip.system.status(), 1);
    chip.run(start + 256_010, &mut Bare);
    assert_eq!(chip.system.status(), 9);
    assert_eq!(chip.pc(), 0);
}

#[test]
fn a_watchdog_that_has_bitten_counts_from_the_end_of_the_reset() {
    // in r20, MCUSR; ldi r16, 0x18; ldi r17, 0x08; sts WDTCSR, r16; sts WDTCSR, r17; rjmp .-2
    let words = [0xB744, 0xE108, 0xE018, 0x9300, 0x0060, 0x9310, 0x0060, 0xCFFF];
    let program = Program::from_words(Part::Atmega328P, &words).unwrap();
    // A crystal that takes 65 ms to start, and a watchdog of 16 ms.
    let fuses = Fuses { high: 0xDF, ..Fuses::ARDUINO_UNO };
    let mut chip = Chip::new(&program, fuses, Supply::ARDUINO);
    let start_up = chip.next_event().unwrap();
    for resets in 1..4 {
        chip.run(start_up * resets + 256_020 * (resets - 1) + 100, &mut Bare);
        assert_eq!(chip.watchdog_resets() as u64, resets - 1);
        assert_eq!(chip.general_registers()[20], if resets == 1 { 1 } else { 9 }, "the program runs");
    }
}

#[test]
fn a_loop_that_asks_by_a_function_is_passed_over_until_something_happens() {
    // rcall .+6; sbrs r24, 7; rjmp .-6; ldi r20, 1; in r24, PIND; out PORTB, r1; ret
    let mut quick = chip(&[0xD003, 0xFF87, 0xCFFD, 0xE041, 0xB189, 0xB815, 0x9508]);
    let mut slow = quick.clone();
    let start = quick.now();
    for chip in [&mut quick, &mut slow] {
        chip.set_pin(Pin::of(Port::D, 7), External::Low, start + 10).unwrap();
        chip.set_pin(Pin::of(Port::D, 7), External::High, start + 100_003).unwrap();
    }
    for until in [50_000, 100_000, 100_003, 100_020] {
        quick.run(start + until, &mut Bare);
        if until == 50_000 {
            assert_eq!(quick.repeat.passed, 1, "it was recognised, once");
        }
        slow.run_to(start + until, &[], &mut Bare);
        assert!(quick == slow, "until {until}");
    }
    assert_eq!(quick.general_registers()[20], 1);
}

#[test]
fn a_loop_that_asks_for_a_counter_ends_though_it_finds_the_same_for_a_while() {
    // ldi r16, 1; sts TCCR1B, r16; lds r25, TCNT1L; lds r24, TCNT1H; ldi r25, 0; sbrs r24, 4; rjmp .-14;
    // lds r20, TCNT1L; lds r21, TCNT1H; rjmp .-2
    let mut chip = chip(&[
        0xE001, 0x9300, 0x0081, 0x9190, 0x0084, 0x9180, 0x0085, 0xE090, 0xFF84, 0xCFF9, 0x9140, 0x0084,
        0x9150, 0x0085, 0xCFFF,
    ]);
    run(&mut chip, 100, &mut Bare);
    run(&mut chip, 20_000, &mut Bare);
    let counter = u16::from_le_bytes([chip.general_registers()[20], chip.general_registers()[21]]);
    assert!((0x1000..0x1010).contains(&counter), "{counter}");
}

#[test]
fn a_loop_that_counts_in_memory_or_asks_for_a_counter_is_gone_through() {
    for words in [
        // lds r24, 0x100; lds r25, 0x101; adiw r24, 1; sts 0x100, r24; sts 0x101, r25; rjmp .-20
        &[0x9180, 0x0100, 0x9190, 0x0101, 0x9601, 0x9380, 0x0100, 0x9390, 0x0101, 0xCFF6][..],
        // ldi r16, 1; sts TCCR1B, r16; lds r24, TCNT1L; rjmp .-6
        &[0xE001, 0x9300, 0x0081, 0x9180, 0x0084, 0xCFFD],
        // sbi PIND, 0; rjmp .-4
        &[0x9A48, 0xCFFE],
    ] {
        let mut chip = chip(words);
        run(&mut chip, 100, &mut Bare);
        run(&mut chip, 20_000, &mut Bare);
        assert_eq!(chip.repeat.passed, 0);
    }
}

#[test]
fn ckdiv8_and_clkpr_stretch_cycles() {
    let part = Part::Atmega328P;
    // ldi r16, 0x80; ldi r17, 0; sts CLKPR, r16; sts CLKPR, r17; nop
    let words = [0xE800, 0xE010, 0x9300, 0x0061, 0x9310, 0x0061, 0x0000, 0xCFFF];
    let program = Program::from_words(part, &words).unwrap();
    let mut chip = Chip::new(&program, Fuses { low: 0x40, ..Fuses::external_clock(part) }, Supply::ARDUINO);
    let start = chip.next_event().unwrap();
    chip.run(start + 8, &mut Bare);
    assert_eq!((chip.pc(), chip.now()), (1, start + 8));
    chip.run(start + 8 * 6, &mut Bare);
    assert_eq!((chip.pc(), chip.now()), (6, start + 48));
    chip.run(start + 49, &mut Bare);
    assert_eq!((chip.pc(), chip.now()), (7, start + 49));
}

/// A chip in an endless loop, whose registers a test sets as a program would.
fn idle() -> Chip {
    chip(&[0xCFFF])
}

fn write(chip: &mut Chip, board: &mut impl Board, writes: &[(u16, u8)]) {
    for &(address, value) in writes {
        chip.write_data(address, value, board);
    }
}

/// A thermometer on the TWI bus, at address 0x48: it notes what is done to it.
#[derive(Default)]
struct Thermometer {
    log: Vec<(&'static str, u8)>,
}

impl Board for Thermometer {
    fn twi_address(&mut self, address: u8, direction: crate::board::Direction, _at: u64) -> bool {
        self.log.push((
            if direction == crate::board::Direction::Read { "read from" } else { "write to" },
            address,
        ));
        address == 0x48
    }

    fn twi_write(&mut self, byte: u8, _at: u64) -> bool {
        self.log.push(("written", byte));
        true
    }

    fn twi_read(&mut self, last: bool, _at: u64) -> u8 {
        self.log.push(("read, last", last.into()));
        0x19
    }

    fn twi_stop(&mut self, _at: u64) {
        self.log.push(("stop", 0));
    }
}

#[test]
fn a_byte_is_read_from_a_slave_on_the_twi_bus() {
    let (twsr, twdr, twcr) = (0xB9, 0xBB, 0xBC);
    let (mut chip, mut board) = (idle(), Thermometer::default());
    let mut statuses = Vec::new();
    for writes in [
        &[(0xB8, 72), (twcr, 0xA4)][..],
        &[(twdr, 0x90), (twcr, 0x84)],
        &[(twdr, 0x07), (twcr, 0x84)],
        &[(twcr, 0xA4)],
        &[(twdr, 0x91), (twcr, 0x84)],
        &[(twcr, 0x84)],
    ] {
        write(&mut chip, &mut board, writes);
        run(&mut chip, 1500, &mut board);
        statuses.push(chip.read_data(twsr, &mut board));
    }
    write(&mut chip, &mut board, &[(twcr, 0x94)]);
    assert_eq!(statuses, [0x08, 0x18, 0x28, 0x10, 0x40, 0x58]);
    assert_eq!(chip.read_data(twdr, &mut board), 0x19);
    let log = [("write to", 0x48), ("written", 7), ("read from", 0x48), ("read, last", 1), ("stop", 0)];
    assert_eq!(board.log, log);
}

struct Inverter;

impl Board for Inverter {
    fn spi_transfer(&mut self, byte: u8, _at: u64) -> u8 {
        !byte
    }

    fn analog_microvolts(&mut self, input: crate::board::AnalogInput, at: u64) -> u32 {
        match input {
            // The voltage rises with time.
            crate::board::AnalogInput::Positive => u32::try_from(at).unwrap(),
            crate::board::AnalogInput::Channel(_)
            | crate::board::AnalogInput::Temperature
            | crate::board::AnalogInput::Negative => 10_000,
        }
    }
}

#[test]
fn a_byte_goes_over_spi_in_8_cycles_of_its_clock() {
    let mut chip = idle();
    // SPE, MSTR, divided by 16.
    write(&mut chip, &mut Inverter, &[(0x4C, 0x51), (0x4E, 0xA5)]);
    run(&mut chip, 126, &mut Inverter);
    assert_eq!(chip.read_data(0x4D, &mut Inverter), 0);
    run(&mut chip, 2, &mut Inverter);
    assert_eq!(chip.read_data(0x4D, &mut Inverter), 0x80);
    assert_eq!(chip.read_data(0x4E, &mut Inverter), 0x5A);
}

#[test]
fn a_slave_on_spi_exchanges_what_it_holds() {
    let mut chip = idle();
    assert_eq!(chip.exchange_spi(1), None);
    write(&mut chip, &mut Bare, &[(0x4C, 0x40), (0x4E, 0xA5)]);
    assert_eq!(chip.exchange_spi(0x12), Some(0xA5));
    assert_eq!(chip.read_data(0x4E, &mut Bare), 0x12);
}

#[test]
fn the_comparator_captures_and_interrupts_when_it_is_told_of_voltages() {
    let mut chip = idle();
    // Timer 1 counts cycles and captures rising edges; the comparator captures and interrupts.
    write(&mut chip, &mut Inverter, &[(0x81, 0x41), (0x50, 0x0C)]);
    run(&mut chip, 5000, &mut Inverter);
    chip.analog_changed(&mut Inverter);
    assert_eq!(chip.read_data(0x36, &mut Inverter) & 0x20, 0);
    run(&mut chip, 6000, &mut Inverter);
    chip.analog_changed(&mut Inverter);
    assert_eq!(chip.read_data(0x36, &mut Inverter) & 0x20, 0x20);
    assert_eq!(chip.read_data(0x50, &mut Inverter) & 0x30, 0x30);
    assert_eq!(chip.requests(), Vector::Comparator.bit());
}

#[test]
fn a_change_of_a_watched_pin_requests_the_interrupt_of_its_port() {
    for (port, vector) in
        [(Port::B, Vector::PinChange0), (Port::C, Vector::PinChange1), (Port::D, Vector::PinChange2)]
    {
        let mut chip = idle();
        write(&mut chip, &mut Bare, &[(0x68, 7), (0x6B + port as u16, 0x04)]);
        let at = chip.now() + 100;
        chip.set_pin(Pin::of(port, 3), External::High, at).unwrap();
        chip.set_pin(Pin::of(port, 2), External::High, at + 100).unwrap();
        chip.run(at + 50, &mut Bare);
        assert_eq!(chip.requests(), 0);
        chip.run(at + 150, &mut Bare);
        assert_eq!(chip.requests(), vector.bit());
    }
}

#[test]
fn int0_is_requested_by_the_edges_that_were_chosen() {
    for (sense, flags) in [(1, [true, true]), (2, [false, true]), (3, [true, false])] {
        let mut chip = idle();
        write(&mut chip, &mut Bare, &[(0x69, sense), (0x3D, 1)]);
        for (level, expected) in [External::High, External::Low].into_iter().zip(flags) {
            chip.set_pin(Pin::of(Port::D, 2), level, chip.now() + 10).unwrap();
            run(&mut chip, 20, &mut Bare);
            assert_eq!(chip.read_data(0x3C, &mut Bare) & 1 == 1, expected, "sense {sense}, {level:?}");
            chip.write_data(0x3C, 1, &mut Bare);
        }
    }
}

#[test]
fn pins_drive_pull_up_and_float_as_their_registers_say() {
    let mut chip = idle();
    let pin = Pin::of(Port::C, 2);
    for (direction, port, drive, level) in [
        (0, 0, Drive::HighImpedance, false),
        (0, 4, Drive::PullUp, true),
        (4, 4, Drive::High, true),
        (4, 0, Drive::Low, false),
    ] {
        write(&mut chip, &mut Bare, &[(0x27, direction), (0x28, port)]);
        assert_eq!((chip.drive(pin), chip.level(pin)), (drive, level));
    }
    // PUD.
    write(&mut chip, &mut Bare, &[(0x27, 0), (0x28, 4), (0x55, 0x10)]);
    assert_eq!(chip.drive(pin), Drive::HighImpedance);
}

#[test]
fn two_outputs_on_one_wire_and_a_floating_input_are_told() {
    // sbis PIND, 4; rjmp .-4
    let mut chip = chip(&[0x9B4C, 0xCFFE]);
    let mut told = Told::default();
    run(&mut chip, 50, &mut told);
    let pin = Pin::of(Port::D, 4);
    chip.set_pin(pin, External::Low, chip.now()).unwrap();
    write(&mut chip, &mut told, &[(0x2A, 0x10), (0x2B, 0x10)]);
    assert_eq!(told.warnings, [Warning::FloatingInput { pin }, Warning::Contention { pin }]);
}

/// The warnings when this is executed, with registers 30 and 31 at PIND and 17 as given.
fn told_by(words: &[u16], mask: u8) -> Vec<Warning> {
    let [low, high] = [0xE010 | u16::from(mask & 0xF0) << 4 | u16::from(mask & 0xF), 0xE0F0];
    // ldi r17, mask; ldi r30, PIND; ldi r31, 0; …; rjmp .-2
    let program: Vec<_> = [&[low, 0xE2E9, high], words, &[0xCFFF]].concat();
    let mut told = Told::default();
    run(&mut chip(&program), 30, &mut told);
    told.warnings
}

#[test]
fn a_floating_input_that_is_read_with_its_port_and_then_looked_at_alone_is_told() {
    for (words, pin) in [
        // in r24, PIND; andi r24, 4
        (&[0xB189, 0x7084][..], 2),
        // in r24, PIND; sbrs r24, 3; and sbrc
        (&[0xB189, 0xFF83, 0x0000], 3),
        (&[0xB189, 0xFD83, 0x0000], 3),
        // in r24, PIND; bst r24, 5
        (&[0xB189, 0xFB85], 5),
        // in r24, PIND; com r24; andi r24, 0x40
        (&[0xB189, 0x9580, 0x7480], 6),
        // lds r24, PIND; andi r24, 0x10
        (&[0x9180, 0x0029, 0x7180], 4),
        // ld r24, Z; and r17, r24, which is Arduino's digitalRead; and r24, r17
        (&[0x8180, 0x2318], 7),
        (&[0x8180, 0x2381], 7),
    ] {
        let pin = Pin::of(Port::D, pin);
        assert_eq!(told_by(words, 0x80), [Warning::FloatingInput { pin }], "{words:x?}");
    }
}

#[test]
fn nobody_knows_which_pins_of_a_port_a_program_means_that_looks_at_several() {
    for words in [
        // in r24, PIND; andi r24, 0x0C
        &[0xB189, 0x708C][..],
        // in r24, PIND; and r24, r24; andi r25, 4; mov r25, r24
        &[0xB189, 0x2388],
        &[0xB189, 0x7094],
        &[0xB189, 0x2F98],
        // ld r24, Z; and r24, r17, where r17 is 0x81
        &[0x8180, 0x2381],
        // in r24, PORTD; andi r24, 4
        &[0xB18B, 0x7084],
    ] {
        assert_eq!(told_by(words, 0x81), [], "{words:x?}");
    }
    // ldi r16, 4; out PORTD, r16; in r24, PIND; andi r24, 4
    assert_eq!(told_by(&[0xE004, 0xB90B, 0xB189, 0x7084], 0), [], "it is pulled up");
}

#[test]
fn waking_from_power_down_takes_the_start_up_time_of_the_oscillator() {
    // sei; sleep; nop; rjmp .-2 with PCINT16 awaited
    let words = [0x9478, 0x9588, 0x0000, 0xCFFF];
    let part = Part::Atmega328P;
    let program = Program::from_words(part, &words).unwrap();
    // A crystal: 16K cycles.
    let fuses = Fuses { low: 0xFF, ..Fuses::external_clock(part) };
    let mut chip = Chip::new(&program, fuses, Supply::ARDUINO);
    let start = chip.next_event().unwrap();
    assert_eq!(start, 16_384 + 14 + 65 * 16_000);
    chip.run(start, &mut Bare);
    write(&mut chip, &mut Bare, &[(0x53, 0x05), (0x68, 4), (0x6D, 1)]);
    run(&mut chip, 1000, &mut Bare);
    let at = chip.now() + 1_000_000;
    chip.set_pin(Pin::of(Port::D, 0), External::High, at).unwrap();
    chip.run(at + 16_384, &mut Bare);
    // Four cycles to wake, four for the interrupt.
    chip.run(at + 16_384 + 7, &mut Bare);
    assert_eq!((chip.now(), chip.pc()), (at + 16_384 + 8, 2 * Vector::PinChange2.number()));
}

#[test]
fn timers_stand_in_adc_noise_reduction_and_a_conversion_begins() {
    // sei; sleep; nop with the ADC's interrupt enabled
    let mut chip = chip(&[0x9478, 0x9588, 0x0000, 0xCFFF]);
    write(&mut chip, &mut Bare, &[(0x53, 0x03), (0x7A, 0x8A), (0x45, 1)]);
    chip.run(chip.now() + 3, &mut Bare);
    let before = chip.read_data(0x46, &mut Bare);
    run(&mut chip, 60, &mut Bare);
    assert_eq!((chip.sleep(), chip.read_data(0x46, &mut Bare)), (Some(Sleep::AdcNoiseReduction), before));
    // 25 cycles of 4.
    run(&mut chip, 60, &mut Bare);
    assert_eq!(chip.sleep(), None);
    assert_ne!(chip.read_data(0x46, &mut Bare), before);
}

#[test]
fn a_timer_whose_power_is_reduced_stands_and_takes_no_writes() {
    let mut chip = idle();
    write(&mut chip, &mut Bare, &[(0x45, 1)]);
    run(&mut chip, 100, &mut Bare);
    write(&mut chip, &mut Bare, &[(0x64, 0x20)]);
    let count = chip.read_data(0x46, &mut Bare);
    write(&mut chip, &mut Bare, &[(0x46, 0)]);
    run(&mut chip, 100, &mut Bare);
    assert_eq!(chip.read_data(0x46, &mut Bare), count);
    write(&mut chip, &mut Bare, &[(0x64, 0)]);
    run(&mut chip, 100, &mut Bare);
    assert_ne!(chip.read_data(0x46, &mut Bare), count);
}

#[test]
fn interrupts_go_to_the_boot_section_if_ivsel_is_set_by_its_sequence() {
    let mut chip = idle();
    write(&mut chip, &mut Bare, &[(0x55, 2)]);
    assert!(!chip.system.vectors_in_boot());
    write(&mut chip, &mut Bare, &[(0x55, 1), (0x55, 2), (0x3D, 1)]);
    chip.sreg = 0x80;
    step(&mut chip);
    assert_eq!(chip.pc(), chip.fuses().boot_start(Part::Atmega328P) + 2);
}

#[test]
fn what_is_not_simulated_is_told() {
    use crate::board::Unsupported;
    for (address, value, expected) in
        [(0xB6, 0x20, Unsupported::AsynchronousTimer), (0xC2, 0x46, Unsupported::SynchronousUsart)]
    {
        let mut told = Told::default();
        idle().write_data(address, value, &mut told);
        assert_eq!(told.warnings, [Warning::Unsupported(expected)]);
    }
}

#[test]
fn a_chip_of_8_kib_has_vectors_of_one_word() {
    let part = Part::Atmega88A;
    let program = Program::from_words(part, &[0xCFFF]).unwrap();
    let mut chip = Chip::new(&program, Fuses::external_clock(part), Supply::ARDUINO);
    let start = chip.next_event().unwrap();
    chip.run(start, &mut Bare);
    write(&mut chip, &mut Bare, &[(0x3D, 2)]);
    chip.sreg = 0x80;
    step(&mut chip);
    assert_eq!((chip.pc(), chip.stack_pointer()), (2, 0x4FD));
}

#[test]
fn changes_of_pins_in_the_past_or_too_many_are_refused() {
    let mut chip = idle();
    run(&mut chip, 100, &mut Bare);
    let (pin, now) = (Pin::of(Port::B, 0), chip.now());
    assert_eq!(chip.set_pin(pin, External::Low, now - 1), Err(InputError::Past { at: now - 1, now }));
    for later in 0..64 {
        chip.set_pin(pin, External::Low, now + later).unwrap();
    }
    assert_eq!(chip.set_pin(pin, External::Low, now), Err(InputError::Full));
}
