//! Programs of chance: whatever they do to the peripherals, nothing panics, and all ways to run them agree.

use baudbot_avr::usart::{BitLength, Frame};
use baudbot_avr::{
    AnalogInput, Bare, Board, Chip, Direction, Drive, External, Fuses, Part, Pin, Port, Program, Supply,
};
use proptest::prelude::*;

/// A board that hands out changing values, and adds up all that is reported to it.
#[derive(Clone, Debug, Default, PartialEq)]
struct Sum(u64);

impl Sum {
    fn note(&mut self, value: u64, at: u64) {
        self.0 = self.0.wrapping_mul(31).wrapping_add(value).wrapping_mul(31).wrapping_add(at);
    }
}

impl Board for Sum {
    fn pin_changed(&mut self, pin: Pin, drive: Drive, at: u64) {
        self.note(u64::from(pin.bit()) * 4 + drive as u64, at);
    }

    fn analog_microvolts(&mut self, _input: AnalogInput, at: u64) -> u32 {
        (at % 5_000_000) as u32
    }

    fn character_sent(&mut self, sent: &baudbot_avr::usart::Sent) {
        self.note(sent.frame.data().into(), sent.start);
    }

    fn spi_transfer(&mut self, byte: u8, at: u64) -> u8 {
        self.note(byte.into(), at);
        byte.wrapping_add(1)
    }

    fn twi_address(&mut self, address: u8, _direction: Direction, at: u64) -> bool {
        self.note(address.into(), at);
        address.is_multiple_of(2)
    }

    fn twi_write(&mut self, byte: u8, at: u64) -> bool {
        self.note(byte.into(), at);
        true
    }

    fn twi_read(&mut self, _last: bool, at: u64) -> u8 {
        at as u8
    }
}

/// A few words: any one, or a write to a register of a peripheral, or a read of one.
fn words() -> impl Strategy<Value = Vec<u16>> {
    let write = |address: u16, value: u8| {
        vec![0xE000 | u16::from(value & 0xF0) << 4 | u16::from(value & 0x0F), 0x9300, address]
    };
    prop_oneof![
        2 => any::<u16>().prop_map(|word| vec![word]),
        6 => (0x20u16..0xC8, any::<u8>()).prop_map(move |(address, value)| write(address, value)),
        2 => (0x20u16..0xC8).prop_map(|address| vec![0x9110, address]),
        1 => Just(vec![0x9478]),
        1 => Just(vec![0x9588]),
        // sbis; rjmp .-4 on a port, and lds; sbrs; rjmp .-8 on a status
        1 => (0u16..11, 0u16..8).prop_map(|(port, bit)| vec![0x9B00 | port << 3 | bit, 0xCFFE]),
        // in; out; sbis; rjmp .-8 on a port, and push; pop; lds; and; breq .-12
        1 => (0u16..8).prop_map(|bit| vec![0xB105, 0xB905, 0x9B18 | bit, 0xCFFC]),
        // sbiw r24, 1; brne .-4, and subi r18, 1; sbci r24, 0; sbci r25, 0; brne .-8
        1 => Just(vec![0x9701, 0xF7F1]),
        1 => Just(vec![0x5021, 0x4080, 0x4090, 0xF7E1]),
        1 => Just(vec![0x930F, 0x910F, 0x9120, 0x0102, 0x2322, 0xF3D1]),
        1 => (0u16..8, 0..4usize).prop_map(|(bit, at)| vec![0x9120, [0xC0, 0x7A, 0x4D, 0x101][at], 0xFF20 | bit, 0xCFFC]),
    ]
}

fn chip(words: &[u16], slow_clock: bool) -> Chip {
    // A small flash is loaded quickly, and `SPM` works in all of it.
    let part = Part::Atmega48A;
    // One with an external clock divided by 8, one with an internal oscillator, which leaves its pins to a crystal.
    let fuses = Fuses { low: if slow_clock { 0x40 } else { 0xC2 }, ..Fuses::factory(part) };
    Chip::new(&Program::from_words(part, words).unwrap(), fuses, Supply::ARDUINO)
}

fn give_inputs(chip: &mut Chip) {
    let bit = BitLength::of_baud(16_000_000, 115_200).unwrap();
    for at in 0..10 {
        let start = chip.now() + 1000 + 1700 * at;
        chip.receive(Frame::byte(at as u8), start, bit).unwrap();
        let level = if at % 2 == 0 { External::High } else { External::Low };
        for port in Port::ALL {
            chip.set_pin(Pin::new(port, (at % 8) as u8).unwrap(), level, start + 331).unwrap();
        }
    }
}

/// A whole flash by chance: words of each instruction, accesses to the peripherals among them.
fn flash(part: Part, pieces: &[Vec<u16>], seed: u64) -> Vec<u16> {
    let mut random = seed | 1;
    let mut next = move || {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        random
    };
    let mut words = Vec::new();
    while words.len() < part.properties().flash_bytes as usize / 2 {
        if next() % 3 == 0 {
            words.push((next() >> 20) as u16);
        } else {
            words.extend_from_slice(&pieces[next() as usize % pieces.len()]);
        }
    }
    words.truncate(part.properties().flash_bytes as usize / 2);
    words
}

