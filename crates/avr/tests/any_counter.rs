//! Loops of chance that read counters: however they run, they do the same. A counter changes without an event, so none of
//! these loops comes back to where it was only because its registers and its memory do.
//!
//! More with `BAUDBOT_AVR_PROGRAMS`.

use baudbot_avr::{Bare, Chip, External, Fuses, Part, Pin, Port, Program, Supply};
use proptest::prelude::*;

/// `LDI R16, value; STS address, R16`.
fn store(address: u16, value: u8) -> Vec<u16> {
    vec![0xE000 | u16::from(value & 0xF0) << 4 | u16::from(value & 0x0F), 0x9300, address]
}

/// `LDS Rd, address`.
fn load(d: u16, address: u16) -> Vec<u16> {
    vec![0x9000 | d << 4, address]
}

/// An instruction with two registers from 16 to 31.
fn two(opcode: u16, d: u16, r: u16) -> u16 {
    opcode | 0x0300 | (d & 15) << 4 | r & 15
}

/// One with a constant and a register from 16 to 27.
fn immediate(opcode: u16, d: u16, k: u8) -> u16 {
    opcode | u16::from(k & 0xF0) << 4 | (d & 15) << 4 | u16::from(k & 0x0F)
}

const TIMERS: [u16; 3] = [0x44, 0x80, 0xB0];
const COUNTERS: [u16; 3] = [0x46, 0x84, 0xB2];

/// A timer's mode, prescaler, compare values and mask.
fn timer() -> impl Strategy<Value = Vec<u16>> {
    (0..3usize, any::<u8>(), any::<u8>(), any::<[u8; 4]>(), 0..4u8).prop_map(
        |(which, a, b, compare, mask)| {
            let control = TIMERS[which];
            let registers = if which == 1 {
                [0x89, 0x88, 0x8B, 0x8A]
            } else {
                [control + 3, control + 3, control + 4, control + 4]
            };
            let mut words: Vec<u16> = registers
                .into_iter()
                .zip(compare)
                .flat_map(|(address, value)| store(address, value))
                .collect();
            // Half of them count up to MAX.
            let (a, b) = if compare[0] % 2 == 0 { (a & 0xF0, b & 7) } else { (a, b & 0x1F) };
            words.extend(store(control, a));
            words.extend(store(control + 1, b));
            // Mostly no interrupt, else that of the overflow.
            words.extend(store(0x6E + which as u16, u8::from(mask == 0)));
            words
        },
    )
}

/// Reads of counters and flags of timers, of pins and of the memory.
fn reads() -> impl Strategy<Value = Vec<u16>> {
    prop_oneof![
        4 => (0..3usize, 16..28u16).prop_map(|(which, d)| load(d, COUNTERS[which])),
        2 => (16..28u16).prop_map(|d| vec![0xB506 | (d & 15) << 4]),
        2 => (16..27u16).prop_map(|d| [load(d, 0x84), load(d + 1, 0x85)].concat()),
        1 => (0..3u16, 16..28u16).prop_map(|(which, d)| load(d, 0x35 + which)),
        1 => (16..28u16, 0x23..0x2Cu16).prop_map(|(d, address)| load(d, address)),
        2 => (16..28u16, 0x100..0x104u16).prop_map(|(d, address)| load(d, address)),
    ]
}

/// Arithmetic, which a loop may do with what it has read.
fn work() -> impl Strategy<Value = Vec<u16>> {
    let opcode = prop::sample::select(vec![
        0x0C00, 0x1C00, 0x1800, 0x0800, 0x2000, 0x2800, 0x2400, 0x2C00, 0x1400, 0x0400,
    ]);
    let with_constant = prop::sample::select(vec![0x5000, 0x4000, 0x7000, 0x6000, 0x3000, 0xE000]);
    let alone = prop::sample::select(vec![0, 1, 2, 3, 5, 6, 7, 10]);
    prop_oneof![
        6 => (opcode, 16..28u16, 16..28u16).prop_map(|(opcode, d, r)| vec![two(opcode, d, r)]),
        6 => (with_constant, 16..28u16, any::<u8>()).prop_map(|(opcode, d, k)| vec![immediate(opcode, d, k)]),
        3 => (alone, 16..28u16).prop_map(|(low, d)| vec![0x9400 | d << 4 | low]),
        // adiw and sbiw r24 or r26, movw, mul, bst, bld
        1 => (0..2u16, 0..2u16, 0..16u16).prop_map(|(sub, pair, k)| vec![0x9600 | sub << 8 | pair << 4 | k]),
        1 => (8..14u16, 8..14u16).prop_map(|(d, r)| vec![0x0100 | d << 4 | r]),
        1 => (16..28u16, 16..28u16).prop_map(|(d, r)| vec![two(0x9C00, d, r), 0x2D00 | (d & 15) << 4]),
        1 => (16..28u16, 0..8u16, 16..28u16).prop_map(|(d, bit, e)| vec![0xFA00 | d << 4 | bit, 0xF800 | e << 4 | bit]),
        // push, pop; sts
        1 => (16..28u16, 16..28u16).prop_map(|(r, d)| vec![0x920F | r << 4, 0x900F | d << 4]),
        1 => (16..28u16, 0x100..0x104u16).prop_map(|(r, address)| vec![0x9200 | r << 4, address]),
        // in r15, SREG; cli; …; out SREG, r15
        1 => (16..28u16).prop_map(|d| [vec![0xB6FF, 0x94F8], load(d, 0x46), vec![0xBEFF]].concat()),
        // ldi r30, 0; ldi r31, 1; ldd; std
        1 => (16..28u16, 0..4u16).prop_map(|(d, q)| vec![0xE0E0, 0xE0F1, 0x8000 | d << 4 | q, 0x8204 | d << 4 | q]),
        // lpm
        1 => (16..28u16, 0..8u16).prop_map(|(d, low)| vec![0xE0E0 | low, 0xE0F0, 0x9004 | d << 4]),
    ]
}

