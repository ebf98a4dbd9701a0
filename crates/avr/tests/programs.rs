//! Programs in C, built by avr-gcc (`programs/build.py`), on a board that writes down what they do.

use baudbot_avr::usart::{BitLength, Frame, Sent};
use baudbot_avr::{
    AnalogInput, Bare, Board, Channel, Chip, Drive, External, Fuses, Part, Pin, Port, Program, Pwm,
    PwmReport, Sleep, Stop, Supply, Timer,
};

const HZ: u64 = 16_000_000;
const FILES: [&str; 11] = [
    "adc.hex",
    "blink.hex",
    "capture.hex",
    "compute.hex",
    "echo_115200.hex",
    "echo_9600.hex",
    "eeprom.elf",
    "peripherals.hex",
    "pwm.hex",
    "sleep.hex",
    "watchdog.hex",
];
const GPIOR: [u16; 3] = [0x3E, 0x4A, 0x4B];

fn chip(file: &str) -> Chip {
    chip_with(file, Fuses::external_clock(Part::Atmega328P))
}

fn chip_with(file: &str, fuses: Fuses) -> Chip {
    Chip::new(&program(file), fuses, Supply::ARDUINO)
}

fn program(file: &str) -> Program {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/programs").join(file);
    Program::parse(Part::Atmega328P, &std::fs::read(path).unwrap()).unwrap()
}

fn pin(port: Port, bit: u8) -> Pin {
    Pin::new(port, bit).unwrap()
}

fn ms(milliseconds: u64) -> u64 {
    milliseconds * HZ / 1000
}

#[derive(Default)]
struct Notes {
    pins: Vec<(Pin, Drive, u64)>,
    shapes: Vec<(Pin, Option<Pwm>)>,
    sent: Vec<Sent>,
}

impl Notes {
    /// Instants at which a pin changed.
    fn changes(&self, pin: Pin) -> Vec<u64> {
        self.pins.iter().filter(|(changed, ..)| *changed == pin).map(|&(_, _, at)| at).collect()
    }
}

impl Board for Notes {
    fn pin_changed(&mut self, pin: Pin, drive: Drive, at: u64) {
        self.pins.push((pin, drive, at));
    }

    fn pwm_changed(&mut self, pin: Pin, pwm: Option<Pwm>, _at: u64) {
        self.shapes.push((pin, pwm));
    }

    fn character_sent(&mut self, sent: &Sent) {
        self.sent.push(*sent);
    }

    /// Each channel has a voltage of its own.
    fn analog_microvolts(&mut self, input: AnalogInput, _at: u64) -> u32 {
        match input {
            AnalogInput::Channel(channel) => 500_000 * u32::from(channel),
            AnalogInput::Temperature | AnalogInput::Positive | AnalogInput::Negative => 0,
        }
    }
}

#[test]
fn an_led_blinks_with_the_overflows_of_a_timer_to_the_cycle() {
    let mut chip = chip("blink.hex");
    let mut notes = Notes::default();
    chip.run(ms(100), &mut notes);
    let changes = notes.changes(pin(Port::B, 5));
    assert!(changes.len() > 90, "{changes:?}");
    for pair in changes[1..].windows(2) {
        // The loop is one instruction of two cycles, and 256 * 64 is even: each interrupt waits as long as the last.
        assert_eq!(pair[1] - pair[0], 256 * 64);
    }
}

#[test]
fn channels_are_converted_and_sent_one_after_another() {
    let mut chip = chip("adc.hex");
    let mut notes = Notes::default();
    chip.run(ms(20), &mut notes);
    let bytes: Vec<u8> = notes.sent.iter().map(|sent| sent.frame.data() as u8).collect();
    let results: Vec<u16> = bytes.chunks_exact(2).map(|two| u16::from_be_bytes([two[0], two[1]])).collect();
    assert_eq!(results[..8], [0, 102, 204, 307, 409, 512, 0, 102]);
    for sent in &notes.sent {
        assert_eq!(sent.bit, 26 * 16);
    }
}