fn stored(chip: &Chip) -> Chip {
    postcard::from_bytes(&postcard::to_allocvec(chip).unwrap()).expect("what was saved is loaded")
}

/// The first fields in which two chips differ.
fn difference(one: &Chip, other: &Chip) -> String {
    let (one, other) = (format!("{one:#?}"), format!("{other:#?}"));
    let differ = one.lines().zip(other.lines()).enumerate().filter(|(_, (one, other))| one != other);
    differ.take(5).map(|(at, (one, other))| format!("line {at}: {one} and {other}; ")).collect()
}

/// More with `BAUDBOT_AVR_PROGRAMS`.
fn cases(usual: u32) -> ProptestConfig {
    let cases = std::env::var("BAUDBOT_AVR_PROGRAMS").map_or(usual, |cases| cases.parse().unwrap());
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(cases(6))]

    #[test]
    fn a_flash_by_chance_runs_a_million_cycles_on_each_part_and_from_the_middle_to_the_same_bits(
        pieces in prop::collection::vec(words(), 100), seed: u64, clock in 0..4u8,
        middles in prop::collection::vec(0..1_000_000u64, 3),
    ) {
        for part in Part::ALL {
            // Without CKDIV8 and with it, a fast start and one of 65 ms; the boot section or the application.
            let fuses = Fuses { low: [0xC0, 0x40, 0xE2, 0xFF][usize::from(clock)], ..Fuses::factory(part) };
            let program = Program::from_words(part, &flash(part, &pieces, seed)).unwrap();
            let mut whole = Chip::new(&program, fuses, Supply::ARDUINO);
            let start = whole.next_event().unwrap();
            whole.run(start, &mut Bare);
            give_inputs(&mut whole);
            let mut parts = whole.clone();
            let (mut sum, mut sum_of_parts) = (Sum::default(), Sum::default());
            let end = start + 1_000_000;
            // BREAK ends a run.
            while whole.now() < end {
                whole.run(end, &mut sum);
            }
            let mut middles = middles.clone();
            middles.sort_unstable();
            for until in middles.into_iter().map(|middle| start + middle).chain([end]) {
                while parts.now() < until {
                    parts.run(until, &mut sum_of_parts);
                }
                parts = stored(&parts);
            }
            prop_assert_eq!(&sum, &sum_of_parts, "{:?}", part);
            prop_assert!(whole == parts, "{:?}: {}", part, difference(&whole, &parts));
        }
    }
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn a_damaged_chip_in_the_middle_of_any_program_is_refused_or_runs(
        program in prop::collection::vec(words(), 1..60), slow_clock: bool, until in 0u64..40_000,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..5),
    ) {
        let mut chip = chip(&program.concat(), slow_clock);
        give_inputs(&mut chip);
        chip.run(until, &mut Sum::default());
        let mut bytes = postcard::to_allocvec(&chip).unwrap();
        let places: Vec<usize> = (8..bytes.len() - 8)
            .filter(|&at| bytes[at - 8..at + 8].iter().any(|&byte| byte != bytes[at]))
            .collect();
        for (place, value) in changes {
            bytes[*place.get(&places)] = value;
        }
        if let Ok(mut forged) = postcard::from_bytes::<Chip>(&bytes) {
            let until = forged.now() + 40_000;
            for _ in 0..10 {
                forged.run(until, &mut Sum::default());
            }
            prop_assert!(forged.now() >= until || postcard::to_allocvec(&forged).is_ok());
        }
    }
}

proptest! {
    #[test]
    fn any_program_runs_the_same_at_once_in_parts_and_instruction_by_instruction(
        program in prop::collection::vec(words(), 1..60), slow_clock: bool, part in 300u64..9000,
    ) {
        const END: u64 = 40_000;
        let mut whole = chip(&program.concat(), slow_clock);
        give_inputs(&mut whole);
        let (mut parts, mut slow) = (whole.clone(), whole.clone());
        let mut sums = [Sum::default(), Sum::default(), Sum::default()];
        while whole.now() < END {
            whole.run(END, &mut sums[0]);
        }
        while parts.now() < END {
            parts.run((parts.now() + part).min(END), &mut sums[1]);
            parts = postcard::from_bytes(&postcard::to_allocvec(&parts).unwrap()).unwrap();
        }
        while slow.now() < END {
            slow.run_to(END, &[], &mut sums[2]);
        }
        prop_assert_eq!(&sums[0], &sums[1]);
        prop_assert_eq!(&sums[0], &sums[2]);
        prop_assert!(whole == parts, "in parts");
        prop_assert!(whole == slow, "instruction by instruction");
        whole.run(END + 1, &mut Bare);
    }
}
