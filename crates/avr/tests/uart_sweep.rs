//! The USART to the cycle, with the divisors that programs use at 16 MHz: when characters are sent and received, and how far a
//! sender's clock may be off.
//!
//! Source: data sheet, sections *Asynchronous Data Recovery* and *Asynchronous Operational Range*. With S samples of a bit, D
//! bits of data and parity, `S_F` the first and `S_M` the middle sample of the vote:
//!
//! ```text
//! R_slow = (D + 1) S / (S - 1 + D S + S_F)        R_fast = (D + 2) S / ((D + 1) S + S_M)
//! ```
//!
//! # What the limits mean
//!
//! Both come out here to the cycle, but they are not limits of the same thing. Sample n of the stop bit is taken
//! (D + 1) S + n - 1 samples after sample 1 of the start bit, which is the first one behind the edge.
//!
//! - At `R_fast` the next start bit begins where the middle sample of the vote is taken at the worst phase. The last sample of
//!   the vote is lost then, and the first two decide: a faster sender causes a framing error.
//! - At `R_slow` the stop bit begins with the first sample of the vote at the worst phase: down to `R_slow` all three samples
//!   are the stop bit's. With a slower sender the first one is lost, but the section on data recovery says that the same majority
//!   vote is made for the stop bit as for the others, so that two samples of three are enough. Framing errors therefore
//!   begin one sample later, at (D + 1) S / (S - 1 + D S + `S_M`), or at `R_slow` itself as soon as noise takes one more sample.
//!
//! `R_fast` is for one character and the start bit behind it. At `R_fast` itself that start bit is found one sample late, and in
//! a long row of characters this adds up. For rows without end the edge must come behind the last sample of the vote (point A
//! in the figure *Stop Bit Sampling and Next Start Bit Sampling*), which is one sample of (D + 1) S slower.

use std::sync::OnceLock;

use baudbot_avr::usart::{BitLength, Frame, Parity, Sent};
use baudbot_avr::{Bare, Board, Chip, External, Fuses, Part, Pin, Port, Program, Supply};

const UCSR0A: u16 = 0xC0;
const UCSR0B: u16 = 0xC1;
const UCSR0C: u16 = 0xC2;
const UBRR0L: u16 = 0xC4;
const UDR0: u16 = 0xC6;
const SMCR: u16 = 0x53;
const RECEIVED: u8 = 1 << 7;
const SENT: u8 = 1 << 6;
const EMPTY: u8 = 1 << 5;
const FRAME_ERROR: u8 = 1 << 4;
const DOUBLE_SPEED: u8 = 1 << 1;
const DIVISORS: [u8; 4] = [103, 51, 16, 8];

/// Data bits, parity and stop bits.
#[derive(Clone, Copy, Debug)]
struct Format {
    data: u8,
    parity: Parity,
    stop: u8,
}

const EIGHT_N_1: Format = Format { data: 8, parity: Parity::None, stop: 1 };
const EIGHT_N_2: Format = Format { data: 8, parity: Parity::None, stop: 2 };
const EIGHT_E_1: Format = Format { data: 8, parity: Parity::Even, stop: 1 };
/// The formats with 5 to 10 bits of data and parity.
const FORMATS: [Format; 6] = [
    Format { data: 5, parity: Parity::None, stop: 1 },
    Format { data: 5, parity: Parity::Even, stop: 1 },
    Format { data: 7, parity: Parity::None, stop: 1 },
    EIGHT_N_1,
    EIGHT_E_1,
    Format { data: 9, parity: Parity::Odd, stop: 1 },
];

impl Format {
    /// D.
    fn bits(self) -> u64 {
        u64::from(self.data) + u64::from(self.parity != Parity::None)
    }

    fn frame(self, data: u16) -> Frame {
        Frame::new(data, self.data, self.parity, self.stop)
    }

    fn control_c(self) -> u8 {
        let parity = match self.parity {
            Parity::None => 0,
            Parity::Even => 2,
            Parity::Odd => 3,
        };
        parity << 4 | (self.stop - 1) << 3 | (self.data.min(8) - 5) << 1
    }

    /// Data with a zero as the last bit before the stop bit.
    fn low_end(self) -> u16 {
        u16::from(self.parity == Parity::Odd)
    }
}

/// A divisor, a speed and a format: all that decides about samples.
#[derive(Clone, Copy, Debug)]
struct Setting {
    ubrr: u8,
    double: bool,
    format: Format,
}

impl Setting {
    fn all(formats: &[Format]) -> impl Iterator<Item = Self> {
        DIVISORS.into_iter().flat_map(move |ubrr| {
            formats.iter().flat_map(move |&format| [false, true].map(|double| Self { ubrr, double, format }))
        })
    }