#[test]
fn characters_are_echoed_at_9600_baud_and_with_an_error_of_2_percent_at_115200() {
    for (file, baud, bit) in [("echo_9600.hex", 9600, 104 * 16), ("echo_115200.hex", 115_200, 17 * 8)] {
        let mut chip = chip(file);
        let mut notes = Notes::default();
        chip.run(ms(1), &mut notes);
        let length = BitLength::of_baud(HZ as u32, baud).unwrap();
        let mut start = chip.now() + 777;
        for byte in b'a'..=b'z' {
            chip.receive(Frame::byte(byte), start, length).unwrap();
            start += 12 * HZ / u64::from(baud);
            chip.run(start, &mut notes);
            start = chip.now();
        }
        chip.run(start + ms(3), &mut notes);
        let bytes: Vec<u8> = notes.sent.iter().map(|sent| sent.frame.data() as u8).collect();
        assert_eq!(bytes, (b'b'..=b'{').collect::<Vec<_>>(), "{baud} baud");
        assert!(notes.sent.iter().all(|sent| sent.bit == bit));
    }
}

#[test]
fn a_sender_of_another_baud_rate_is_told_frame_errors() {
    let mut chip = chip("echo_9600.hex");
    let mut notes = Notes::default();
    chip.run(ms(1), &mut notes);
    chip.receive(Frame::byte(0x00), chip.now(), BitLength::of_baud(HZ as u32, 4800).unwrap()).unwrap();
    chip.run(ms(5), &mut notes);
    assert_eq!(notes.sent[0].frame.data(), u16::from(b'F'));
}

#[test]
fn motors_a_servo_and_a_tone_are_told_by_their_shapes() {
    let mut chip = chip("pwm.hex");
    for (timer, channel) in
        [(Timer::T0, Channel::A), (Timer::T0, Channel::B), (Timer::T1, Channel::A), (Timer::T2, Channel::B)]
    {
        chip.set_pwm_report(timer, channel, PwmReport::Shape);
    }
    let mut notes = Notes::default();
    chip.run(ms(100), &mut notes);
    let last = |pin: Pin| notes.shapes.iter().rfind(|(shaped, _)| *shaped == pin).unwrap().1.unwrap();
    assert_eq!(last(pin(Port::D, 6)), Pwm { high: 64 * 8, period: 256 * 8 });
    assert_eq!(last(pin(Port::D, 5)), Pwm { high: 192 * 8, period: 256 * 8 });
    assert_eq!(last(pin(Port::B, 1)), Pwm { high: 3000 * 8, period: 40_000 * 8 });
    assert_eq!(last(pin(Port::D, 3)), Pwm { high: 142 * 128, period: 2 * 142 * 128 });
    assert!(notes.pins.iter().all(|&(_, _, at)| at < ms(1)), "edges are not told: {:?}", notes.pins);
}

#[test]
fn motors_a_servo_and_a_tone_are_told_by_their_edges() {
    let mut chip = chip("pwm.hex");
    let mut notes = Notes::default();
    chip.run(ms(100), &mut notes);
    for (pin, high, period) in [
        (pin(Port::D, 6), 64 * 8, 256 * 8),
        (pin(Port::D, 5), 192 * 8, 256 * 8),
        (pin(Port::B, 1), 3000 * 8, 40_000 * 8),
        (pin(Port::D, 3), 142 * 128, 2 * 142 * 128),
    ] {
        let rises: Vec<u64> = notes
            .pins
            .iter()
            .filter(|(own, drive, _)| *own == pin && *drive == Drive::High)
            .map(|one| one.2)
            .collect();
        let falls: Vec<u64> = notes
            .pins
            .iter()
            .filter(|(own, drive, at)| *own == pin && *drive == Drive::Low && *at > rises[1])
            .map(|one| one.2)
            .collect();
        assert!(rises.len() >= 4, "{pin:?}: {rises:?}");
        assert!(rises[1..].windows(2).all(|two| two[1] - two[0] == period), "{pin:?}");
        assert!(rises[1..].iter().zip(&falls).all(|(rise, fall)| fall - rise == high), "{pin:?}");
    }
}

