//! Programs of chance: whatever they do to the peripherals, nothing panics, and all ways to run them agree.

use baudbot_avr::usart::{BitLength, Frame};
use baudbot_avr::{
    AnalogInput, Bare, Board, Chip, Direction, Drive, External, Fuses, Part, Pin, Port, Program, Supply,
};
use proptest::prelude::*;

/// A board that hands out changing values, and adds up what it is told.
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
    let fuses = Fuses { low: if slow_clock { 0x40 } else { 0xC0 }, ..Fuses::factory(part) };
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
