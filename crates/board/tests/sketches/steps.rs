//! A stretch that is passed over is the same as one that is executed.

use baudbot_avr::usart::{BitLength, Frame, Sent};
use baudbot_avr::{AnalogInput, Board, Chip, Drive, External, Pin, Port, Pwm, Warning};

use crate::sketches::bench::{FUSES, chip};

const MS: u64 = 16_000;

/// All reports of a chip, with their instants.
#[derive(Debug, Default, PartialEq)]
struct Told {
    pins: Vec<(Pin, Drive, u64)>,
    shapes: Vec<(Pin, Option<Pwm>, u64)>,
    sent: Vec<Sent>,
    warnings: Vec<(Warning, u64)>,
    measured: Vec<(AnalogInput, u64)>,
}

impl Board for Told {
    fn pin_changed(&mut self, pin: Pin, drive: Drive, at: u64) {
        self.pins.push((pin, drive, at));
    }

    fn pwm_changed(&mut self, pin: Pin, pwm: Option<Pwm>, at: u64) {
        self.shapes.push((pin, pwm, at));
    }

    fn character_sent(&mut self, sent: &Sent) {
        self.sent.push(*sent);
    }

    fn analog_microvolts(&mut self, input: AnalogInput, at: u64) -> u32 {
        self.measured.push((input, at));
        (at % 5_000_000) as u32
    }

    fn warn(&mut self, warning: Warning, at: u64) {
        self.warnings.push((warning, at));
    }
}

/// Characters and edges that fall anywhere, in the next 50 ms.
fn disturb(chip: &mut Chip, round: u64) {
    let length =
        BitLength::of_baud(16_000_000, if round.is_multiple_of(2) { 115_200 } else { 57_600 }).unwrap();
    for place in 0..8 {
        let at = chip.now() + 1 + (round * 7919 + place * 104_729) % (50 * MS);
        let external = if (round + place).is_multiple_of(2) { External::Low } else { External::High };
        let port = if place.is_multiple_of(2) { Port::D } else { Port::B };
        chip.set_pin(Pin::new(port, 2 + (place % 3) as u8).unwrap(), external, at).unwrap();
        let byte = [0xF0, 0x6B, 0xF7, b'7', b' ', b'3', b'\n', 0xF9][((round + place) % 8) as usize];
        chip.receive(Frame::byte(byte), chip.now() + place * 5 * MS + 1, length).unwrap();
    }
}

#[test]
#[ignore = "needs BAUDBOT_SKETCHES"]
fn each_program_does_the_same_when_it_is_gone_through_step_by_step() {
    let folder = std::env::var("BAUDBOT_SKETCHES").unwrap();
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|file| file.unwrap().file_name().into_string().unwrap())
        .filter(|file| file.ends_with(".hex"))
        .collect();
    files.sort();
    assert!(files.len() > 20, "{files:?}");
    for file in files {
        let mut quick = chip(&file, FUSES).unwrap();
        let mut slow = quick.clone();
        let mut told = (Told::default(), Told::default());
        for round in 0..20 {
            disturb(&mut quick, round);
            disturb(&mut slow, round);
            let until = (round + 1) * 50 * MS + round * 13;
            quick.run(until, &mut told.0);
            slow.run_to(until, &[], &mut told.1);
            assert!(quick == slow, "{file}, round {round}");
        }
        assert_eq!(told.0, told.1, "{file}");
    }
}