    /// Cycles from one sample to the next.
    fn tick(self) -> u64 {
        u64::from(self.ubrr) + 1
    }

    /// S, `S_F` and `S_M`.
    fn samples(self) -> (u64, u64, u64) {
        if self.double { (8, 4, 5) } else { (16, 8, 9) }
    }

    fn bit(self) -> u64 {
        self.samples().0 * self.tick()
    }

    /// Cycles from sample 1 of the start bit to sample n of the stop bit.
    fn to_stop_sample(self, n: u64) -> u64 {
        ((self.format.bits() + 1) * self.samples().0 + n - 1) * self.tick()
    }

    /// A chip that sleeps, with its USART on, and a cycle with a tick of the baud-rate generator.
    fn chip(self) -> (Chip, u64) {
        let mut chip = started_chip();
        let zero = chip.now();
        for (address, value) in [
            (SMCR, 1),
            (UCSR0A, if self.double { DOUBLE_SPEED } else { 0 }),
            (UCSR0C, self.format.control_c()),
            (UBRR0L, self.ubrr),
            (UCSR0B, if self.format.data == 9 { 0x1C } else { 0x18 }),
        ] {
            chip.write_data(address, value, &mut Bare);
        }
        chip.run(zero + 1, &mut Bare);
        assert!(chip.sleep().is_some(), "no instruction disturbs it");
        (chip, zero)
    }
}

/// A chip that is about to sleep. Clones share its flash.
fn started_chip() -> Chip {
    static CHIP: OnceLock<Chip> = OnceLock::new();
    let start = || {
        // sleep; rjmp .-4
        let program = Program::from_words(Part::Atmega328P, &[0x9588, 0xCFFE]).unwrap();
        let mut chip = Chip::new(&program, Fuses::external_clock(Part::Atmega328P), Supply::ARDUINO);
        let start = chip.next_event().unwrap();
        chip.run(start, &mut Bare);
        chip
    };
    CHIP.get_or_init(start).clone()
}

#[derive(Default)]
struct Notes(Vec<Sent>);

impl Board for Notes {
    fn character_sent(&mut self, sent: &Sent) {
        self.0.push(*sent);
    }
}

fn status(chip: &mut Chip) -> u8 {
    chip.read_data(UCSR0A, &mut Bare)
}

#[test]
fn characters_are_sent_with_start_bits_and_ends_right_to_the_cycle() {
    for setting in Setting::all(&[EIGHT_N_1, EIGHT_N_2, EIGHT_E_1]) {
        let ((mut chip, zero), mut notes) = (setting.chip(), Notes::default());
        // A cycle behind a tick: the character begins with the next one.
        chip.run(zero + 5 * setting.tick() + 1, &mut Bare);
        chip.write_data(UDR0, 0x55, &mut notes);
        let first = zero + 6 * setting.tick();
        let length = u64::from(setting.format.frame(0).bits()) * setting.bit();
        chip.run(first - 1, &mut notes);
        assert_eq!(status(&mut chip) & EMPTY, 0, "{setting:?}");
        chip.run(first, &mut notes);
        assert_eq!(status(&mut chip) & EMPTY, EMPTY, "{setting:?}");
        for byte in 1..4 {
            chip.write_data(UDR0, byte, &mut notes);
            chip.run(first + u64::from(byte) * length, &mut notes);
        }
        let expected: Vec<(u16, u64, u64)> =
            (0..4).map(|at| ([0x55, 1, 2, 3][at as usize], first + at * length, setting.bit())).collect();
        let found: Vec<_> = notes.0.iter().map(|sent| (sent.frame.data(), sent.start, sent.bit)).collect();
        assert_eq!(found, expected, "{setting:?}");
        chip.run(first + 4 * length - 1, &mut notes);
        assert_eq!(status(&mut chip) & SENT, 0, "{setting:?}");
        chip.run(first + 4 * length, &mut notes);
        assert_eq!(status(&mut chip) & SENT, SENT, "{setting:?}");
    }
}

/// RXC is set with the last sample of the vote on the first stop bit.
#[test]
fn characters_are_received_right_to_the_cycle() {
    for setting in Setting::all(&[EIGHT_N_1, EIGHT_N_2, EIGHT_E_1]) {
        for phase in [0, 1, setting.tick() - 1] {
            let (mut chip, zero) = setting.chip();
            let tick = zero + 50 * setting.tick();
            let bit = BitLength::new(setting.bit() as u32, 1).unwrap();
            for at in 0..4 {
                let frame = setting.format.frame(0x41 + at as u16);
                let after = at * u64::from(frame.bits()) * setting.bit();
                chip.receive(frame, tick - phase + after, bit).unwrap();
                let received = tick + after + setting.to_stop_sample(setting.samples().2 + 1);
                chip.run(received - 1, &mut Bare);
                assert_eq!(status(&mut chip) & RECEIVED, 0, "{setting:?}, {phase}");
                chip.run(received, &mut Bare);
                assert_eq!(status(&mut chip) & (RECEIVED | FRAME_ERROR), RECEIVED, "{setting:?}, {phase}");
                assert_eq!(chip.read_data(UDR0, &mut Bare), 0x41 + at as u8, "{setting:?}, {phase}");
            }
        }
    }
}