#[test]
fn a_period_at_icp1_is_measured_to_the_cycle() {
    let mut chip = chip("capture.hex");
    chip.run(ms(1), &mut Bare);
    let icp = pin(Port::B, 0);
    for at in 0..8 {
        let edge = ms(2) + 12_345 * at;
        chip.set_pin(icp, External::High, edge).unwrap();
        chip.set_pin(icp, External::Low, edge + 5000).unwrap();
    }
    chip.run(ms(20), &mut Bare);
    let [count, low, high] = GPIOR.map(|address| chip.read_data(address, &mut Bare));
    assert_eq!((count, u16::from_le_bytes([low, high])), (8, 12_345));
}

#[test]
fn the_watchdog_resets_again_and_again_and_memory_stays() {
    let mut chip = chip("watchdog.hex");
    let mut at = 0;
    let mut seen = Vec::new();
    for _ in 0..4 {
        at += ms(8);
        chip.run(at, &mut Bare);
        seen.push([GPIOR[0], GPIOR[1]].map(|address| chip.read_data(address, &mut Bare)));
        at += ms(8) + 400;
    }
    assert_eq!(seen, [[1, 0], [8, 1], [8, 2], [8, 3]]);
}

#[test]
fn eeprom_that_an_elf_file_brings_is_read_and_written() {
    let mut chip = chip("eeprom.elf");
    let mut notes = Notes::default();
    chip.run(ms(20), &mut notes);
    assert_eq!(chip.read_data(GPIOR[0], &mut Bare), 42);
    assert_eq!(chip.read_data(GPIOR[1], &mut Bare), b'c');
    assert_eq!(chip.eeprom()[..6], [b'a', b'b', b'c', 0, 42, 0]);
    // One byte differs, and takes 3.4 ms.
    let done = notes.pins.iter().find(|(pin, ..)| pin.bit() == 0).unwrap().2;
    assert!(ms(34) < 10 * done && 10 * done < ms(35), "{done}");
}

#[test]
fn a_chip_in_power_down_costs_nothing_until_a_pin_wakes_it() {
    let mut chip = chip("sleep.hex");
    let mut notes = Notes::default();
    chip.run(ms(1), &mut notes);
    assert_eq!(chip.sleep(), Some(Sleep::PowerDown));
    assert_eq!(chip.next_event(), Some(u64::MAX));
    let cycles = chip.cycles();
    for at in [ms(1000), ms(2000), ms(60_000)] {
        let level = if at == ms(2000) { External::Open } else { External::Low };
        chip.set_pin(pin(Port::D, 7), level, at).unwrap();
    }
    assert_eq!(chip.run(ms(120_000), &mut notes), Stop::Reached);
    let changes = notes.changes(pin(Port::B, 0));
    // Made an output, and then toggled 2 times by the edges that follow the first sleep.
    let awake: Vec<u64> = changes.iter().filter(|&&at| at > ms(2)).map(|at| at / ms(1)).collect();
    assert_eq!(awake, [1000, 2000, 60_000]);
    assert!(chip.cycles() - cycles < 300);
    assert_eq!(chip.now(), ms(120_000));
}

#[test]
fn a_boot_loader_writes_an_application_and_starts_it() {
    let fuses = Fuses { high: 0xD8, ..Fuses::external_clock(Part::Atmega328P) };
    let mut chip = chip_with("bootloader.hex", fuses);
    let before = chip.clone();
    assert_eq!(chip.flash()[0], 0xFFFF);
    chip.run(ms(10), &mut Bare);
    assert_eq!(chip.read_data(GPIOR[0], &mut Bare), 0x42);
    assert_eq!(chip.read_data(GPIOR[1], &mut Bare), 0x1E);
    assert_eq!(chip.flash()[..4], [0xE402, 0xBB0E, 0xCFFF, 0xFFFF]);
    assert_eq!(before.flash()[0], 0xFFFF, "the program that others share is as it was");
}