/// A jump elsewhere if a condition holds, and back to the start if not: a branch over a jump out, or a skip.
#[derive(Clone, Debug)]
enum Decision {
    Flag(u16),
    Bit(u16, u16),
    Flags(u16, u16),
}

fn decision() -> impl Strategy<Value = Decision> {
    prop_oneof![
        4 => (0..16u16).prop_map(Decision::Flag),
        1 => (16..28u16, 0..16u16).prop_map(|(d, bit)| Decision::Bit(d, bit)),
        1 => (0..3u16, 0..6u16).prop_map(|(which, bit)| Decision::Flags(which, bit)),
    ]
}

impl Decision {
    /// Words that pass over the next word or not.
    fn word(&self) -> u16 {
        match *self {
            Self::Flag(flag) => 0xF000 | (flag & 8) << 7 | 1 << 3 | flag & 7,
            Self::Bit(d, bit) => 0xFC00 | (bit & 8) << 6 | d << 4 | bit & 7,
            Self::Flags(which, bit) => 0x9900 | (bit & 1) << 9 | (0x15 + which) << 3 | bit >> 1,
        }
    }
}

/// A program: timers, then two loops one behind the other, and those again. The overflows' interrupts count in memory.
fn program(timers: &[Vec<u16>], loops: &[(Vec<Vec<u16>>, Decision, bool)]) -> Vec<u16> {
    let mut words = vec![0; 64];
    // rjmp to the start, and at each vector a jump to what counts: lds r14, 0x103; inc r14; sts 0x103, r14; reti
    for vector in 0..26 {
        words[2 * vector] = 0xC000 | (if vector == 0 { 64 - 1 } else { 54 - 2 * vector as u16 - 1 }) & 0xFFF;
    }
    words[54..60].copy_from_slice(&[0x90E0, 0x0103, 0x94E3, 0x92E0, 0x0103, 0x9518]);
    words.extend(timers.concat());
    // sei
    words.push(0x9478);
    let first = words.len();
    for (pieces, decision, call) in loops {
        let start = words.len();
        if *call {
            // rcall .+2; rjmp over the function; the function; ret
            words.extend([0xD001, 0xC000]);
            let jump = words.len() - 1;
            let body = pieces.concat();
            words.extend(&body);
            words.push(0x9508);
            words[jump] = 0xC000 | (body.len() as u16 + 1);
        } else {
            words.extend(pieces.concat());
        }
        words.push(decision.word());
        words.push(0xC000 | (start as i32 - words.len() as i32 - 1) as u16 & 0xFFF);
    }
    words.push(0xC000 | (first as i32 - words.len() as i32 - 1) as u16 & 0xFFF);
    words
}

fn piece() -> impl Strategy<Value = Vec<u16>> {
    prop_oneof![1 => reads(), 2 => work()]
}

fn body() -> impl Strategy<Value = (Vec<Vec<u16>>, Decision, bool)> {
    (reads(), prop::collection::vec(piece(), 0..10), decision(), any::<bool>()).prop_map(
        |(read, mut rest, decision, call)| {
            rest.insert(0, read);
            (rest, decision, call)
        },
    )
}

fn cases() -> ProptestConfig {
    let cases = std::env::var("BAUDBOT_AVR_PROGRAMS").map_or(300, |cases| cases.parse().unwrap());
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn loops_that_read_counters_leave_the_same_bits_when_they_are_gone_through(
        timers in prop::collection::vec(timer(), 1..4), loops in prop::collection::vec(body(), 1..3),
        pieces in prop::collection::vec(1..30_000u64, 4), level: bool,
    ) {
        let part = Part::Atmega328P;
        let words = program(&timers, &loops);
        let program = Program::from_words(part, &words).unwrap();
        let mut quick = Chip::new(&program, Fuses::external_clock(part), Supply::ARDUINO);
        let start = quick.next_event().unwrap_or(0);
        quick.run(start, &mut Bare);
        for (at, length) in pieces.iter().enumerate() {
            let external = if (at % 2 == 0) == level { External::High } else { External::Low };
            quick.set_pin(Pin::new(Port::D, at as u8).unwrap(), external, quick.now() + length).unwrap();
        }
        let mut slow = quick.clone();
        for length in pieces {
            let until = quick.now() + length;
            quick.run(until, &mut Bare);
            slow.run_to(until, &[], &mut Bare);
            prop_assert!(quick == slow, "{:04x?} until {}", words, until);
        }
    }
}