/// Receives characters in direct succession, the first of which begins `phase` cycles before a tick, and gives the status and
/// the data of each. `spike` is a number of a sample of the first stop bit that is made low.
fn receive(setting: Setting, data: &[u16], bit: BitLength, phase: u64, spike: Option<u64>) -> Vec<(u8, u16)> {
    let (mut chip, zero) = setting.chip();
    let tick = zero + 20 * setting.tick();
    let start = tick - phase;
    let mut begin = start;
    for &data in data {
        while chip.receive(setting.format.frame(data), begin, bit).is_err() {
            begin += 1;
        }
    }
    if let Some(sample) = spike {
        let (rxd, at) = (Pin::new(Port::D, 0).unwrap(), tick + setting.to_stop_sample(sample));
        for (level, at) in [(External::High, zero + 2), (External::Low, at), (External::High, at + 1)] {
            chip.set_pin(rxd, level, at).unwrap();
        }
    }
    let mut received = Vec::new();
    while received.len() < data.len() {
        match chip.next_event() {
            None | Some(u64::MAX) => break,
            Some(next) => chip.run(next, &mut Bare),
        };
        let status = status(&mut chip);
        if status & RECEIVED != 0 {
            let ninth = u16::from(chip.read_data(UCSR0B, &mut Bare) >> 1 & 1);
            let data = u16::from(chip.read_data(UDR0, &mut Bare)) | ninth << 8;
            received.push((status & 0x1C, data));
        }
    }
    received
}

/// Whether a character and the start bit of the next are received as if nothing was wrong.
fn is_good(setting: Setting, data: u16, bit: BitLength, phase: u64, spike: Option<u64>) -> bool {
    receive(setting, &[data, data], bit, phase, spike)[0] == (0, data)
}

#[test]
fn framing_errors_begin_at_r_fast_to_the_cycle() {
    for setting in Setting::all(&FORMATS) {
        let (samples, _, middle) = setting.samples();
        let bits = setting.format.bits();
        let limit = ((bits + 1) * samples + middle) * setting.tick();
        let length = |cycles: u64| BitLength::new(cycles as u32, bits as u32 + 2).unwrap();
        let worst = setting.tick() - 1;
        for data in [0, 0x15, 0x0A] {
            for phase in [0, worst / 2, worst] {
                assert!(is_good(setting, data, length(limit), phase, None), "{setting:?}, {phase}");
            }
            let beyond = receive(setting, &[data, data], length(limit - 1), worst, None);
            assert_eq!(beyond[0], (FRAME_ERROR, data), "{setting:?}");
        }
    }
}

#[test]
fn down_to_r_slow_any_one_sample_of_a_stop_bit_may_be_wrong_and_beyond_it_none() {
    for setting in Setting::all(&FORMATS) {
        let (samples, first, middle) = setting.samples();
        let bits = setting.format.bits();
        let limit = (samples - 1 + bits * samples + first) * setting.tick();
        let length = |cycles: u64| BitLength::new(cycles as u32, bits as u32 + 1).unwrap();
        let data = setting.format.low_end();
        for spike in [None, Some(first), Some(middle), Some(middle + 1)] {
            for phase in [0, setting.tick() / 2, setting.tick() - 1] {
                assert!(
                    is_good(setting, data, length(limit), phase, spike),
                    "{setting:?}, {phase}, {spike:?}"
                );
            }
        }
        for spike in [middle, middle + 1] {
            let beyond = receive(setting, &[data, data], length(limit + 1), 0, Some(spike));
            assert_eq!(beyond[0], (FRAME_ERROR, data), "{setting:?}, {spike}");
        }
    }
}

#[test]
fn framing_errors_without_noise_begin_one_sample_below_r_slow_to_the_cycle() {
    for setting in Setting::all(&FORMATS) {
        let (samples, _, middle) = setting.samples();
        let bits = setting.format.bits();
        let limit = (samples - 1 + bits * samples + middle) * setting.tick();
        let length = |cycles: u64| BitLength::new(cycles as u32, bits as u32 + 1).unwrap();
        let data = setting.format.low_end();
        assert!(is_good(setting, data, length(limit), 0, None), "{setting:?}");
        assert_eq!(
            receive(setting, &[data, data], length(limit + 1), 0, None)[0].0,
            FRAME_ERROR,
            "{setting:?}"
        );
    }
}