#[test]
fn loops_that_wait_are_passed_over_to_the_same_bits_as_if_they_were_gone_through() {
    for file in FILES {
        let mut quick = chip(file);
        let mut slow = quick.clone();
        let mut notes = (Notes::default(), Notes::default());
        for chip in [&mut quick, &mut slow] {
            let length = BitLength::of_baud(HZ as u32, 9600).unwrap();
            for byte in 0..8 {
                chip.receive(Frame::byte(byte), ms(1) + 20_000 * u64::from(byte), length).unwrap();
                chip.set_pin(pin(Port::B, 0), External::High, ms(2) + 7_003 * u64::from(byte)).unwrap();
                chip.set_pin(pin(Port::B, 0), External::Low, ms(2) + 7_003 * u64::from(byte) + 3_501)
                    .unwrap();
                let level = if byte % 2 == 0 { External::Low } else { External::High };
                chip.set_pin(pin(Port::D, 7), level, ms(3) + 11_117 * u64::from(byte)).unwrap();
            }
        }
        for until in [ms(2) + 1, ms(7), ms(40) + 13] {
            quick.run(until, &mut notes.0);
            slow.run_to(until, &[], &mut notes.1);
            assert!(quick == slow, "{file}");
        }
        assert_eq!(notes.0.pins, notes.1.pins, "{file}");
        assert_eq!(notes.0.sent, notes.1.sent, "{file}");
    }
}

#[test]
fn a_chip_that_was_saved_and_loaded_anywhere_goes_on_to_the_same_bits() {
    for (file, step) in [
        ("adc.hex", 12_347),
        ("echo_9600.hex", 9_973),
        ("pwm.hex", 10_007),
        ("compute.hex", 30_011),
        ("eeprom.elf", 1_009),
    ] {
        let mut whole = chip(file);
        let mut parts = whole.clone();
        let mut notes = (Notes::default(), Notes::default());
        let length = BitLength::of_baud(HZ as u32, 9600).unwrap();
        for chip in [&mut whole, &mut parts] {
            for byte in 0..8 {
                chip.receive(Frame::byte(byte), ms(1) + 20_000 * u64::from(byte), length).unwrap();
            }
        }
        whole.run(ms(15), &mut notes.0);
        while parts.now() < ms(15) {
            let at = (parts.now() + step).min(ms(15));
            parts.run(at, &mut notes.1);
            parts = postcard::from_bytes(&postcard::to_allocvec(&parts).unwrap()).unwrap();
        }
        assert!(whole == parts, "{file}");
        assert_eq!(notes.0.pins, notes.1.pins, "{file}");
        assert_eq!(notes.0.sent, notes.1.sent, "{file}");
    }
}

#[test]
fn a_wave_at_the_pin_rxd_is_received_as_its_character_is() {
    let mut chip = chip("echo_9600.hex");
    let mut notes = Notes::default();
    chip.run(ms(1), &mut notes);
    let frame = Frame::byte(b'K');
    let rxd = pin(Port::D, 0);
    chip.set_pin(rxd, External::High, ms(1) + 100).unwrap();
    for bit in 0..u64::from(frame.bits()) {
        let level = if frame.level(bit) { External::High } else { External::Low };
        // 9600 baud: 1666.7 cycles.
        chip.set_pin(rxd, level, ms(2) + bit * 5000 / 3).unwrap();
    }
    chip.run(ms(5), &mut notes);
    let sent: Vec<u16> = notes.sent.iter().map(|sent| sent.frame.data()).collect();
    assert_eq!(sent, [u16::from(b'L')]);
}

/// A programmer on the serial cable, which speaks STK500 to a boot loader.
struct Programmer {
    chip: Chip,
    notes: Notes,
}

