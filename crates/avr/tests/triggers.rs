//! The events that start conversions of the ADC, to the cycle. avr8js has none of this, so that the data sheet alone
//! is the measure.
//!
//! Source: data sheet, section *Prescaling and Conversion Timing*: a conversion that is triggered samples its input two cycles of
//! the ADC's clock after the trigger, and three cycles of the system clock go to the synchroniser.

use baudbot_avr::{AnalogInput, Bare, Board, Chip, External, Fuses, Part, Pin, Port, Program, Supply};

const SMCR: u16 = 0x53;
const ADCSRA: u16 = 0x7A;
const ADCSRB: u16 = 0x7B;
const ACSR: u16 = 0x50;
const EICRA: u16 = 0x69;
const TIFR0: u16 = 0x35;
const TIFR1: u16 = 0x36;
const TCCR0B: u16 = 0x45;
const OCR0A: u16 = 0x47;
const TCCR1B: u16 = 0x81;
const OCR1BH: u16 = 0x8B;
const OCR1BL: u16 = 0x8A;
/// ADEN, ADSC, ADATE, and a clock divided by 8.
const SINGLE: u8 = 0xC3;
const TRIGGERED: u8 = 0xA3;
const CLOCK: u64 = 8;

/// Notes when the ADC samples. The positive input of the comparator rises above the negative one at 1000.
#[derive(Default)]
struct Samples {
    at: Vec<u64>,
    rises_at: u64,
}

impl Board for Samples {
    fn analog_microvolts(&mut self, input: AnalogInput, at: u64) -> u32 {
        match input {
            AnalogInput::Channel(_) | AnalogInput::Temperature => self.at.push(at),
            AnalogInput::Positive => return if at >= self.rises_at { 2 } else { 0 },
            AnalogInput::Negative => {}
        }
        1
    }
}

/// A chip that sleeps, and whose ADC has made its first conversion.
fn chip() -> Chip {
    // sleep; rjmp .-4
    let program = Program::from_words(Part::Atmega328P, &[0x9588, 0xCFFE]).unwrap();
    let mut chip = Chip::new(&program, Fuses::external_clock(Part::Atmega328P), Supply::ARDUINO);
    let start = chip.next_event().unwrap();
    chip.run(start, &mut Bare);
    write(&mut chip, &[(SMCR, 1), (ADCSRA, SINGLE)]);
    chip.run(start + 1000, &mut Bare);
    chip
}

fn write(chip: &mut Chip, writes: &[(u16, u8)]) {
    for &(address, value) in writes {
        chip.write_data(address, value, &mut Bare);
    }
}

/// ADTS, registers that are written at once, cycles from there to the trigger.
type Case = (u8, &'static [(u16, u8)], u64);

#[test]
fn each_trigger_starts_a_conversion_that_samples_two_clocks_and_three_cycles_later() {
    let pin = |port, bit| Pin::new(port, bit).unwrap();
    let cases: [Case; 7] = [
        (1, &[(ACSR, 0x03)], 300),
        // INT0 on a falling edge.
        (2, &[(EICRA, 2)], 300),
        // The tick from OCR0A to the next.
        (3, &[(OCR0A, 99), (TCCR0B, 1)], 100),
        (4, &[(TCCR0B, 1)], 256),
        (5, &[(OCR1BH, 1), (OCR1BL, 43), (TCCR1B, 1)], 300),
        (6, &[(TCCR1B, 1)], 65_536),
        // ICP1 on a falling edge.
        (7, &[(TCCR1B, 1)], 300),
    ];
    for (trigger, writes, cycles) in cases {
        let mut chip = chip();
        let level = External::High;
        for pin in [pin(Port::D, 2), pin(Port::B, 0)] {
            chip.set_pin(pin, level, chip.now()).unwrap();
        }
        chip.run(chip.now() + 10, &mut Bare);
        write(&mut chip, &[(TIFR0, 7), (TIFR1, 0x27), (ADCSRB, trigger), (ADCSRA, TRIGGERED)]);
        let zero = chip.now();
        write(&mut chip, writes);
        let at = zero + cycles;
        let mut board = Samples { at: Vec::new(), rises_at: at };
        for pin in [pin(Port::D, 2), pin(Port::B, 0)] {
            chip.set_pin(pin, External::Low, at).unwrap();
        }
        chip.run(at, &mut board);
        chip.analog_changed(&mut board);
        chip.run(at + 500, &mut board);
        assert_eq!(board.at, [at + 3 + 2 * CLOCK], "trigger {trigger}");
    }
}

#[test]
fn a_trigger_whose_flag_stays_set_starts_nothing_more() {
    let mut chip = chip();
    let mut board = Samples::default();
    write(&mut chip, &[(TIFR0, 7), (ADCSRB, 4), (ADCSRA, TRIGGERED)]);
    let zero = chip.now();
    write(&mut chip, &[(TCCR0B, 1)]);
    chip.run(zero + 1000, &mut board);
    assert_eq!(board.at.len(), 1);
    // Another one begins with the next overflow once the flag has been cleared.
    write(&mut chip, &[(TIFR0, 1)]);
    chip.run(zero + 1500, &mut board);
    assert_eq!(board.at, [zero + 256 + 3 + 2 * CLOCK, zero + 1024 + 3 + 2 * CLOCK]);
}

#[test]
fn free_running_conversions_sample_every_13_clocks() {
    let mut chip = chip();
    let mut board = Samples::default();
    write(&mut chip, &[(ADCSRB, 0), (ADCSRA, TRIGGERED | 1 << 6)]);
    let start = chip.now();
    chip.run(start + 1000, &mut board);
    let first = board.at[0];
    // One and a half clocks after the next beginning of a clock.
    assert!((start + 12..start + 12 + CLOCK).contains(&first), "{first} after {start}");
    let expected: Vec<u64> = (0..board.at.len() as u64).map(|at| first + 13 * CLOCK * at).collect();
    assert_eq!(board.at, expected);
    assert!(board.at.len() >= 9);
}

/// Switching to a source that is set is a rising edge of the trigger.
#[test]
fn a_source_whose_flag_has_long_been_set_starts_a_conversion_when_it_is_chosen() {
    let mut chip = chip();
    let mut board = Samples::default();
    write(&mut chip, &[(TCCR0B, 1)]);
    chip.run(chip.now() + 10_000, &mut board);
    let now = chip.now();
    for (address, value) in [(ADCSRA, TRIGGERED), (ADCSRB, 4)] {
        chip.write_data(address, value, &mut board);
    }
    chip.run(now + 1000, &mut board);
    assert_eq!(board.at, [now + 3 + 2 * CLOCK]);
}

#[test]
fn edges_of_a_timer_before_its_pin_was_watched_request_no_pin_change_interrupt() {
    use baudbot_avr::{Channel, PwmReport, Timer};
    let mut chip = chip();
    chip.set_pwm_report(Timer::T0, Channel::A, PwmReport::Shape);
    // OC0A on PD6 toggles every 256 cycles.
    write(&mut chip, &[(0x2A, 0x40), (0x44, 0x40), (TCCR0B, 1)]);
    let start = chip.now();
    chip.run(start + 10_100, &mut Bare);
    // PCMSK2 and PCIFR.
    write(&mut chip, &[(0x6D, 0x40)]);
    chip.run(start + 10_200, &mut Bare);
    assert_eq!(chip.read_data(0x3B, &mut Bare), 0);
    chip.run(start + 10_500, &mut Bare);
    assert_eq!(chip.read_data(0x3B, &mut Bare), 4);
}