/// The formulas as the tables of the data sheet show them, in per cent, for 5 to 10 bits.
#[test]
fn the_limits_are_those_in_the_tables_of_the_data_sheet() {
    let limits = |double: bool| {
        FORMATS.map(|format| {
            let (s, first, middle) = Setting { ubrr: 8, double, format }.samples();
            let d = format.bits();
            let per_cent = |over: u64, under: u64| (over as f64 / under as f64 * 1e4).round() / 100.0;
            (per_cent((d + 1) * s, s - 1 + d * s + first), per_cent((d + 2) * s, (d + 1) * s + middle))
        })
    };
    let normal =
        [(93.2, 106.67), (94.12, 105.79), (94.81, 105.11), (95.36, 104.58), (95.81, 104.14), (96.17, 103.78)];
    let double =
        [(94.12, 105.66), (94.92, 104.92), (95.52, 104.35), (96.0, 103.9), (96.39, 103.53), (96.7, 103.23)];
    assert_eq!(limits(false), normal);
    assert_eq!(limits(true), double);
}

/// Sweeps the sender's clock over ±8 % by 0.1 %. Between the limits all is right, at each phase and in rows; beyond them there
/// is a phase with errors at each rate.
#[test]
fn over_a_sweep_of_the_senders_clock_errors_begin_at_the_limits() {
    for setting in Setting::all(&FORMATS).filter(|setting| setting.ubrr == 8) {
        let (s, _, middle) = setting.samples();
        let d = setting.format.bits();
        let row = [0, 0x15, 0x0A, 0x1F]
            .map(|data| if setting.format.parity == Parity::Odd { data | 1 } else { data });
        for rate in 920..=1080 {
            let bit = BitLength::new(setting.bit() as u32 * 1000, rate).unwrap();
            let rate = u64::from(rate);
            let is_below = |over: u64, under: u64| rate * under < 1000 * over;
            let too_slow = is_below((d + 1) * s, s - 1 + d * s + middle);
            let too_fast = !is_below((d + 2) * s, (d + 1) * s + middle);
            let too_fast_for_rows = !is_below((d + 2) * s, (d + 1) * s + middle + 1);
            let expected = row.map(|data| (0, setting.format.frame(data).data()));
            let right = [0, setting.tick() / 2, setting.tick() - 1]
                .map(|phase| receive(setting, &row, bit, phase, None) == expected);
            if too_slow || too_fast {
                assert!(right.contains(&false), "{setting:?}, {rate} of 1000");
            } else if !too_fast_for_rows {
                assert_eq!(right, [true; 3], "{setting:?}, {rate} of 1000");
            }
        }
    }
}

/// Behind a single character the line is high: it has no framing error, however fast. Its last bit goes wrong first.
#[test]
fn a_single_fast_character_has_a_wrong_bit_and_no_framing_error() {
    for setting in Setting::all(&FORMATS) {
        let (s, _, middle) = setting.samples();
        let d = setting.format.bits();
        let data = setting.format.low_end();
        let length = |cycles: u64| BitLength::new(cycles as u32, d as u32 + 1).unwrap();
        let limit = (d * s + middle) * setting.tick();
        let single = |cycles| receive(setting, &[data], length(cycles), setting.tick() - 1, None);
        assert_eq!(single(limit), [(0, data)], "{setting:?}");
        let beyond = single(limit - 1);
        assert!(beyond[0] != (0, data) && beyond[0].0 & FRAME_ERROR == 0, "{setting:?}: {beyond:?}");
    }
}

/// At `R_fast` the next start bit is found one sample late: a row goes wrong after a while, and one sample slower it does not.
#[test]
fn a_row_of_characters_without_end_needs_one_sample_more_than_r_fast() {
    for setting in Setting::all(&FORMATS) {
        let (s, _, middle) = setting.samples();
        let d = setting.format.bits();
        let length = |ticks: u64| BitLength::new((ticks * setting.tick()) as u32, d as u32 + 2).unwrap();
        let row = [setting.format.low_end(); 16];
        let limit = (d + 1) * s + middle;
        for phase in [0, setting.tick() - 1] {
            let sustained = receive(setting, &row, length(limit + 1), phase, None);
            assert_eq!(sustained, row.map(|data| (0, data)), "{setting:?}");
            let at_the_limit = receive(setting, &row, length(limit), phase, None);
            assert_eq!(at_the_limit[0], (0, row[0]), "{setting:?}");
            assert_ne!(at_the_limit, row.map(|data| (0, data)), "{setting:?}");
        }
    }
}