impl Programmer {
    /// Sends a command with the end of commands, and gives the answer.
    fn ask(&mut self, command: &[u8]) -> Vec<u8> {
        let length = BitLength::of_baud(HZ as u32, 57_600).unwrap();
        let before = self.notes.sent.len();
        for &byte in command.iter().chain(b" ") {
            let start = self.chip.now();
            self.chip.receive(Frame::byte(byte), start, length).unwrap();
            self.chip.run(start + 10 * HZ / 57_600 + 1, &mut self.notes);
        }
        self.chip.run(self.chip.now() + ms(12), &mut self.notes);
        self.notes.sent[before..].iter().map(|sent| sent.frame.data() as u8).collect()
    }
}

#[test]
#[ignore = "needs arduino-core-avr: it reads the boot loader of an Arduino Duemilanove"]
fn the_boot_loader_of_an_arduino_takes_a_program_over_the_cable_and_starts_it() {
    const LOADER: &str =
        "/usr/share/arduino/hardware/arduino/avr/bootloaders/atmega/ATmegaBOOT_168_atmega328.hex";
    let file = std::fs::read(LOADER).expect("arduino-core-avr is needed: apt-get install arduino-core-avr");
    let loader = Program::from_hex(Part::Atmega328P, &file).unwrap();
    let chip = Chip::new(&loader, Fuses { low: 0xFF, high: 0xDA, extended: 0xFD }, Supply::ARDUINO);
    let mut programmer = Programmer { chip, notes: Notes::default() };
    programmer.chip.reset_now(baudbot_avr::ResetCause::External, &mut Bare);
    // The boot loader lets its LED flash first.
    programmer.chip.run(ms(900), &mut programmer.notes);
    let done = [0x14, 0x10];
    assert_eq!(programmer.ask(&[0x30]), done, "in step");
    assert_eq!(programmer.ask(&[0x75]), [0x14, 0x1E, 0x95, 0x0F, 0x10], "the signature");
    let application = program("blink.hex");
    for (page, bytes) in application.flash().chunks(128).enumerate() {
        let [low, high] = (64 * page as u16).to_le_bytes();
        assert_eq!(programmer.ask(&[0x55, low, high]), done);
        let mut page = bytes.to_vec();
        page.resize(128, 0xFF);
        let command = [&[0x64, 0, 128, b'F'][..], &page].concat();
        assert_eq!(programmer.ask(&command), done);
    }
    assert_eq!(programmer.ask(&[0x51]), done, "the end");
    let now = programmer.chip.now();
    programmer.chip.run(now + ms(5000), &mut programmer.notes);
    let led = pin(Port::B, 5);
    let late: Vec<u64> =
        programmer.notes.changes(led).into_iter().filter(|&at| at > now + ms(4900)).collect();
    assert!(late.len() > 90 && late.windows(2).all(|two| two[1] - two[0] == 256 * 64), "{late:?}");
}

/// Places in a saved chip that are not in the middle of an empty memory.
fn outside_memories(bytes: &[u8]) -> Vec<usize> {
    (8..bytes.len() - 8).filter(|&at| bytes[at - 8..at + 8].iter().any(|&byte| byte != bytes[at])).collect()
}

proptest::proptest! {
    #[test]
    fn a_forged_chip_is_refused_or_runs(file in 0..FILES.len(), changes: Vec<(proptest::sample::Index, u8)>) {
        let mut chip = chip(FILES[file]);
        chip.receive(Frame::byte(0x55), ms(1), BitLength::of_baud(HZ as u32, 9600).unwrap()).unwrap();
        chip.set_pin(pin(Port::D, 7), External::Low, ms(3)).unwrap();
        chip.run(ms(1) + 5000, &mut Bare);
        let mut bytes = postcard::to_allocvec(&chip).unwrap();
        let places = outside_memories(&bytes);
        for (place, value) in changes {
            bytes[*place.get(&places)] = value;
        }
        if let Ok(mut forged) = postcard::from_bytes::<Chip>(&bytes) {
            let until = forged.now() + ms(1);
            forged.run(until, &mut Notes::default());
        }
    }
}
