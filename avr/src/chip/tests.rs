use std::vec;
use std::vec::Vec;

use super::*;
use crate::board::{Bare, Board, Warning};
use crate::pin::{Drive, Pin, Port};
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

/// What a board was told.
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
    let started = chip.cycles();
    step(&mut chip);
    step(&mut chip);
    assert_eq!(chip.sleep(), Some(Sleep::Idle));
    assert!(chip.next_event().is_some());
    let before = chip.now();
    run(&mut chip, 1000, &mut Bare);
    assert_eq!(chip.sleep(), None);
    let _ = (started, before);
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
